"""Scenes that the exporter refuses; export_cases.py runs them as its own."""

import bpy
import numpy
from mathutils import Matrix

from case_parts import (
    FOLDER, camera, cube, light, map_texture, node_world, small_probe)
import modelling
import texturing


def case_refused_no_camera():
    cube()


def case_refused_no_mesh():
    camera()


def case_refused_lens_shift():
    camera(shift_x=0.1)
    cube()


def case_refused_orthographic():
    camera(type="ORTHO")
    cube()


def case_refused_area_light():
    camera()
    cube()
    light("window", "AREA", energy=10.0)


def case_refused_mixed_material():
    camera()
    material = modelling.lambert("mixed", 0.5)
    tree = material.node_tree
    mix = tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(mix.outputs["Shader"], tree.nodes["Material Output"].inputs["Surface"])
    cube("mixed", material)


def case_refused_bright_albedo():
    camera()
    cube("bright", modelling.lambert("bright", 1.5))


def case_refused_alpha_of_another_image():
    camera()
    grey = numpy.full((4, 4, 4), 0.5, numpy.float32)
    material = texturing.textured("leaf", texturing.image("leaf", grey), masked=True)
    tree = material.node_tree
    other = tree.nodes.new("ShaderNodeTexImage")
    other.image = texturing.image("other", grey)
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    tree.links.new(other.outputs["Alpha"], shader.inputs["Alpha"])
    cube("leaf", material).data.uv_layers.new(name="UVMap")


def case_refused_sky_texture():
    camera()
    cube()
    _, tree, background, _ = node_world()
    sky = tree.nodes.new("ShaderNodeTexSky")
    tree.links.new(sky.outputs["Color"], background.inputs["Color"])


def case_refused_tilted_world():
    camera()
    cube()
    _, tree, _, texture = node_world(small_probe(FOLDER / "probes" / "column.exr"))
    map_texture(tree, texture, "POINT", rotation=(0.2, 0.0, 0.0))


def case_refused_missing_probe():
    camera()
    cube()
    _, _, _, texture = node_world(small_probe(FOLDER / "probes" / "gone.exr"))
    (FOLDER / "probes" / "gone.exr").unlink()


def case_refused_packed_probe():
    camera()
    cube()
    _, _, _, texture = node_world(small_probe(FOLDER / "probes" / "column.exr"))
    texture.image.pack()


def case_refused_metaball():
    camera()
    cube()
    data = bpy.data.metaballs.new("drop")
    data.elements.new().radius = 1.0
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("drop", data))


def case_refused_node_instances():
    """Geometry nodes that put a cube on every point of a grid."""
    camera()
    thing = cube("scattered")
    group = bpy.data.node_groups.new("scatter", "GeometryNodeTree")
    group.inputs.new("NodeSocketGeometry", "Geometry")
    group.outputs.new("NodeSocketGeometry", "Geometry")
    start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    on_points = group.nodes.new("GeometryNodeInstanceOnPoints")
    small = group.nodes.new("GeometryNodeMeshCube")
    group.links.new(start.outputs[0], on_points.inputs["Points"])
    group.links.new(small.outputs["Mesh"], on_points.inputs["Instance"])
    group.links.new(on_points.outputs["Instances"], end.inputs[0])
    thing.modifiers.new("scatter", "NODES").node_group = group


def case_refused_sheared():
    """A shear in the parenting itself; Blender's exporter drops it without a word."""
    camera()
    parent = bpy.data.objects.new("parent", None)
    bpy.context.scene.collection.objects.link(parent)
    child = cube("sheared")
    child.parent = parent
    child.matrix_parent_inverse = Matrix.Shear("XY", 4, (0.5, 0.0))
