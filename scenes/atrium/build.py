"""Builds the stand-in for the Crytek Sponza of the S3HO paper's Figure 9: a courtyard with arcades.

    blender --background --factory-startup --python-exit-code 3 \
        --python scenes/atrium/build.py -- scenes/atrium/atrium.glb

Two storeys of round columns and arches about a courtyard of 6 x 16 m, open to the sky; a gallery with
balustrades above; coloured drapes in the lower arches and potted plants. Floor, walls, columns,
drapes and leaves are textured, by images that this script makes; the leaves are an alpha mask. Drapes
and leaves are sheets, seen from both sides; all else is solids. The courtyard's floor is at height 0.
"""

import math
import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import numpy  # noqa: E402
from mathutils import Matrix, Vector  # noqa: E402

import modelling as m  # noqa: E402
import texturing as t  # noqa: E402

SINK = m.SINK
PITCH = 2.0    # from column to column
HALF = 3.0     # from the courtyard's middle to its columns
BAYS = 8       # along the courtyard; 3 across its far end
AISLE = 1.9    # from the columns to the outer wall
SPRING = (2.55, 5.75)  # where the arches of the two storeys begin
STOREY = 4.0   # the gallery's floor
TOP = 7.0
RADIUS = 0.80  # of the arches


def pictures():
    """The materials of the scene, by name."""
    dice = numpy.random.RandomState(9)
    size = 256
    across, up = numpy.meshgrid((numpy.arange(size) + 0.5) / size,
                                (numpy.arange(size) + 0.5) / size)
    grain = 0.6 * t.noise(dice, size, 16) + 0.4 * t.noise(dice, size, 64)

    # Four floor tiles, two light and two dark, with grout between.
    dark = (across < 0.5) ^ (up < 0.5)
    tiles = numpy.where(dark[..., None], [0.52, 0.40, 0.33], [0.80, 0.74, 0.64])
    tiles = tiles * (0.86 + 0.18 * grain)[..., None]
    grout = (numpy.minimum(across % 0.5, up % 0.5) < 0.012)
    tiles[grout] = [0.42, 0.40, 0.38]

    # Four courses of ashlar, every other one shifted by half a stone.
    course = numpy.floor(up * 4.0)
    along = (across * 2.0 + 0.5 * (course % 2)) % 1.0
    tint = dice.random_sample((4, 2))[course.astype(int),
                                      numpy.floor(across * 2.0 + 0.5 * (course % 2)).astype(int) % 2]
    stones = t.mixed([0.80, 0.72, 0.58], [0.70, 0.58, 0.44], 0.6 * tint + 0.4 * grain)
    joints = (numpy.minimum(along, 1.0 - along) < 0.010) | ((up * 4.0) % 1.0 < 0.045)
    stones[joints] = [0.52, 0.47, 0.40]

    veins = numpy.abs(numpy.sin(18.0 * (t.noise(dice, size, 4) + 0.5 * t.noise(dice, size, 8))))
    marble = t.mixed([0.72, 0.67, 0.60], [0.86, 0.82, 0.75], veins * 0.5 + 0.5 * grain)

    half = size // 2
    surfaces = {
        "floor": t.textured("floor", t.image("floor", tiles)),
        "ashlar": t.textured("ashlar", t.image("ashlar", stones)),
        "marble": t.textured("marble", t.image("marble", marble[::2, ::2])),
        "plaster": m.lambert("plaster", (0.72, 0.66, 0.56)),
        "clay": m.lambert("clay", (0.55, 0.25, 0.14)),
        "soil": m.lambert("soil", (0.10, 0.07, 0.05)),
    }
    for name, ground, figure in (("red", [0.70, 0.10, 0.09], [0.83, 0.55, 0.16]),
                                 ("green", [0.10, 0.45, 0.16], [0.80, 0.74, 0.40]),
                                 ("blue", [0.10, 0.18, 0.60], [0.78, 0.76, 0.72])):
        surfaces[name] = t.textured(f"{name} cloth", t.image(f"{name} cloth",
                                                             cloth(half, ground, figure)))
    surfaces["leaf"] = t.textured("leaf", t.image("leaf", leaf(64)), masked=True)
    return surfaces


def cloth(size, ground, figure):
    """A hem of two stripes at the lower end, and lozenges with a point at the top above it."""
    across, up = numpy.meshgrid((numpy.arange(size) + 0.5) / size,
                                (numpy.arange(size) + 0.5) / size)
    weave = 0.90 + 0.10 * ((numpy.arange(size)[:, None] + numpy.arange(size)[None, :]) % 4 < 2)
    hem = ((up > 0.03) & (up < 0.06)) | ((up > 0.09) & (up < 0.15))
    x, y = (across * 3.0) % 1.0 - 0.5, (up * 5.0) % 1.0 - 0.35
    # Narrow above, wide below: one sees which way up the cloth hangs.
    lozenge = (up > 0.2) & (numpy.abs(x) < numpy.where(y > 0.0, 0.22 - 0.5 * y, 0.22 + 1.4 * y))
    return t.mixed(ground, figure, (hem | lozenge).astype(float)) * weave[..., None]


def leaf(size):
    """A pointed leaf that grows from the image's lower edge to its upper; clear round it."""
    across, up = numpy.meshgrid((numpy.arange(size) + 0.5) / size - 0.5,
                                (numpy.arange(size) + 0.5) / size)
    width = 0.44 * numpy.sin(math.pi * numpy.clip(up, 0.0, 0.98)) ** 0.7
    green = t.mixed([0.30, 0.46, 0.16], [0.20, 0.34, 0.10], numpy.abs(across) / 0.45)
    rib = numpy.abs(across) < 0.025
    green[rib] = [0.55, 0.62, 0.30]
    # Far below and far above the cutoff on either side of the edge, as a bilinear mask is cut half way.
    return numpy.dstack([green, (numpy.abs(across) < width).astype(float)])


def column_mesh(name, height, radius):
    """A round column on a round base; the shaft swells a little, the capital spreads."""
    def torus(base, size, low, tall):
        return [(base + size * math.sin(math.pi * i / 6), low + tall * i / 6) for i in range(7)]
    profile = ([(1.45, -SINK), (1.45, 0.09)] + torus(1.22, 0.20, 0.09, 0.09)
               + [(1.12, 0.20), (1.10, 0.22)] + torus(1.06, 0.10, 0.23, 0.05) + [(1.0, 0.30)])
    shaft = [(1.0 - 0.14 * (i / 8) ** 1.6, 0.30 + (height - 0.68) * i / 8) for i in range(1, 9)]
    neck = height - 0.38
    profile += shaft + torus(0.86, 0.10, neck + 0.01, 0.04)
    profile += [(0.88 + 0.55 * (i / 6) ** 2.0, neck + 0.06 + 0.22 * i / 6) for i in range(7)]
    profile = [(radius * r, z) for r, z in profile] + [(radius * 1.43, height - 0.09)]
    return t.round_uvs(m.lathe_mesh(name, profile, 64, 40.0), 1.0, 1.2)


def arch_mesh(name, height, depth, segments=36):
    """A wall of one bay, from the springing to `height` above it, with the arch cut out."""
    half = PITCH / 2
    inner = [(-half, 0.0)] + [(-RADIUS * math.cos(math.pi * i / segments),
                              RADIUS * math.sin(math.pi * i / segments))
                             for i in range(segments + 1)] + [(half, 0.0)]
    outer = [(x if abs(x) == half else half * x / RADIUS, height) for x, _ in inner]
    vertices = [(x, y, z) for y in (-depth / 2, depth / 2) for line in (inner, outer)
                for x, z in line]
    n = len(inner)
    faces = []
    for i in range(n - 1):
        faces.append((i, i + 1, n + i + 1, n + i))                              # front
        faces.append((2 * n + i + 1, 2 * n + i, 3 * n + i, 3 * n + i + 1))      # back
        faces.append((i + 1, i, 2 * n + i, 2 * n + i + 1))                      # soffit
        faces.append((n + i, n + i + 1, 3 * n + i + 1, 3 * n + i))              # top
    faces.append((0, n, 3 * n, 2 * n))
    faces.append((n - 1, 3 * n - 1, 4 * n - 1, 2 * n - 1))
    mesh = m.smooth_by_angle(m.mesh_of(name, vertices, faces), 30.0)
    return t.box_uvs(mesh, 1.6)


def moulding_mesh(name, segments=36):
    """The profiled band round an arch, which stands out of the wall."""
    profile = [(0.02, 0.05), (0.02, -0.055), (0.05, -0.075), (0.08, -0.055), (0.10, -0.075),
               (0.14, -0.085), (0.17, -0.060), (0.17, 0.05)]  # outwards from the arch; depth
    vertices, faces = [], []
    for i in range(segments + 1):
        angle = math.pi * i / segments
        for out, depth in profile:
            r = RADIUS + out
            vertices.append((-r * math.cos(angle), depth, r * math.sin(angle)))
    n = len(profile)
    for i in range(segments):
        for j in range(n):
            faces.append((i * n + j, i * n + (j + 1) % n, (i + 1) * n + (j + 1) % n,
                          (i + 1) * n + j))
    faces.append(tuple(reversed(range(n))))
    faces.append(tuple(range(segments * n, (segments + 1) * n)))
    return m.smooth_by_angle(m.mesh_of(name, vertices, faces), 40.0)


def baluster_mesh(name):
    profile = [(0.062, -SINK), (0.062, 0.05), (0.040, 0.07), (0.034, 0.10), (0.050, 0.15),
               (0.068, 0.22), (0.060, 0.29), (0.036, 0.38), (0.028, 0.47), (0.034, 0.54),
               (0.050, 0.56), (0.036, 0.59), (0.058, 0.63), (0.062, 0.70)]
    return m.lathe_mesh(name, profile, 24, 40.0)


def bays():
    """(position, turn in degrees) of every bay: its middle, and the turn that makes its front, -Y
    in the mesh, face the courtyard."""
    for i in range(BAYS):
        y = PITCH * (i + 0.5)
        yield (-HALF, y), 90.0
        yield (HALF, y), -90.0
    for x in (-PITCH, 0.0, PITCH):
        yield (x, PITCH * BAYS), 0.0


def columns():
    for i in range(BAYS + 1):
        yield -HALF, PITCH * i
        yield HALF, PITCH * i
    for x in (-PITCH / 2, PITCH / 2):
        yield x, PITCH * BAYS


def shell(s):
    """Floors, walls and roofs: long solids about the courtyard."""
    far, outer = PITCH * BAYS, HALF + AISLE
    m.add("court", t.box_uvs(m.box_mesh("court", (-outer, -2.0, -0.2), (outer, far + AISLE, 0.0)),
                             1.2), s["floor"])
    for side, name in ((-1, "left"), (1, "right")):
        wall = sorted((side * outer, side * (outer + 0.4)))
        m.add(f"{name} wall", t.box_uvs(m.box_mesh(
            f"{name} wall", (wall[0], -2.0, -0.1), (wall[1], far + AISLE + 0.4, TOP)), 1.6),
            s["ashlar"])
        # Slab of the gallery and roof of the aisle, from a little before the columns to the wall.
        strip = sorted((side * (HALF - 0.26), side * (outer + SINK)))
        for part, low, high, surface in (("gallery", STOREY - 0.2, STOREY, "marble"),
                                         ("roof", TOP - 0.15, TOP + 0.12, "plaster")):
            mesh = m.box_mesh(f"{name} {part}", (strip[0], -2.0, low), (strip[1], far - 0.26, high))
            m.add(f"{name} {part}", t.box_uvs(mesh, 1.2) if surface == "marble" else mesh,
                  s[surface])
    m.add("far wall", t.box_uvs(m.box_mesh(
        "far wall", (-outer - SINK, far + AISLE, -0.1), (outer + SINK, far + AISLE + 0.4, TOP)),
        1.6), s["ashlar"])
    for part, low, high, surface in (("gallery", STOREY - 0.2, STOREY, "marble"),
                                     ("roof", TOP - 0.15, TOP + 0.12, "plaster")):
        mesh = m.box_mesh(f"far {part}", (-outer - SINK, far - 0.261, low),
                          (outer + SINK, far + AISLE + SINK, high))
        m.add(f"far {part}", t.box_uvs(mesh, 1.2) if surface == "marble" else mesh, s[surface])


def arcades(s):
    lower, upper = (column_mesh(f"{name} column", height, radius) for name, height, radius in (
        ("lower", SPRING[0] - 0.10, 0.17), ("upper", SPRING[1] - STOREY - 0.10, 0.13)))
    abacus = m.box_mesh("abacus", (-0.25, -0.25, 0.0), (0.25, 0.25, 0.10 + SINK))
    for number, (x, y) in enumerate(columns()):
        for storey, (mesh, base) in enumerate(((lower, 0.0), (upper, STOREY))):
            m.add(f"{mesh.name} {number}", mesh, s["marble"], location=(x, y, base),
                  rotation_z=37.0 * number)
            m.add(f"abacus {storey} {number}", abacus, s["plaster"],
                  location=(x, y, SPRING[storey] - 0.10 - SINK))
    arches = [arch_mesh("lower arch", STOREY - 0.2 - SPRING[0] + SINK, 0.36),
              arch_mesh("upper arch", TOP - 0.15 - SPRING[1] + SINK, 0.30)]
    moulding, baluster = moulding_mesh("moulding"), baluster_mesh("baluster")
    rail = m.box_mesh("rail", (-PITCH / 2, -0.09, 0.70 - SINK), (PITCH / 2, 0.09, 0.78))
    for number, ((x, y), turn) in enumerate(bays()):
        for storey, arch in enumerate(arches):
            m.add(f"{arch.name} {number}", arch, s["ashlar"], location=(x, y, SPRING[storey]),
                  rotation_z=turn)
            front = Matrix.Rotation(math.radians(turn), 4, "Z") @ Vector((0, -0.14, 0))
            m.add(f"moulding {storey} {number}", moulding, s["plaster"],
                  location=(x + front.x, y + front.y, SPRING[storey]), rotation_z=turn)
        m.add(f"rail {number}", rail, s["plaster"], location=(x, y, STOREY), rotation_z=turn)
        across = Matrix.Rotation(math.radians(turn), 4, "Z") @ Vector((1, 0, 0))
        for i in range(7):
            step = (i - 3) * 0.24
            m.add(f"baluster {number} {i}", baluster, s["plaster"],
                  location=(x + step * across.x, y + step * across.y, STOREY))


def drape_mesh(name, width=1.36, height=2.05, columns_=40, rows=48):
    """A sheet that hangs from z = 0 in folds, which get deeper downwards."""
    vertices, faces = [], []
    for row in range(rows + 1):
        down = row / rows
        for i in range(columns_ + 1):
            u = i / columns_ - 0.5
            depth = (0.02 + 0.07 * down) * math.sin(12.0 * math.pi * u + 0.6 * math.sin(4.0 * down))
            sag = 0.06 * (1.0 - 4.0 * u * u) * (1.0 - down)
            vertices.append((u * width * (1.0 - 0.08 * down), depth, -height * down - sag))
    for row in range(rows):
        for i in range(columns_):
            a = row * (columns_ + 1) + i
            faces.append((a, a + columns_ + 1, a + columns_ + 2, a + 1))
    mesh = m.mesh_of(name, vertices, faces, smooth=True)
    layer = mesh.uv_layers.new(name="UVMap")
    for loop in mesh.loops:
        row, i = divmod(loop.vertex_index, columns_ + 1)
        layer.data[loop.index].uv = (i / columns_, 1.0 - row / rows)
    return mesh


def drapes(s):
    meshes = {colour: drape_mesh(f"{colour} drape") for colour in ("red", "green", "blue")}
    order = ("red", "green", "blue")
    number = 0
    for (x, y), turn in bays():
        if abs(x) < HALF or not PITCH < y < PITCH * (BAYS - 1):
            continue
        colour = order[int(y / PITCH + (1 if x > 0 else 0)) % 3]
        number += 1
        m.add(f"{colour} drape {number}", meshes[colour], s[colour],
              location=(x, y, SPRING[0] + 0.55), rotation_z=turn)


def plant_mesh(name, leaves=70):
    """Leaves about a middle, each a strip of four quads that bends outwards."""
    dice = numpy.random.RandomState(3)
    vertices, faces, uvs = [], [], []
    for number in range(leaves):
        heading = 2.0 * math.pi * (number * 0.381966 + 0.03 * dice.random_sample())
        length, width = 0.55 + 0.35 * dice.random_sample(), 0.085 + 0.03 * dice.random_sample()
        lean = 0.15 + 0.85 * number / leaves
        for step in range(5):
            share = step / 4
            out = length * share * lean * (0.35 + 0.65 * share)
            up = length * share * (1.15 - lean * (0.35 + 0.55 * share))
            for side in (-1, 1):
                vertices.append((out * math.cos(heading) - side * width * math.sin(heading),
                                 out * math.sin(heading) + side * width * math.cos(heading), up))
                uvs.append(((side + 1) / 2, share))
        for step in range(4):
            a = 10 * number + 2 * step
            faces.append((a, a + 1, a + 3, a + 2))
    mesh = m.mesh_of(name, vertices, faces, smooth=True)
    layer = mesh.uv_layers.new(name="UVMap")
    for loop in mesh.loops:
        layer.data[loop.index].uv = uvs[loop.vertex_index]
    return mesh


def plants(s):
    pot = m.lathe_mesh("pot", [(0.20, -SINK), (0.24, 0.04), (0.30, 0.34), (0.34, 0.36), (0.34, 0.44),
                               (0.29, 0.44), (0.28, 0.38)], 48, 40.0)
    soil = m.lathe_mesh("soil", [(0.24, 0.30), (0.285, 0.39)], 48)
    plant = plant_mesh("plant")
    for number, (x, y) in enumerate(((-2.2, 3.0), (2.2, 5.0), (-2.2, 9.0), (2.2, 11.0), (0.0, 14.6))):
        for mesh, surface in ((pot, "clay"), (soil, "soil")):
            m.add(f"{mesh.name} {number}", mesh, s[surface], location=(x, y, 0.0))
        m.add(f"plant {number}", plant, s["leaf"], location=(x, y, 0.38), rotation_z=51.0 * number)


def cameras():
    m.camera("main", (0.9, 0.4, 1.75), (-0.9, 9.0, 2.75), 68.0)
    m.camera("drapes", (0.6, 5.2, 1.5), (-3.0, 7.6, 1.75), 58.0)
    m.camera("gallery", (2.2, 1.0, 5.6), (-1.6, 9.0, 3.2), 64.0)


m.begin()
surfaces = pictures()
for build in (shell, arcades, drapes, plants):
    build(surfaces)
cameras()
m.probe_world("sky_sun")
m.finish()
