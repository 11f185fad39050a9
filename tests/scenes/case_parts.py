"""What the cases of export_cases.py and refused_cases.py are modelled from, inside Blender."""

import math
import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scenes"))
import bpy  # noqa: E402
from mathutils import Vector  # noqa: E402

import exr  # noqa: E402
import modelling  # noqa: E402

FOLDER = pathlib.Path(sys.argv[-1])


def camera(name="main", **settings):
    thing = modelling.camera(name, (0, -6, 2), (0, 0, 0), 40.0)
    for key, value in settings.items():
        setattr(thing.data, key, value)
    return thing


def cube(name="cube", material=None, **placing):
    mesh = modelling.box_mesh(name, (-1, -1, -1), (1, 1, 1))
    return modelling.add(name, mesh, material, **placing)


def light(name, kind, **settings):
    data = bpy.data.lights.new(name + " data", kind)
    for key, value in settings.items():
        setattr(data, key, value)
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def node_world(path=None):
    """(world, tree, background, environment texture)."""
    world = bpy.data.worlds.new("lit")
    bpy.context.scene.world = world
    world.use_nodes = True
    tree = world.node_tree
    background = tree.nodes["Background"]
    texture = None
    if path is not None:
        texture = tree.nodes.new("ShaderNodeTexEnvironment")
        texture.image = bpy.data.images.load(str(path))
        texture.interpolation = "Closest"
        tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    return world, tree, background, texture


def map_texture(tree, texture, kind, **inputs):
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.vector_type = kind
    for name, value in inputs.items():
        mapping.inputs[name.capitalize()].default_value = value
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])


WIDTH, HEIGHT, BRIGHT_COLUMN = 72, 36, 50  # texels 5 degrees wide


def small_probe(path):
    """One bright column, from the zenith to the nadir; everything else is dim."""
    path.parent.mkdir(exist_ok=True)
    row = [(8.0, 4.0, 2.0) if x == BRIGHT_COLUMN else (0.1, 0.1, 0.1) for x in range(WIDTH)]
    path.write_bytes(exr.encode(WIDTH, HEIGHT, [row] * HEIGHT))
    return path


def render_towards(directions):
    """Radiance that Cycles sees, from far outside the scene, in each direction (Blender axes)."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 4, False
    scene.cycles.use_adaptive_sampling = False
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    data = bpy.data.cameras.new("probe")
    data.angle = math.radians(0.5)
    eye = bpy.data.objects.new("probe", data)
    scene.collection.objects.link(eye)
    scene.camera = eye
    seen = []
    for direction in directions:
        eye.location = Vector(direction) * 50.0
        eye.rotation_euler = modelling.turned(direction)
        scene.render.filepath = str(FOLDER / "seen.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        seen.append(list(image.pixels[:3]))
        bpy.data.images.remove(image)
    return seen


# What is carried
