"""What export.py reads from a Blender scene because glTF has no place for it: the world.

Functions return what goes into the extras (FORMAT.md) and raise Refusal where a picture made from
the exported file would be wrong.
"""

import math
import os
import pathlib

import bpy

PROBES = pathlib.Path(__file__).resolve().parent / "probes"
PROBE_SUFFIXES = (".exr", ".hdr")


class Refusal(Exception):
    """Something in the file that cannot be exported rightly."""


def rounded(value):
    """A single-precision number without the digits that it does not have."""
    return float(f"{value:.7g}")


def source(socket):
    """(node, output socket) that feeds an input, or (None, None) where nothing does."""
    while socket.is_linked:
        link = socket.links[0]
        if link.from_node.type != "REROUTE":
            return link.from_node, link.from_socket
        socket = link.from_node.inputs[0]
    return None, None


def resolution(scene):
    render = scene.render
    if render.pixel_aspect_x != render.pixel_aspect_y:
        raise Refusal(f"scene '{scene.name}': pixel aspect {render.pixel_aspect_x:g}:"
                      f"{render.pixel_aspect_y:g}; occlab takes square pixels")
    return [render.resolution_x * render.resolution_percentage // 100,
            render.resolution_y * render.resolution_percentage // 100]


def world(scene, out, warnings):
    """The `world` entry of the extras, or None for a world that emits nothing."""
    blender_world = scene.world
    if blender_world is None:
        return None
    where = f"world '{blender_world.name}'"
    if not blender_world.use_nodes:
        return _constant(blender_world.color, 1.0)
    output = blender_world.node_tree.get_output_node("CYCLES")
    if output is None:
        return None
    if output.inputs["Volume"].is_linked:
        raise Refusal(f"{where}: has a volume, which occlab cannot render; unlink it")
    background, _ = source(output.inputs["Surface"])
    if background is None:
        return None
    if background.type != "BACKGROUND":
        raise Refusal(f"{where}: its surface is a {background.bl_label} node; occlab takes one "
                      "Background node, fed by an Environment Texture or a constant colour")
    if background.inputs["Strength"].is_linked:
        raise Refusal(f"{where}: the Background's Strength is computed by nodes; set a number")
    strength = background.inputs["Strength"].default_value
    image, _ = source(background.inputs["Color"])
    if image is None:
        return _constant(background.inputs["Color"].default_value, strength)
    if image.type != "TEX_ENVIRONMENT":
        raise Refusal(f"{where}: the Background's colour comes from a {image.bl_label} node; "
                      "occlab takes an Environment Texture or a constant colour (bake it into an "
                      "equirectangular EXR)")
    return {"probe": _probe(image, where, out, warnings),
            "rotation_degrees": _rotation_degrees(image, where),
            "strength": rounded(strength)}


def _constant(colour, strength):
    radiance = [rounded(channel * strength) for channel in colour[:3]]
    return {"radiance": radiance} if any(radiance) else None


def _probe(node, where, out, warnings):
    """The probe's name, or its path relative to the folder of `out`."""
    image = node.image
    if image is None:
        raise Refusal(f"{where}: its Environment Texture has no image")
    if node.projection != "EQUIRECTANGULAR":
        raise Refusal(f"{where}: the projection of '{image.name}' is {node.projection.lower()}; "
                      "occlab takes equirectangular")
    if image.packed_file is not None:
        raise Refusal(f"{where}: '{image.name}' is packed into the .blend; unpack it (File, "
                      "External Data, Unpack Resources), so that occlab can read the file")
    path = pathlib.Path(bpy.path.abspath(image.filepath, library=image.library)).resolve()
    if image.source != "FILE" or path.suffix.lower() not in PROBE_SUFFIXES:
        raise Refusal(f"{where}: '{image.name}' is not a file that occlab reads as a probe; it "
                      f"takes {' and '.join(PROBE_SUFFIXES)}")
    if not path.is_file():
        raise Refusal(f"{where}: the image file {path} is missing")
    if image.colorspace_settings.name not in ("Linear", "Raw", "Non-Color"):
        raise Refusal(f"{where}: the colour space of '{image.name}' is "
                      f"{image.colorspace_settings.name}; occlab takes Linear")

    studio = bpy.utils.system_resource("DATAFILES", path="studiolights/world")
    if path.parent == PROBES or (studio and path.parent == pathlib.Path(studio).resolve()):
        return path.stem
    try:
        relative = pathlib.Path(os.path.relpath(path, out.resolve().parent)).as_posix()
    except ValueError:
        raise Refusal(f"{where}: {path} is on another drive than {out}") from None
    if relative.startswith("../"):
        warnings.append(f"{where}: the probe {path.name} lies outside the folder of {out.name}; "
                        "moving either breaks the reference")
    return relative


def _rotation_degrees(image, where):
    """Counter-clockwise about glTF's +Y (Blender's +Z) seen from above."""
    mapping, output = source(image.inputs["Vector"])
    turned = 0.0
    if mapping is not None and mapping.type == "MAPPING":
        if any(mapping.inputs[name].is_linked for name in ("Location", "Rotation", "Scale")):
            raise Refusal(f"{where}: the Mapping node's values are computed by nodes; set numbers")
        tilt_x, tilt_y, turn = mapping.inputs["Rotation"].default_value
        moved = mapping.vector_type in ("POINT", "TEXTURE") and any(
            mapping.inputs["Location"].default_value)
        if abs(tilt_x) > 1e-6 or abs(tilt_y) > 1e-6 or moved or any(
                abs(factor - 1.0) > 1e-6 for factor in mapping.inputs["Scale"].default_value):
            raise Refusal(f"{where}: the Mapping node does more than turn about Z; occlab turns a "
                          "probe about the vertical axis only")
        # The node turns the direction that is looked up, so the picture turns the other way;
        # TEXTURE applies the inverse.
        turned = math.degrees(turn if mapping.vector_type == "TEXTURE" else -turn)
        mapping, output = source(mapping.inputs["Vector"])
        if mapping is None:
            raise Refusal(f"{where}: the Mapping node's Vector is not linked")
    if mapping is not None and (mapping.type, output.name) != ("TEX_COORD", "Generated"):
        raise Refusal(f"{where}: the Environment Texture's Vector comes from {mapping.bl_label} "
                      f"'{output.name}'; occlab takes Texture Coordinate 'Generated', with or "
                      "without a Mapping node, or no link")
    return round(turned, 5) + 0.0  # + 0.0: no negative zero
