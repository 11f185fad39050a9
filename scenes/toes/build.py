"""Builds the stand-in for the SSDO paper's Figures 8, 9 and 11: small round things touch a floor.

    blender --background --factory-startup --python-exit-code 3 \
        --python scenes/toes/build.py -- scenes/toes/toes.glb

The feet of a statue on a plinth, all white: where toes touch the stone the gap to it narrows to
nothing, and the shadow in it is lost to the depth bias of a shadow map. Before them lie small
occluders: beads, pegs, discs and a thin slab, a few millimetres to centimetres high. Everything is a
closed mesh. The camera `small` looks at the small occluders.
"""

import math
import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import bpy  # noqa: E402
from mathutils import Matrix  # noqa: E402

import modelling as m  # noqa: E402

SINK = m.SINK
FLOOR = 0.12  # the plinth's top

# Balls of the foot that points along -Y: x, y, z, radius. A metaball's surface lies well inside.
SOLE = ((0.00, 0.30, 0.10, 0.26), (0.00, 0.18, 0.09, 0.22), (0.03, 0.04, 0.08, 0.20),
        (0.01, -0.10, 0.08, 0.22), (-0.04, -0.18, 0.07, 0.20), (0.06, -0.16, 0.06, 0.18),
        (0.00, 0.26, 0.26, 0.25), (0.00, 0.27, 0.42, 0.24), (0.00, 0.28, 0.58, 0.25),
        (0.00, 0.29, 0.76, 0.27), (0.00, 0.12, 0.20, 0.20), (0.00, 0.00, 0.13, 0.18))
# Toes, from the great one: x and y of the joint and of the tip, radius of the tip.
TOES = ((-0.095, -0.25, -0.105, -0.40, 0.056), (-0.025, -0.27, -0.028, -0.415, 0.041),
        (0.035, -0.26, 0.040, -0.39, 0.037), (0.088, -0.235, 0.102, -0.35, 0.034),
        (0.130, -0.20, 0.152, -0.295, 0.032))


def meta_mesh(name, balls, resolution):
    """The skin of metaballs, closed; its lowest point at height 0."""
    data = bpy.data.metaballs.new(name)
    data.resolution = data.render_resolution = resolution
    data.threshold = 0.4
    for x, y, z, radius in balls:
        ball = data.elements.new()
        ball.co, ball.radius = (x, y, z), radius
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.view_layer.update()
    mesh = bpy.data.meshes.new_from_object(
        thing.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    bpy.data.objects.remove(thing)
    bpy.data.metaballs.remove(data)
    for polygon in mesh.polygons:
        polygon.use_smooth = True
    mesh.name = name
    lowest = min(vertex.co.z for vertex in mesh.vertices)
    return m.transformed(mesh, Matrix.Translation((0, 0, -lowest)))


def foot_mesh():
    """The sole is level; toes rise from the joint and bend down to the floor at their tips."""
    balls = list(SOLE)
    for joint_x, joint_y, tip_x, tip_y, radius in TOES:
        for step in range(5):
            t = step / 4
            height = 0.028 + 0.045 * (1.0 - t) + 0.022 * math.sin(math.pi * t)
            balls.append((joint_x + t * (tip_x - joint_x), joint_y + t * (tip_y - joint_y),
                          height + radius - 0.034, 1.55 * radius))
    return meta_mesh("foot", balls, 0.014)


def small_occluders(white):
    bead = m.sphere_mesh("bead", 1.0, 4)
    for number, (x, y, radius) in enumerate((
            (-0.62, -0.80, 0.040), (-0.52, -0.83, 0.028), (-0.44, -0.80, 0.018),
            (-0.38, -0.83, 0.011), (-0.34, -0.80, 0.007), (0.05, -0.92, 0.022),
            (0.11, -0.88, 0.014), (0.62, -0.55, 0.050), (-0.70, -0.35, 0.030))):
        m.add(f"bead {number + 1}", bead, white, location=(x, y, FLOOR + radius - SINK),
              scale=radius)
    for number, (x, y, radius, height) in enumerate((
            (-0.18, -0.82, 0.020, 0.060), (-0.10, -0.86, 0.014, 0.030), (-0.04, -0.80, 0.060, 0.008),
            (0.42, -0.86, 0.050, 0.014), (0.54, -0.82, 0.010, 0.090))):
        profile = [(radius, -SINK), (radius, height)]
        m.add(f"peg {number + 1}", m.lathe_mesh(f"peg {number + 1}", profile, 48), white,
              location=(x, y, FLOOR))
    m.add("slab", m.box_mesh("slab", (-0.10, -0.035, -SINK), (0.10, 0.035, 0.010)), white,
          location=(0.25, -0.84, FLOOR), rotation_z=18.0)


m.begin()
marble = m.lambert("white", 0.8)
m.add("ground", m.box_mesh("ground", (-5, -5, -0.1), (5, 5, 0)), marble)
m.add("plinth", m.box_mesh("plinth", (-1.0, -1.0, -SINK), (1.0, 0.9, FLOOR)), marble)
foot = foot_mesh()
m.add("left foot", foot, marble, location=(0.28, 0.10, FLOOR - SINK), rotation_z=12.0)
m.add("right foot", foot, marble, location=(-0.24, -0.14, FLOOR - SINK), rotation_z=-6.0)
small_occluders(marble)
m.sun("sun", (0.80, -0.35, 0.75), (1.0, 0.96, 0.88), 2.6)
m.camera("main", (-0.35, -2.3, 1.15), (0.0, -0.36, 0.18), 38.0)
m.camera("small", (-0.15, -1.75, 0.62), (-0.08, -0.80, 0.13), 46.0)
m.probe_world("dusk", 0.6)
m.finish()
