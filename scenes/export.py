"""Exports the open Blender scene to a binary glTF file for occlab.

    blender --background --factory-startup --python-exit-code 3 [FILE.blend] \
        --python scenes/export.py -- OUT.glb

FORMAT.md says what the file holds. Exit code 2: the scene cannot be exported rightly, each reason
on a line of its own on stderr; nothing is written. The file appears under its name only when it is
complete. Warnings (what was lost although the picture stays usable) go to stderr and into the file.
"""

import contextlib
import io
import math
import os
import pathlib
import sys

import bpy

try:
    import numpy  # noqa: F401  (Blender's own exporter needs it too, and says so less clearly)
except ImportError:
    print(f"occlab export: error: Blender's Python, in {sys.prefix}, has no numpy. Debian: install "
          "python3-numpy, and see that PATH's first python3 is the system's", file=sys.stderr)
    sys.exit(3)

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import carried  # noqa: E402
import geometry_check  # noqa: E402
import glb  # noqa: E402
import surfaces  # noqa: E402
from carried import Refusal, rounded, source  # noqa: E402

FORMAT = 1
LOST_SURFACES = ("META", "VOLUME", "GPENCIL", "CURVES", "POINTCLOUD")


class Findings:
    """What is wrong with a scene, all of it, so that it takes one run to learn it."""

    def __init__(self):
        self.problems = []
        self.warnings = []

    def of(self, function, *arguments):
        """function(*arguments), with its Refusal noted instead of raised."""
        try:
            return function(*arguments)
        except Refusal as refusal:
            self.problems.append(str(refusal))
            return None

    def stop_on_problems(self):
        if self.problems:
            raise Refusal("\n".join(self.problems))


def show_as_rendered(scene):
    """Makes the viewport's evaluation, which is what gets exported, the render's."""
    def collections(layer):
        yield layer
        for child in layer.children:
            yield from collections(child)

    for layer in collections(bpy.context.view_layer.layer_collection):
        layer.hide_viewport = False
    for collection in bpy.data.collections:
        collection.hide_viewport = collection.hide_render
    scene.render.simplify_subdivision = scene.render.simplify_subdivision_render
    for thing in bpy.data.objects:
        thing.hide_viewport = thing.hide_render
        if thing.name in bpy.context.view_layer.objects:
            thing.hide_set(False)
        thing.show_instancer_for_viewport = thing.show_instancer_for_render
        if thing.type in ("CURVE", "SURFACE", "FONT") and thing.data.render_resolution_u:
            thing.data.resolution_u = thing.data.render_resolution_u
        for modifier in thing.modifiers:
            modifier.show_viewport = modifier.show_render
            if modifier.type in ("SUBSURF", "MULTIRES"):
                modifier.levels = modifier.render_levels
    bpy.context.view_layer.update()


def rendered_objects():
    """The objects that get rendered, those inside instanced collections included, each once."""
    things = {thing.name_full: thing for thing in bpy.context.view_layer.objects
              if thing.visible_get()}
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        things.setdefault(instance.object.original.name_full, instance.object.original)
    return list(things.values())


def name_data_after_object(things):
    """glTF's cameras and lights carry the name of the data; occlab's users know the object's."""
    for thing in things:
        if thing.data.users > 1:
            thing.data = thing.data.copy()
    for thing in things:
        thing.data.name = "occlab renaming"  # frees the names before they are handed out
    for thing in things:
        thing.data.name = thing.name


def check_cameras(cameras, findings):
    if not cameras:
        findings.problems.append("no camera: add one; every camera becomes a view")
    for thing in cameras:
        camera = thing.data
        if camera.type != "PERSP":
            findings.problems.append(f"camera '{thing.name}': type {camera.type}; occlab takes "
                                     "perspective cameras (PERSP)")
        if camera.shift_x or camera.shift_y:
            findings.problems.append(
                f"camera '{thing.name}': lens shift ({camera.shift_x:g}, {camera.shift_y:g}); "
                "glTF has none, set both to 0")
        if camera.dof.use_dof:
            findings.warnings.append(f"camera '{thing.name}': depth of field is not rendered")


def take_lights(lights, findings):
    """Prepares the lights for glTF; returns the extras' `lights`, what glTF cannot say of them."""
    sizes = {}
    for thing in lights:
        light = thing.data
        if light.type not in ("POINT", "SUN", "SPOT"):
            findings.problems.append(
                f"light '{thing.name}': type {light.type}; occlab takes POINT, SUN and SPOT. "
                "Replace it, or disable it in renders")
            continue
        if light.use_nodes:
            findings.of(_fold_light_nodes, thing)
        light.use_custom_distance = False  # a cut-off that Cycles does not have
        if light.type == "SUN" and light.angle > 0:
            sizes[thing.name] = {"angle_degrees": rounded(math.degrees(light.angle))}
            findings.warnings.append(f"light '{thing.name}': its angle of "
                                     f"{math.degrees(light.angle):.3g} degrees is recorded, but "
                                     "occlab renders it as a direction")
        elif light.type != "SUN" and light.shadow_soft_size > 0:
            sizes[thing.name] = {"radius": rounded(light.shadow_soft_size)}
            findings.warnings.append(f"light '{thing.name}': its radius of "
                                     f"{light.shadow_soft_size:.3g} m is recorded, but occlab "
                                     "renders it as a point")
        if light.type == "SPOT" and light.spot_blend > 0:
            findings.warnings.append(f"light '{thing.name}': between its cone angles, glTF's "
                                     "fall-off differs from Blender's")
    return sizes


def _fold_light_nodes(thing):
    """Cycles multiplies a light's nodes with its colour and power; glTF's exporter does not."""
    light = thing.data
    output = light.node_tree.get_output_node("CYCLES")
    emission, _ = source(output.inputs["Surface"]) if output else (None, None)
    if emission is None or emission.type != "EMISSION" or any(
            emission.inputs[name].is_linked for name in ("Color", "Strength")):
        raise Refusal(f"light '{thing.name}': its nodes are more than one Emission node with "
                      "constant values")
    light.color = [a * b for a, b in zip(light.color, emission.inputs["Color"].default_value)]
    light.energy *= emission.inputs["Strength"].default_value
    light.use_nodes = False


def check_objects(scene, things, findings):
    if not any(thing.type in surfaces.KINDS for thing in things):
        findings.problems.append("no mesh: nothing in the scene is rendered as a surface")
    for thing in things:
        if thing.type in LOST_SURFACES:
            findings.problems.append(f"object '{thing.name}': type {thing.type} cannot be "
                                     "exported; convert it to a mesh or disable it in renders")
        if any(thing.particle_systems):
            findings.problems.append(f"object '{thing.name}': has particles; make its instances "
                                     "real (Object, Apply, Make Instances Real) or remove them")
    nodes_instances = {
        instance.parent.name for instance in bpy.context.evaluated_depsgraph_get().object_instances
        if instance.is_instance and any(m.type == "NODES" for m in instance.parent.modifiers)}
    for name in sorted(nodes_instances):
        findings.problems.append(f"object '{name}': its geometry nodes make instances, which "
                                 "would vanish; add a Realize Instances node before the output")
    if scene.unit_settings.scale_length != 1.0:
        findings.warnings.append(f"scene '{scene.name}': unit scale "
                                 f"{scene.unit_settings.scale_length:g} is ignored; lengths are "
                                 "Blender units")
    if len(bpy.data.scenes) > 1:
        findings.warnings.append(f"only scene '{scene.name}' is exported, of "
                                 f"{len(bpy.data.scenes)}")


def write_atomically(path, data):
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with open(temporary, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def blender_export(path, warnings):
    """Blender's own exporter, with everything that is off by default and needed."""
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said):
            bpy.ops.export_scene.gltf(
                filepath=str(path), export_format="GLB", convert_lighting_mode="COMPAT",
                export_cameras=True, export_lights=True, export_extras=True, export_apply=True,
                use_active_scene=True, use_visible=True, use_renderable=True, export_colors=False,
                export_animations=False, export_skins=False, export_morph=False)
        # Blender counts an image whose colour and alpha are both used as two; surfaces.py has seen to
        # it that it is one.
        warnings += [f"Blender's exporter: {line.split('WARNING:', 1)[1].strip()}"
                     for line in said.getvalue().splitlines()
                     if "WARNING:" in line and "More than one shader node tex image" not in line]
        return glb.parse(path.read_bytes())
    finally:
        path.unlink(missing_ok=True)


def export_scene(out):
    """Exports the open scene to `out`. Raises Refusal; then nothing is written."""
    if out.suffix != ".glb" or not out.parent.is_dir():
        raise Refusal(f"{out}: the output is a .glb file in a folder that exists")
    scene = bpy.context.scene
    findings = Findings()
    show_as_rendered(scene)
    things = rendered_objects()
    cameras = [thing for thing in things if thing.type == "CAMERA"]
    lights = [thing for thing in things if thing.type == "LIGHT"]
    check_cameras(cameras, findings)
    name_data_after_object(cameras)
    name_data_after_object(lights)
    check_objects(scene, things, findings)
    extras = {"format": FORMAT,
              "resolution": findings.of(carried.resolution, scene),
              "world": findings.of(carried.world, scene, out, findings.warnings),
              "lights": take_lights(lights, findings)}
    surfaces.take_materials(things, findings)
    findings.stop_on_problems()

    surfaces.make_normals_repeatable(things)
    expected = geometry_check.measure(geometry_check.blender_triangles())
    document, blob = blender_export(out.with_name(f".{out.stem}.{os.getpid()}.glb"),
                                    findings.warnings)
    blob = glb.share_equal_meshes(document, blob)
    geometry_check.check_nothing_lost(expected, document, blob)
    if extras["world"] is None:
        del extras["world"]
    extras["warnings"] = findings.warnings
    document["scenes"][0].setdefault("extras", {})["occlab"] = extras
    write_atomically(out, glb.unparse(document, blob))
    for warning in findings.warnings:
        print(f"occlab export: warning: {warning}", file=sys.stderr)
    print(f"occlab export: {out}: {expected[0]} triangles, {len(document['meshes'])} meshes, "
          f"{len(cameras)} cameras, {len(lights)} lights")


def main():
    """Exports to the path after `--`."""
    try:
        split = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
        if len(sys.argv) != split + 2:
            raise Refusal("usage: blender ... --python scenes/export.py -- OUT.glb")
        export_scene(pathlib.Path(sys.argv[-1]))
    except Refusal as refusal:
        for line in str(refusal).split("\n"):
            print(f"occlab export: error: {line}", file=sys.stderr)
        sys.stderr.flush()
        sys.exit(2)


if __name__ == "__main__":
    main()
