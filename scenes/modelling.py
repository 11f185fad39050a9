"""What the scenes' build.py scripts share. Inside Blender: metres, Z up, Y away from the camera.

A build script empties Blender, models with these functions and ends with `finish`, which exports
to the .glb named on the command line.
"""

import math
import pathlib

import bmesh
import bpy
from mathutils import Matrix, Vector

import export

SCENES = pathlib.Path(__file__).resolve().parent
SINK = 0.001  # metres: what stands on a surface reaches this far into it, so no faces coincide


def begin():
    """An empty Blender at the paper's resolution."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.resolution_x = 1280
    bpy.context.scene.render.resolution_y = 720
    bpy.context.scene.render.resolution_percentage = 100


def finish():
    """Exports to the path after `--`."""
    for thing in bpy.context.scene.objects:
        if thing.type == "CAMERA" and thing.name != thing.data.name:
            raise ValueError(f"another object took the name of camera '{thing.data.name}'")
    export.main()


def lambert(name, albedo):
    """A Diffuse BSDF of grey or coloured `albedo`: Lambertian in Cycles too, which a Principled
    BSDF is not."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    rgb = (albedo,) * 3 if isinstance(albedo, float) else albedo
    diffuse.inputs["Color"].default_value = (*rgb, 1.0)
    output = nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(diffuse.outputs["BSDF"], output.inputs["Surface"])
    return material


def add(name, mesh, material=None, location=(0, 0, 0), rotation_z=0.0, scale=1.0):
    """Places `mesh` in the scene. The same mesh placed twice is stored once, and has one material."""
    if material is not None and mesh.materials and mesh.materials[0] != material:
        raise ValueError(f"{name}: mesh {mesh.name} has material {mesh.materials[0].name} already")
    thing = bpy.data.objects.new(name, mesh)
    thing.location = location
    thing.rotation_euler = (0.0, 0.0, math.radians(rotation_z))
    thing.scale = (scale, scale, scale)
    if material is not None and not mesh.materials:
        mesh.materials.append(material)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def in_material(mesh, material):
    """The mesh if its material is this or none yet, else its copy that has this one."""
    if not mesh.materials or mesh.materials[0] == material:
        return mesh
    name = f"{mesh.name}, {material.name}"
    if name not in bpy.data.meshes:
        copy = mesh.copy()
        copy.name = name
        copy.materials[0] = material
    return bpy.data.meshes[name]


def mesh_of(name, vertices, faces, smooth=False):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    if mesh.validate():
        raise ValueError(f"mesh {name}: invalid faces")
    for polygon in mesh.polygons:
        polygon.use_smooth = smooth
    return mesh


def smooth_by_angle(mesh, degrees):
    """Smooth shading with the edges sharper than `degrees` kept."""
    mesh.use_auto_smooth = True
    mesh.auto_smooth_angle = math.radians(degrees)
    for polygon in mesh.polygons:
        polygon.use_smooth = True
    return mesh


def box_mesh(name, low, high):
    (x0, y0, z0), (x1, y1, z1) = low, high
    vertices = [(x, y, z) for z in (z0, z1) for y in (y0, y1) for x in (x0, x1)]
    return mesh_of(name, vertices, [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3),
                                    (0, 4, 6, 2), (1, 3, 7, 5)])


def lathe_mesh(name, profile, segments, smooth_degrees=35.0, radius_factor=None):
    """Revolves `profile`, (radius, height) from bottom to top, about Z; closed by discs.

    `radius_factor(index, angle)` scales the radius of profile point `index` (flutes, lobes).
    """
    vertices, faces = [], []
    for index, (radius, height) in enumerate(profile):
        for segment in range(segments):
            angle = 2 * math.pi * segment / segments
            r = radius * (radius_factor(index, angle) if radius_factor else 1.0)
            vertices.append((r * math.cos(angle), r * math.sin(angle), height))
    for ring in range(len(profile) - 1):
        for segment in range(segments):
            following = (segment + 1) % segments
            a, b = ring * segments + segment, ring * segments + following
            faces.append((a, b, b + segments, a + segments))
    faces.append(tuple(reversed(range(segments))))
    top = (len(profile) - 1) * segments
    faces.append(tuple(range(top, top + segments)))
    return smooth_by_angle(mesh_of(name, vertices, faces), smooth_degrees)


def sphere_mesh(name, radius, subdivisions):
    """An icosphere of 20 * 4^(subdivisions - 1) triangles."""
    work = bmesh.new()
    bmesh.ops.create_icosphere(work, subdivisions=subdivisions, radius=radius)
    mesh = bpy.data.meshes.new(name)
    work.to_mesh(mesh)
    work.free()
    for polygon in mesh.polygons:
        polygon.use_smooth = True
    return mesh


def tube_mesh(name, centre_of, radius, around, along):
    """A closed tube about the closed curve `centre_of(t)`, t in [0, 1)."""
    points = [Vector(centre_of(i / along)) for i in range(along)]
    tangents = [(points[(i + 1) % along] - points[i - 1]).normalized() for i in range(along)]
    normal = tangents[0].orthogonal().normalized()
    frames = []
    for tangent in tangents:  # parallel transport: no twist from one ring to the next
        normal = (normal - tangent * normal.dot(tangent)).normalized()
        frames.append((normal.copy(), tangent.cross(normal)))
    # What twist the closed curve leaves is spread over all rings, so that the seam meets.
    last = (frames[-1][0] - tangents[0] * frames[-1][0].dot(tangents[0])).normalized()
    twist = math.atan2(last.dot(frames[0][1]), last.dot(frames[0][0]))
    vertices, faces = [], []
    for i in range(along):
        for j in range(around):
            angle = 2 * math.pi * j / around - twist * i / along
            vertices.append(points[i] + radius * (math.cos(angle) * frames[i][0]
                                                  + math.sin(angle) * frames[i][1]))
            faces.append((i * around + j, i * around + (j + 1) % around,
                          (i + 1) % along * around + (j + 1) % around,
                          (i + 1) % along * around + j))
    return mesh_of(name, vertices, faces, smooth=True)


def apply_modifiers(thing):
    """Replaces the object's mesh by its evaluated one, so that copies of it can share it."""
    graph = bpy.context.evaluated_depsgraph_get()
    mesh = bpy.data.meshes.new_from_object(thing.evaluated_get(graph), depsgraph=graph)
    mesh.name = thing.data.name + " applied"
    thing.modifiers.clear()
    thing.data = mesh
    return mesh


def turned(direction):
    """The rotation that turns -Z, along which cameras and lights look, to `direction`."""
    return Vector(direction).to_track_quat("-Z", "Y").to_euler()


def camera(name, position, target, horizontal_degrees):
    data = bpy.data.cameras.new(name)
    data.angle = math.radians(horizontal_degrees)
    data.clip_start, data.clip_end = 0.1, 100.0
    thing = bpy.data.objects.new(name, data)
    thing.location = position
    thing.rotation_euler = turned(Vector(target) - Vector(position))
    bpy.context.scene.collection.objects.link(thing)
    if bpy.context.scene.camera is None:
        bpy.context.scene.camera = thing
    return thing


def sun(name, comes_from, colour, irradiance):
    """A directional light; `irradiance` (W/m^2) on a surface facing it, times `colour`."""
    data = bpy.data.lights.new(name, "SUN")
    data.color, data.energy, data.angle = colour, irradiance, 0.0
    thing = bpy.data.objects.new(name, data)
    thing.location = Vector(comes_from).normalized() * 5.0  # only for show
    thing.rotation_euler = turned(-Vector(comes_from))
    bpy.context.scene.collection.objects.link(thing)
    return thing


def lamp(name, position, colour, intensity):
    """A light at a point; `intensity` in W/sr, times `colour`."""
    data = bpy.data.lights.new(name, "POINT")
    data.color, data.energy, data.shadow_soft_size = colour, 4.0 * math.pi * intensity, 0.0
    thing = bpy.data.objects.new(name, data)
    thing.location = position
    bpy.context.scene.collection.objects.link(thing)
    return thing


def probe_world(name, strength=1.0):
    """Lights the scene with scenes/probes/<name>.exr, its radiance times `strength`."""
    world = bpy.data.worlds.new(name)
    world.use_nodes = True
    tree = world.node_tree
    tree.nodes.clear()
    image = tree.nodes.new("ShaderNodeTexEnvironment")
    image.image = bpy.data.images.load(str(SCENES / "probes" / f"{name}.exr"))
    background = tree.nodes.new("ShaderNodeBackground")
    background.inputs["Strength"].default_value = strength
    output = tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(image.outputs["Color"], background.inputs["Color"])
    tree.links.new(background.outputs["Background"], output.inputs["Surface"])
    bpy.context.scene.world = world


def transformed(mesh, matrix):
    mesh.transform(Matrix(matrix))
    return mesh
