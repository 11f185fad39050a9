"""Builds the stand-in for the scene of the S3HO paper's Figure 7: a sculpture gallery, all white.

    blender --background --factory-startup --python-exit-code 3 \
        --python scenes/gallery/build.py -- scenes/gallery/gallery.glb

A room 6 m wide without ceiling, open towards the camera and to the right, so that a probe lights
it. It has what the closeups of Figure 8 need: a bare 90-degree corner, a carved panel, blobby and
knotted sculptures, steps, fluted columns, and small solids whose contact shadows face several ways.
Everything is a closed mesh and sinks a millimetre into what it stands on.
"""

import math
import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import bpy  # noqa: E402
from mathutils import Euler, Matrix  # noqa: E402

import modelling as m  # noqa: E402

SINK = m.SINK


def bevelled(thing, width, segments=2):
    modifier = thing.modifiers.new("bevel", "BEVEL")
    modifier.width, modifier.segments, modifier.limit_method = width, segments, "ANGLE"
    modifier.harden_normals = True
    m.smooth_by_angle(thing.data, 30.0)
    return thing


def room(white):
    m.add("floor", m.box_mesh("floor", (-3.3, -2.8, -0.2), (3.4, 3.9, 0.0)), white)
    m.add("left wall", m.box_mesh("left wall", (-3.25, -2.7, -0.05), (-3.0, 3.1, 3.0)), white)
    wall = m.add("back wall", m.box_mesh("back wall", (-3.2, 3.0, -0.06), (3.3, 3.7, 2.98)), white)

    # An arched niche: a cylinder and the quarter sphere above it, cut out of the wall.
    radius, sill, spring = 0.48, 0.70, 1.45
    arc = [(radius * math.cos(a), spring + radius * math.sin(a))
           for a in (math.pi / 2 * i / 16 for i in range(16))]
    profile = [(radius, sill), *arc, (0.004, spring + radius)]
    cutter = m.add("niche", m.lathe_mesh("niche", profile, 48), white, location=(-0.05, 3.0, 0.0))
    cut = wall.modifiers.new("niche", "BOOLEAN")
    cut.object, cut.solver = cutter, "EXACT"
    m.smooth_by_angle(wall.data, 30.0)
    m.apply_modifiers(wall)
    bpy.data.objects.remove(cutter)


def relief_height(x, y):
    """Carving above the panel's ground, metres; x and y in metres from the panel's centre."""
    radius, angle = math.hypot(x, y), math.atan2(y, x)

    def bump(distance, width):
        t = max(0.0, 1.0 - (distance / width) ** 2)
        return t * t * (3.0 - 2.0 * t)

    # A rosette of two rings of petals round a boss.
    inner = 0.19 * (0.72 + 0.28 * abs(math.cos(4.0 * angle)))
    outer = 0.36 * (0.76 + 0.24 * abs(math.cos(4.0 * angle + math.pi / 2)))
    height = 0.050 * bump(radius, 0.085)
    height = max(height, 0.042 * bump(radius - 0.62 * inner, 0.40 * inner)
                 * (0.75 + 0.25 * math.cos(16.0 * angle)))
    height = max(height, 0.036 * bump(radius - 0.74 * outer, 0.27 * outer)
                 * (0.80 + 0.20 * math.cos(40.0 * angle)))
    # A rope round it, four bosses in the corners with tendrils, and a moulded frame.
    height = max(height, 0.034 * bump(radius - 0.425, 0.030)
                 * (0.72 + 0.28 * math.sin(40.0 * angle + 90.0 * (radius - 0.425))))
    cx, cy = abs(x) - 0.435, abs(y) - 0.435
    corner, turn = math.hypot(cx, cy), math.atan2(cy, cx)
    height = max(height, 0.045 * bump(corner, 0.05),
                 0.026 * bump(corner - 0.078 - 0.012 * math.cos(5.0 * turn), 0.020))
    edge = max(abs(x), abs(y))
    return max(height, 0.040 * bump(edge - 0.555, 0.032), 0.022 * bump(edge - 0.505, 0.014))


def relief(white):
    """A carved panel, hung on the back wall."""
    size, steps = 1.2, 176
    side = [size * (i / steps - 0.5) for i in range(steps + 1)]
    vertices = [(x, -0.03 - relief_height(x, z), z) for z in side for x in side]
    faces = [(row * (steps + 1) + i, row * (steps + 1) + i + 1,
              (row + 1) * (steps + 1) + i + 1, (row + 1) * (steps + 1) + i)
             for row in range(steps) for i in range(steps)]
    # The border falls back into the wall, where one face closes it.
    last = steps * (steps + 1)
    border = (list(range(steps)) + [i * (steps + 1) + steps for i in range(steps)]
              + [last + i for i in range(steps, 0, -1)]
              + [i * (steps + 1) for i in range(steps, 0, -1)])
    base = len(vertices)
    vertices += [(vertices[i][0], 0.02, vertices[i][2]) for i in border]
    count = len(border)
    faces += [(border[i], base + i, base + (i + 1) % count, border[(i + 1) % count])
              for i in range(count)]
    faces.append(tuple(range(base + count - 1, base - 1, -1)))
    mesh = m.smooth_by_angle(m.mesh_of("relief", vertices, faces), 60.0)
    m.add("carved panel", mesh, white, location=(-1.55, 3.0, 1.35))


def steps_and_columns(white):
    rise, tread, left, right, front = 0.16, 0.30, 0.95, 2.95, 1.05
    outline = [(3.05, -SINK), (front, -SINK)]
    for step in range(3):
        outline += [(front + tread * step, rise * (step + 1)),
                    (front + tread * (step + 1), rise * (step + 1))]
    outline[-1] = (3.05, 3 * rise)
    count = len(outline)
    vertices = [(x, y, z) for x in (left, right) for y, z in outline]
    faces = [(i, i + count, (i + 1) % count + count, (i + 1) % count) for i in range(count)]
    faces += [tuple(range(count)), tuple(range(2 * count - 1, count - 1, -1))]
    bevelled(m.add("steps", m.mesh_of("steps", vertices, faces), white), 0.012)

    # A column: plinth, base of two tori, fluted shaft with entasis, echinus, abacus.
    def torus(radius, bulge, z, height):
        return [(radius + bulge * math.sin(math.pi * i / 6), z + height * i / 6) for i in range(7)]

    shaft = [(0.140 - 0.022 * (i / 8) ** 1.6, 0.26 + 1.08 * i / 8) for i in range(9)]
    profile = ([(0.15, 0.079)] + torus(0.168, 0.030, 0.08, 0.07)
               + [(0.155, 0.160), (0.150, 0.175), (0.152, 0.190)] + torus(0.150, 0.022, 0.20, 0.045)
               + shaft + torus(0.120, 0.016, 1.35, 0.03) + [(0.122, 1.39)]
               + [(0.122 + 0.075 * math.sin(math.pi / 2 * i / 6), 1.39 + 0.075 * (i / 6) ** 1.5)
                  for i in range(1, 7)] + [(0.19, 1.481)])
    first, last = profile.index(shaft[0]), profile.index(shaft[-1])

    def fluted(index, angle):
        if not first < index < last:
            return 1.0
        return 1.0 - 0.10 * math.sqrt(abs(math.sin(10.0 * angle)))

    column = m.lathe_mesh("column", profile, 160, 40.0, fluted)
    plinth = m.box_mesh("plinth", (-0.215, -0.215, -SINK), (0.215, 0.215, 0.08))
    abacus = m.box_mesh("abacus", (-0.215, -0.215, 1.48), (0.215, 0.215, 1.56))
    for number, (x, y) in enumerate(((1.28, 2.02), (2.55, 2.02), (1.28, 2.72), (2.55, 2.72))):
        for mesh in (plinth, column, abacus):
            part = m.add(f"{mesh.name} {number + 1}", mesh, white, location=(x, y, 3 * rise))
            if mesh is not column:
                bevelled(part, 0.008)
    top = 3 * rise + 1.56
    bevelled(m.add("architrave", m.box_mesh(
        "architrave", (1.02, 1.80, top - SINK), (2.85, 3.05, top + 0.20)), white), 0.01)
    bevelled(m.add("cornice", m.box_mesh(
        "cornice", (0.92, 1.70, top + 0.199), (2.97, 3.04, top + 0.28)), white), 0.015)


def blob(white):
    """A reclining figure of metaballs on a round plinth."""
    data = bpy.data.metaballs.new("figure")
    data.resolution = data.render_resolution = 0.022
    data.threshold = 0.5
    for x, y, z, radius in ((-0.28, 0.00, 0.16, 0.33), (-0.06, 0.05, 0.17, 0.33),
                            (0.16, 0.00, 0.22, 0.35), (0.29, 0.02, 0.40, 0.32),
                            (0.31, 0.00, 0.58, 0.28), (0.25, -0.01, 0.73, 0.25),
                            (0.13, 0.00, 0.83, 0.23), (-0.01, 0.02, 0.82, 0.20),
                            (-0.12, 0.04, 0.72, 0.18), (-0.20, 0.04, 0.60, 0.18),
                            (-0.29, 0.02, 0.47, 0.21), (-0.34, -0.01, 0.31, 0.25),
                            (0.13, 0.02, 1.02, 0.24), (0.42, 0.06, 0.14, 0.26)):
        ball = data.elements.new()
        ball.co, ball.radius = (x, y, z), radius
    thing = bpy.data.objects.new("figure", data)
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.view_layer.update()
    mesh = bpy.data.meshes.new_from_object(
        thing.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    bpy.data.objects.remove(thing)
    for polygon in mesh.polygons:
        polygon.use_smooth = True
    mesh.name = "figure"
    lowest = min(vertex.co.z for vertex in mesh.vertices)
    m.transformed(mesh, Matrix.Translation((0, 0, -lowest - 0.02)))
    plinth = [(0.52, -SINK), (0.52, 0.05), (0.49, 0.065), (0.47, 0.08), (0.47, 0.16), (0.46, 0.17)]
    m.add("figure plinth", m.lathe_mesh("figure plinth", plinth, 96), white,
          location=(-0.95, 0.95, 0.0))
    m.add("figure", mesh, white, location=(-0.95, 0.95, 0.17), rotation_z=-16.0)


def bust(white):
    """Blender's monkey, made a closed skin, in the niche."""
    bpy.ops.mesh.primitive_monkey_add(size=1.0)
    thing = bpy.context.object
    thing.name = thing.data.name = "bust"
    while thing.data.uv_layers:
        thing.data.uv_layers.remove(thing.data.uv_layers[0])
    thing.data.materials.append(white)
    subdivide = thing.modifiers.new("subdivide", "SUBSURF")
    subdivide.levels = subdivide.render_levels = 2
    remesh = thing.modifiers.new("remesh", "REMESH")
    remesh.mode, remesh.voxel_size, remesh.use_smooth_shade = "VOXEL", 0.016, True
    smooth = thing.modifiers.new("smooth", "SMOOTH")
    smooth.factor, smooth.iterations = 0.5, 3
    thing.location, thing.scale = (-0.05, 3.17, 1.20), (0.62, 0.62, 0.62)
    thing.rotation_euler = Euler((math.radians(-28.0), 0.0, math.radians(10.0)))
    m.add("bust pedestal", m.lathe_mesh("bust pedestal", [
        (0.20, 0.70 - SINK), (0.20, 0.75), (0.17, 0.77), (0.12, 0.80), (0.105, 0.86),
        (0.12, 0.92), (0.16, 0.95), (0.16, 1.0)], 64), white, location=(-0.05, 3.21, 0.0))


def solids(white):
    """Small things on the floor, whose contact shadows face every way."""
    ball = m.sphere_mesh("ball", 1.0, 5)
    for x, y, radius in ((-2.52, 0.72, 0.25), (-0.14, 0.30, 0.16), (-0.18, 1.80, 0.22)):
        m.add("ball", ball, white, location=(x, y, radius - SINK), scale=radius)

    def ring(t):
        return 0.29 * math.cos(2 * math.pi * t), 0.29 * math.sin(2 * math.pi * t), 0.0

    torus = m.tube_mesh("torus", ring, 0.095, 32, 96)
    m.add("torus", torus, white, location=(0.46, 0.52, 0.095 - SINK))

    def knot(t):
        a = 2 * math.pi * t
        r = 0.30 + 0.13 * math.cos(3 * a)
        return r * math.cos(2 * a), r * math.sin(2 * a), 0.15 * math.sin(3 * a)

    m.add("knot", m.tube_mesh("knot", knot, 0.062, 24, 320), white,
          location=(1.52, 0.28, 0.212 - SINK), rotation_z=25.0)

    for name, size, location, turn in (
            ("low box", (0.30, 0.22, 0.30), (-1.86, 0.42, 0.0), 24.0),
            ("tall box", (0.15, 0.15, 0.58), (0.66, 1.50, 0.0), -12.0),
            ("flat box", (0.20, 0.14, 0.16), (-1.20, -0.10, 0.0), 38.0)):
        x, y, z = size
        mesh = m.box_mesh(name, (-x, -y, -SINK), (x, y, z))
        bevelled(m.add(name, mesh, white, location=location, rotation_z=turn), 0.008)
    bevelled(m.add("upper box", m.box_mesh("upper box", (-0.16, -0.13, -SINK), (0.16, 0.13, 0.22)),
                   white, location=(-1.90, 0.40, 0.30), rotation_z=58.0), 0.008)

    # A vase, hollow: its wall is a closed skin.
    outside = [(0.085, -SINK), (0.10, 0.02), (0.155, 0.10), (0.185, 0.19), (0.175, 0.28),
               (0.125, 0.36), (0.085, 0.41), (0.080, 0.45), (0.115, 0.50)]
    inside = [(radius - 0.018, height) for radius, height in reversed(outside[1:-1])]
    m.add("vase", m.lathe_mesh("vase", [*outside, (0.105, 0.505), *inside], 72, 50.0), white,
          location=(0.34, 2.58, 0.0), scale=1.25)


def cameras():
    m.camera("main", (1.70, -5.30, 2.30), (-0.08, 1.00, 0.84), 43.0)
    m.camera("corner", (-1.55, 0.45, 1.35), (-2.75, 2.75, 0.28), 48.0)
    m.camera("relief", (-1.15, 1.70, 1.62), (-1.52, 3.00, 1.33), 56.0)


m.begin()
material = m.lambert("white", 0.8)
for build in (room, relief, steps_and_columns, blob, bust, solids):
    build(material)
cameras()
m.probe_world("cathedral")
m.finish()
