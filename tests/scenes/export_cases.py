"""Runs inside Blender for test_scenes.py: builds small scenes and exports each.

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
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scenes"))
import bpy  # noqa: E402
from mathutils import Matrix, Vector  # noqa: E402

import export  # noqa: E402
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


# What is refused


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


def main():
    results = {}
    for name, case in list(globals().items()):
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
