"""The surfaces that export.py exports: materials that glTF can say, normals that repeat."""

import bpy
import numpy

from carried import Refusal, rounded, source

KINDS = ("MESH", "CURVE", "SURFACE", "FONT")  # what Blender's exporter turns into meshes


def take_materials(things, findings):
    """Gives every surface a material that glTF can say."""
    default = None
    used = {}
    for thing in things:
        if thing.type not in KINDS:
            continue
        if not thing.material_slots or any(slot.material is None for slot in thing.material_slots):
            # Blender renders a surface without a material as a Diffuse BSDF of 0.8; glTF as metal.
            default = default or _principled(bpy.data.materials.new("default"), 0.8, None)
            if not thing.material_slots:
                thing.data.materials.append(default)
            for slot in thing.material_slots:
                slot.material = slot.material or default
        for slot in thing.material_slots:
            used[slot.material.name] = slot.material
    for _, material in sorted(used.items()):
        findings.of(_take_material, material, findings.warnings)


def _take_material(material, warnings):
    where = f"material '{material.name}'"
    if not material.use_nodes:
        _principled(material, material.diffuse_color[:3], None)
        return
    output = material.node_tree.get_output_node("CYCLES")
    shader, _ = source(output.inputs["Surface"]) if output else (None, None)
    if shader is None or shader.type not in ("BSDF_DIFFUSE", "BSDF_PRINCIPLED"):
        found = "nothing" if shader is None else f"a {shader.bl_label} node"
        raise Refusal(f"{where}: its surface is {found}; occlab takes a Diffuse BSDF or a "
                      "Principled BSDF")
    if output.inputs["Displacement"].is_linked:
        warnings.append(f"{where}: its displacement is not exported")
    if shader.inputs["Normal"].is_linked:
        warnings.append(f"{where}: its normal or bump map is not rendered")
    diffuse = shader.type == "BSDF_DIFFUSE"
    colour = shader.inputs["Color" if diffuse else "Base Color"]
    texture, _ = source(colour)
    if texture is not None:
        _check_texture(texture, where)
    elif any(not 0.0 <= channel <= 1.0 for channel in colour.default_value[:3]):
        raise Refusal(f"{where}: colour {list(map(rounded, colour.default_value[:3]))}; an albedo "
                      "lies in [0, 1]")
    if diffuse:
        if shader.inputs["Roughness"].is_linked or shader.inputs["Roughness"].default_value > 0:
            warnings.append(f"{where}: its Oren-Nayar roughness is rendered as 0 (Lambert)")
        _principled(material, colour.default_value[:3], texture)
        return
    masked = material.blend_method == "CLIP"
    if masked and shader.inputs["Alpha"].is_linked:
        _check_alpha(shader, texture, where)
    for name, lambert in (("Metallic", 0.0), ("Transmission", 0.0), ("Subsurface", 0.0),
                          ("Sheen", 0.0), ("Clearcoat", 0.0), ("Alpha", 1.0)):
        if name == "Alpha" and masked:
            continue
        if shader.inputs[name].is_linked or shader.inputs[name].default_value != lambert:
            warnings.append(f"{where}: {name} is ignored; occlab renders the base colour as "
                            "Lambertian and opaque")
    emits = [shader.inputs["Emission"], shader.inputs["Emission Strength"]]
    if all(each.is_linked for each in emits) or (
            (emits[0].is_linked or any(emits[0].default_value[:3]))
            and (emits[1].is_linked or emits[1].default_value != 0)):
        warnings.append(f"{where}: its emission is ignored; occlab renders no glowing surfaces")


def _check_alpha(shader, texture, where):
    """A mask is the alpha of the colour's own image: glTF has one texture for both."""
    found, output = source(shader.inputs["Alpha"])
    if texture is None or found != texture or output.name != "Alpha":
        raise Refusal(f"{where}: its Alpha comes from a {found.bl_label} node; occlab takes the "
                      "Alpha of the Image Texture that is its Base Color")


def _check_texture(texture, where):
    if texture.type != "TEX_IMAGE":
        raise Refusal(f"{where}: its colour comes from a {texture.bl_label} node; occlab takes a "
                      "constant or an Image Texture (bake it)")
    if texture.image is None or not texture.image.has_data and not texture.image.size[0]:
        raise Refusal(f"{where}: its Image Texture has no image, or the file is missing")
    coordinates, output = source(texture.inputs["Vector"])
    if coordinates is not None and coordinates.type != "UVMAP" and (
            (coordinates.type, output.name) != ("TEX_COORD", "UV")):
        raise Refusal(f"{where}: its Image Texture is placed by {coordinates.bl_label} "
                      f"'{output.name}'; occlab takes UV coordinates, unmapped")


def _principled(material, colour, texture):
    """Makes the material a matt Principled BSDF, which glTF's exporter understands."""
    if material.library is not None:
        raise Refusal(f"material '{material.name}': linked from {material.library.filepath}; "
                      "make it local (Object, Relations, Make Local)")
    material.use_nodes = True
    tree = material.node_tree
    for node in [node for node in tree.nodes if node.type in ("OUTPUT_MATERIAL", "BSDF_PRINCIPLED",
                                                             "BSDF_DIFFUSE")]:
        tree.nodes.remove(node)
    shader = tree.nodes.new("ShaderNodeBsdfPrincipled")
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs["BSDF"], output.inputs["Surface"])
    rgb = [colour] * 3 if isinstance(colour, float) else list(colour)
    shader.inputs["Base Color"].default_value = (*rgb, 1.0)
    shader.inputs["Roughness"].default_value = 1.0
    if texture is not None:
        tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    return material


def make_normals_repeatable(things):
    """Has smooth normals computed face fan by face fan instead of summed in thread order.

    Blender adds up a smooth vertex's normal from several threads, so that its last bit changes from
    run to run; with Auto Smooth it walks the faces round the vertex in order. At 180 degrees both
    mean the same where all faces are smooth and every edge joins two faces of one orientation.
    """
    graph = bpy.context.evaluated_depsgraph_get()
    meshes = {}
    for thing in things:
        if thing.type == "MESH" and not thing.data.use_auto_smooth:
            meshes.setdefault(thing.data.name_full, []).append(thing)
    for users in meshes.values():
        if all(_one_smooth_skin(thing.evaluated_get(graph).data) for thing in users):
            users[0].data.use_auto_smooth = True
            users[0].data.auto_smooth_angle = numpy.pi


def _one_smooth_skin(mesh):
    smooth = numpy.empty(len(mesh.polygons), bool)
    mesh.polygons.foreach_get("use_smooth", smooth)
    sharp = numpy.empty(len(mesh.edges), bool)
    mesh.edges.foreach_get("use_edge_sharp", sharp)
    if mesh.has_custom_normals or not smooth.all() or sharp.any():
        return False
    edges = numpy.empty(len(mesh.loops), numpy.int32)
    mesh.loops.foreach_get("edge_index", edges)
    starts = numpy.empty(len(mesh.loops), numpy.int32)
    mesh.loops.foreach_get("vertex_index", starts)
    directed = edges.astype(numpy.int64) * (len(mesh.vertices) + 1) + starts
    return (not len(edges) or numpy.bincount(edges).max() <= 2) and (
        len(numpy.unique(directed)) == len(directed))
