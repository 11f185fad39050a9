"""Runs inside Blender for test_export.py: builds small scenes and exports each.

    blender ... --python tests/scenes/export_cases.py -- FOLDER

Every function called case_* starts from an empty Blender, models something and is exported to
FOLDER/<case>.glb. FOLDER/results.json says, for each, why it was refused, or null. A case may
return a function, which runs after the export; what that returns is stored as well.
"""

import json
import math
import pathlib
import sys

sys.dont_write_bytecode = True
sys.path[:0] = [str(pathlib.Path(__file__).resolve().parent)]  # Blender's Python has it not
import bpy  # noqa: E402
import numpy  # noqa: E402
from mathutils import Matrix  # noqa: E402

from case_parts import (  # noqa: E402
    BRIGHT_COLUMN, FOLDER, WIDTH, camera, cube, light, map_texture, node_world, render_towards,
    small_probe)
import refused_cases  # noqa: E402
import export  # noqa: E402
import modelling  # noqa: E402
import texturing  # noqa: E402


def case_modifiers_and_instances():
    """A cube whose render and viewport levels differ; copies with and without modifiers."""
    camera()
    first = cube("subdivided")
    second = modelling.add("subdivided too", first.data, location=(4, 0, 0))
    for thing in (first, second):
        subdivide = thing.modifiers.new("subdivide", "SUBSURF")
        subdivide.levels, subdivide.render_levels = 0, 2
        hidden = thing.modifiers.new("only in the viewport", "ARRAY")
        hidden.show_render = False
    plain = cube("plain", location=(0, 4, 0))
    modelling.add("plain too", plain.data, location=(4, 4, 0), rotation_z=90.0, scale=0.5)
    unseen = cube("unseen", location=(0, 0, 9))
    unseen.hide_render = True
    veiled = cube("veiled", location=(0, 0, -9))
    veiled.hide_set(True)


def case_collection_instances():
    camera()
    collection = bpy.data.collections.new("pair")
    red = modelling.lambert("red", 0.5)
    red.node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = (0.7, 0.2, 0.1, 1.0)
    mesh = modelling.box_mesh("brick", (-1, -1, -1), (1, 1, 1))
    mesh.materials.append(red)
    for x in (0.0, 3.0):
        thing = bpy.data.objects.new("brick", mesh)
        thing.location = (x, 0, 0)
        collection.objects.link(thing)
    for y in (0.0, 5.0, 10.0):
        instance = bpy.data.objects.new("instance", None)
        instance.instance_type, instance.instance_collection = "COLLECTION", collection
        instance.location, instance.rotation_euler = (0, y, 0), (0, 0, 0.1 * y)
        bpy.context.scene.collection.objects.link(instance)


def case_cameras():
    """Two views that share their data, and a name that the data does not have."""
    cube()
    first = camera("front")
    second = bpy.data.objects.new("side", first.data)
    second.location, second.rotation_euler = (6, 0, 0), modelling.turned((-1, 0, 0))
    bpy.context.scene.collection.objects.link(second)
    bpy.context.scene.render.resolution_x = 1000
    bpy.context.scene.render.resolution_y = 800
    bpy.context.scene.render.resolution_percentage = 50


def case_lights():
    camera()
    cube()
    light("lamp", "POINT", energy=40 * math.pi, color=(1.0, 0.5, 0.25), shadow_soft_size=0.25)
    light("torch", "SPOT", energy=8 * math.pi, shadow_soft_size=0.0, spot_size=math.radians(60.0),
          spot_blend=0.5).rotation_euler = modelling.turned((0, 1, 0))
    noon = light("noon", "SUN", energy=3.0, angle=math.radians(2.0), color=(1.0, 1.0, 0.5))
    noon.data.use_nodes = True
    emission = noon.data.node_tree.nodes["Emission"]
    emission.inputs["Color"].default_value = (0.5, 1.0, 1.0, 1.0)
    emission.inputs["Strength"].default_value = 2.0


def case_materials():
    """A Diffuse BSDF, a Principled metal, one without nodes, and none at all."""
    camera()
    grey = modelling.lambert("grey", 0.3)
    cube("diffuse", grey)
    metal = bpy.data.materials.new("metal")
    metal.use_nodes = True
    metal.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.1, 0.2, 0.3, 1)
    metal.node_tree.nodes["Principled BSDF"].inputs["Metallic"].default_value = 1.0
    cube("metallic", metal, location=(3, 0, 0))
    flat = bpy.data.materials.new("flat")
    flat.diffuse_color = (0.4, 0.5, 0.6, 1.0)
    cube("without nodes", flat, location=(6, 0, 0))
    cube("bare", None, location=(9, 0, 0))


def case_textured_diffuse():
    camera()
    image = bpy.data.images.new("checks", 4, 4)
    image.pixels = [0.5, 0.25, 0.125, 1.0] * 16
    image.pack()
    material = modelling.lambert("painted", 0.5)
    tree = material.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    tree.links.new(texture.outputs["Color"], tree.nodes["Diffuse BSDF"].inputs["Color"])
    thing = cube("painted", material)
    thing.data.uv_layers.new(name="UVMap")


def case_masked():
    camera()
    leaf = numpy.full((4, 4, 4), 0.5, numpy.float32)
    leaf[:2, :, 3] = 0.0
    material = texturing.textured("leaf", texturing.image("leaf", leaf), masked=True)
    material.alpha_threshold = 0.25
    thing = cube("leaf", material)
    thing.data.uv_layers.new(name="UVMap")
    glass = bpy.data.materials.new("glass")
    glass.use_nodes = True
    glass.node_tree.nodes["Principled BSDF"].inputs["Alpha"].default_value = 0.5
    cube("glass", glass, location=(3, 0, 0))


def _turned_world(kind, degrees):
    camera()
    cube()
    _, tree, background, texture = node_world(small_probe(FOLDER / "probes" / "column.exr"))
    map_texture(tree, texture, kind, rotation=(0.0, 0.0, math.radians(degrees)))
    background.inputs["Strength"].default_value = 2.5

    def look():
        """Radiance at the column's place if the exported rotation is right, and at its sides."""
        document, _ = export.glb.parse((FOLDER / f"world_{kind.lower()}.glb").read_bytes())
        rotation = document["scenes"][0]["extras"]["occlab"]["world"]["rotation_degrees"]
        azimuth = 360.0 * ((BRIGHT_COLUMN + 0.5) / WIDTH - 0.5)  # in glTF, from +X to +Z
        directions = []
        for side in (0.0, 4.0, -4.0, -2.0 * rotation):
            # Counter-clockwise about +Y takes +Z to +X: it lessens the azimuth.
            phi = math.radians(azimuth - rotation + side)
            directions.append((math.cos(phi), -math.sin(phi), 0.0))
        return render_towards(directions)

    return look


def case_world_point():
    return _turned_world("POINT", 40.0)


def case_world_texture():
    return _turned_world("TEXTURE", 25.0)


def case_world_studio():
    camera()
    cube()
    folder = pathlib.Path(bpy.utils.system_resource("DATAFILES", path="studiolights/world"))
    node_world(folder / "courtyard.exr")


def case_world_ours():
    camera()
    cube()
    modelling.probe_world("sky_sun")


def case_world_outside():
    camera()
    cube()
    node_world(small_probe(FOLDER.parent / "elsewhere" / "column.exr"))


def case_world_constant():
    camera()
    cube()
    _, _, background, _ = node_world()
    background.inputs["Color"].default_value = (0.25, 0.5, 1.0, 1.0)
    background.inputs["Strength"].default_value = 2.0


def case_sheared_by_hierarchy():
    """A turned child of an unequally scaled parent: two glTF nodes say it exactly."""
    camera()
    parent = bpy.data.objects.new("squeezed", None)
    parent.scale = (3.0, 1.0, 1.0)
    bpy.context.scene.collection.objects.link(parent)
    child = cube("sheared", rotation_z=45.0)
    child.parent = parent
    child.matrix_parent_inverse = Matrix.Identity(4)


def main():
    results = {}
    for name, case in [*globals().items(), *vars(refused_cases).items()]:
        if not name.startswith("case_"):
            continue
        name = name[len("case_"):]
        modelling.begin()
        after = case()
        result = {"refused": None}
        try:
            export.export_scene(FOLDER / f"{name}.glb")
            if after is not None:
                result["returned"] = after()
        except export.Refusal as refusal:
            result["refused"] = str(refusal)
        results[name] = result
    modelling.begin()
    camera()
    cube()
    bpy.ops.wm.save_as_mainfile(filepath=str(FOLDER / "good.blend"))
    camera("shifted", shift_y=0.2)
    bpy.ops.wm.save_as_mainfile(filepath=str(FOLDER / "shifted.blend"))
    (FOLDER / "results.json").write_text(json.dumps(results, indent=1))


main()
