"""Builds the stand-in for the factory of the SSDO paper's Figure 1 and Table 1: 537k polygons there.

    blender --background --factory-startup --python-exit-code 3 \
        --python scenes/factory/build.py -- scenes/factory/factory.glb

A hall of 14 x 26 m whose roof is open trusses, so that the sky lights it: two conveyors with castings,
presses with motors and flywheels, pipes with flanges and valves, barrels, crates and riveted columns.
Every kind of thing is one mesh that is placed many times, so that the file stays small. All meshes
are closed.
"""

import math
import pathlib
import random
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import bpy  # noqa: E402
from mathutils import Matrix, Vector  # noqa: E402

import modelling as m  # noqa: E402

SINK = m.SINK
WIDTH, LENGTH, HEIGHT = 7.0, 26.0, 5.5  # half the hall's width; its depth; the trusses' height


class Place:
    """Adds copies of meshes, turned about Z, relative to a thing's own origin."""

    def __init__(self, name, origin, turn=0.0):
        self.name, self.origin, self.turn, self.count = name, Vector(origin), turn, 0

    def add(self, mesh, surface, at=(0, 0, 0), turn=0.0, scale=1.0):
        self.count += 1
        here = self.origin + Matrix.Rotation(math.radians(self.turn), 3, "Z") @ Vector(at)
        m.add(f"{self.name} {self.count}", m.in_material(mesh, surface), surface, location=here,
              rotation_z=self.turn + turn, scale=scale)


def lying(mesh, axis="Y"):
    """What was revolved about Z, lying along an axis."""
    return m.transformed(mesh, Matrix.Rotation(math.pi / 2, 4, "Y" if axis == "X" else "X"))


def bevelled_box(name, low, high, width=0.02):
    thing = m.add(name, m.box_mesh(name, low, high))
    modifier = thing.modifiers.new("bevel", "BEVEL")
    modifier.width, modifier.segments, modifier.limit_method = width, 2, "ANGLE"
    m.smooth_by_angle(thing.data, 30.0)
    mesh = m.apply_modifiers(thing)
    bpy.data.objects.remove(thing)
    mesh.name = name
    return mesh


def gear_mesh(name, radius, teeth, height):
    """A gear wheel about Z with a hub; its rim alternates between tooth and gap."""
    profile = [(0.20 * radius, 0.0), (0.85 * radius, 0.0), (radius, 0.04 * radius),
               (radius, height - 0.04 * radius), (0.85 * radius, height), (0.80 * radius, height),
               (0.76 * radius, 0.70 * height), (0.38 * radius, 0.70 * height),
               (0.34 * radius, 1.25 * height), (0.20 * radius, 1.25 * height)]

    def toothed(index, angle):
        if index not in (2, 3):
            return 1.0
        return 1.0 + 0.09 * max(-1.0, min(1.0, 2.5 * math.sin(teeth * angle)))

    return m.lathe_mesh(name, profile, 8 * teeth, 30.0, toothed)


def motor_mesh(name):
    """A motor with cooling fins and a shaft, lying along X."""
    profile = [(0.05, -0.62), (0.05, -0.42), (0.19, -0.42), (0.21, -0.38)]
    for fin in range(10):
        z = -0.34 + 0.06 * fin
        profile += [(0.21, z), (0.255, z + 0.008), (0.255, z + 0.022), (0.21, z + 0.030)]
    profile += [(0.21, 0.28), (0.20, 0.36), (0.15, 0.40), (0.06, 0.41)]
    return lying(m.lathe_mesh(name, profile, 36, 35.0), "X")


def flywheel_mesh(name):
    def ring(t):
        return 0.55 * math.cos(2 * math.pi * t), 0.0, 0.55 * math.sin(2 * math.pi * t)

    return m.tube_mesh(name, ring, 0.07, 20, 72)


def handwheel_mesh(name):
    def ring(t):
        return 0.11 * math.cos(2 * math.pi * t), 0.11 * math.sin(2 * math.pi * t), 0.0

    return m.tube_mesh(name, ring, 0.018, 10, 36)


def pipe_mesh(name, length, radius):
    """A pipe along Z with a flange at either end and a band in the middle."""
    r = radius
    half = length / 2
    return m.lathe_mesh(name, [
        (1.5 * r, -half), (1.5 * r, -half + 0.04), (r, -half + 0.045), (r, -0.05), (1.12 * r, -0.04),
        (1.12 * r, 0.04), (r, 0.05), (r, half - 0.045), (1.5 * r, half - 0.04), (1.5 * r, half)],
        32, 35.0)


def barrel_mesh(name):
    profile = [(0.27, -SINK), (0.285, 0.0), (0.285, 0.03), (0.27, 0.04)]
    for ring in (0.29, 0.58):
        profile += [(0.275, ring - 0.04), (0.292, ring - 0.02), (0.292, ring + 0.01),
                    (0.275, ring + 0.03)]
    profile += [(0.27, 0.84), (0.285, 0.85), (0.285, 0.88), (0.262, 0.88), (0.258, 0.86)]
    return m.lathe_mesh(name, profile, 40, 35.0)


def joined(name, boxes):
    """Boxes in one mesh; where they meet they overlap."""
    vertices, faces = [], []
    for low, high in boxes:
        base = len(vertices)
        (x0, y0, z0), (x1, y1, z1) = low, high
        vertices += [(x, y, z) for z in (z0, z1) for y in (y0, y1) for x in (x0, x1)]
        faces += [tuple(base + i for i in face) for face in (
            (0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))]
    return m.mesh_of(name, vertices, faces)


def bar(name, start, end, thickness):
    """A box from one point to another in the plane of X and Z."""
    run = Vector(end) - Vector(start)
    mesh = m.box_mesh(name, (-thickness, -thickness, 0), (thickness, thickness, run.length))
    angle = math.atan2(run.x, run.z)
    return m.transformed(mesh, Matrix.Translation(start) @ Matrix.Rotation(angle, 4, "Y"))


def colours():
    return {
        "concrete": m.lambert("concrete", 0.55), "wall": m.lambert("wall", (0.66, 0.60, 0.52)),
        "steel": m.lambert("steel", (0.42, 0.44, 0.47)), "green": m.lambert("green", (0.16, 0.40, 0.24)),
        "yellow": m.lambert("yellow", (0.80, 0.60, 0.08)), "red": m.lambert("red", (0.65, 0.10, 0.07)),
        "blue": m.lambert("blue", (0.10, 0.22, 0.52)), "wood": m.lambert("wood", (0.50, 0.34, 0.18)),
        "light": m.lambert("light", 0.72),
    }


def hall(s):
    m.add("floor", m.box_mesh("floor", (-WIDTH - 0.3, -3.0, -0.2), (WIDTH + 0.3, LENGTH + 0.3, 0)),
          s["concrete"])
    for side, name in ((-1, "left"), (1, "right")):
        low, high = sorted((side * WIDTH, side * (WIDTH + 0.3)))
        m.add(f"{name} wall", m.box_mesh(f"{name} wall", (low, -3.0, -0.1), (high, LENGTH + 0.3, 4.2)),
              s["wall"])
    m.add("far wall", m.box_mesh("far wall", (-WIDTH - SINK, LENGTH, -0.1),
                                 (WIDTH + SINK, LENGTH + 0.3, 4.2)), s["wall"])
    post = joined("post", [((-0.16, -0.14, -SINK), (0.16, -0.11, HEIGHT)),
                           ((-0.16, 0.11, -SINK), (0.16, 0.14, HEIGHT)),
                           ((-0.02, -0.12, -SINK), (0.02, 0.12, HEIGHT)),
                           ((-0.24, -0.22, -SINK), (0.24, 0.22, 0.06))])
    rivet = m.sphere_mesh("rivet", 0.022, 2)
    parts = [bar("t", (-WIDTH, 0, HEIGHT), (WIDTH, 0, HEIGHT), 0.07),
             bar("t", (-WIDTH, 0, HEIGHT + 0.1), (0, 0, HEIGHT + 1.2), 0.06),
             bar("t", (0, 0, HEIGHT + 1.2), (WIDTH, 0, HEIGHT + 0.1), 0.06)]
    parts += [bar("t", (x, 0, HEIGHT), (x + 0.7, 0, HEIGHT + 1.2 - 1.1 * abs(x + 0.7) / WIDTH), 0.035)
              for x in (-4.9, -3.5, -2.1, -0.7, 1.4, 2.8)]
    parts += [bar("t", (x, 0, HEIGHT), (x - 0.7, 0, HEIGHT + 1.2 - 1.1 * abs(x - 0.7) / WIDTH), 0.035)
              for x in (4.9, 3.5, 2.1, 0.7, -1.4, -2.8)]
    truss = m.mesh_of("truss", [tuple(v.co) for part in parts for v in part.vertices],
                      [tuple(8 * k + i for i in polygon.vertices)
                       for k, part in enumerate(parts) for polygon in part.polygons])
    for frame in range(9):
        y = 3.0 * frame
        m.add(f"truss {frame}", truss, s["steel"], location=(0, y, 0))
        for side in (-1, 1):
            x = side * (WIDTH - 0.35)
            m.add(f"post {frame} {side}", post, s["steel"], location=(x, y, 0.0))
            for number in range(18):
                for across in (-0.11, 0.11):
                    m.add("rivet", rivet, s["steel"], location=(x + across, y - 0.14,
                                                                0.2 + 0.29 * number))


def conveyors(s, dice):
    roller = lying(m.lathe_mesh("roller", [(0.03, -0.52), (0.03, -0.46), (0.075, -0.455),
                                           (0.08, -0.44), (0.08, 0.44), (0.075, 0.455),
                                           (0.03, 0.46), (0.03, 0.52)], 20, 35.0), "X")
    rail = m.box_mesh("side rail", (-0.03, 0, 0.62), (0.03, 20.0, 0.80))
    leg = joined("leg", [((-0.5, -0.04, -SINK), (-0.42, 0.04, 0.63)),
                         ((0.42, -0.04, -SINK), (0.5, 0.04, 0.63)),
                         ((-0.43, -0.03, 0.25), (0.43, 0.03, 0.31))])
    gear, small = gear_mesh("gear", 0.36, 24, 0.11), gear_mesh("small gear", 0.22, 16, 0.16)
    casting = bevelled_box("casting", (-0.28, -0.22, 0.0), (0.28, 0.22, 0.30), 0.04)
    for line, x in enumerate((-1.9, 1.9)):
        here = Place(f"conveyor {line}", (x, 1.0, 0.0))
        for side in (-0.5, 0.5):
            here.add(rail, s["yellow"], (side, 0, 0))
        for number in range(11):
            here.add(leg, s["steel"], (0, 2.0 * number, 0))
        for number in range(100):
            here.add(roller, s["steel"], (0, 0.1 + 0.2 * number, 0.73))
        for number in range(25):
            y, turn = 0.5 + 0.78 * number, dice.uniform(0.0, 90.0)
            mesh, surface = ((gear, "light"), (small, "yellow"), (casting, "red"),
                             (gear, "steel"))[dice.randrange(4)]
            here.add(mesh, s[surface], (dice.uniform(-0.06, 0.06), y, 0.808), turn)


def presses(s):
    """Machines along both walls."""
    body = bevelled_box("press body", (-0.7, -0.6, 0.0), (0.7, 0.6, 0.9), 0.04)
    head = bevelled_box("press head", (-0.6, -0.5, 1.7), (0.6, 0.5, 2.5), 0.05)
    post = m.lathe_mesh("press post", [(0.09, 0.88), (0.09, 1.72)], 32)
    ram = m.lathe_mesh("ram", [(0.22, 1.2), (0.26, 1.22), (0.26, 1.32), (0.13, 1.36), (0.13, 1.72)], 48)
    motor, fly, wheel = motor_mesh("motor"), flywheel_mesh("flywheel"), handwheel_mesh("handwheel")
    spoke = joined("spokes", [((-0.53, -0.03, -0.035), (0.53, 0.03, 0.035)),
                              ((-0.035, -0.028, -0.53), (0.035, 0.028, 0.53))])
    bolt = m.sphere_mesh("bolt", 0.03, 2)
    die = gear_mesh("die", 0.30, 20, 0.10)
    for number in range(8):
        for side in (-1, 1):
            here = Place(f"press {number} {side}", (side * 5.0, 2.2 + 2.9 * number, 0.0),
                         0.0 if side < 0 else 180.0)
            here.add(body, s["green"], (0, 0, -SINK))
            here.add(head, s["green" if number % 2 else "blue"])
            for x in (-0.5, 0.5):
                for y in (-0.38, 0.38):
                    here.add(post, s["light"], (x, y, 0))
            here.add(ram, s["steel"])
            here.add(die, s["light"], (0, 0, 0.898), 9.0 * number)
            here.add(motor, s["blue"], (-0.05, 0.12, 2.74))
            here.add(fly, s["red"], (-0.30, -0.62, 2.0))
            here.add(spoke, s["red"], (-0.30, -0.60, 2.0))
            here.add(wheel, s["yellow"], (0.45, 0.0, 2.52))
            for i in range(6):
                for x in (-0.62, 0.62):
                    here.add(bolt, s["steel"], (x, -0.5 + 0.2 * i, 0.9))


def pipes(s):
    thick, thin = pipe_mesh("thick pipe", 2.6, 0.13), pipe_mesh("thin pipe", 2.6, 0.06)
    for pipe in (thick, thin):
        lying(pipe, "Y")
    wheel = bpy.data.meshes["handwheel"]
    stem = m.lathe_mesh("stem", [(0.09, -0.14), (0.09, 0.10), (0.025, 0.12), (0.025, 0.26)], 32, 35.0)
    for number in range(10):
        y = 0.2 + 2.6 * number
        for side in (-1, 1):
            here = Place(f"pipes {number} {side}", (side * (WIDTH - 0.75), y, 0.0))
            for height, mesh, surface in ((3.1, thick, "light"), (3.5, thick, "red"),
                                          (3.82, thin, "blue"), (4.02, thin, "yellow"),
                                          (2.75, thin, "steel")):
                here.add(mesh, s[surface], (0, 0, height))
            if number % 2:
                here.add(stem, s["steel"], (0, 0.5, 3.62))
                here.add(wheel, s["yellow"], (0, 0.5, 3.86))


def goods(s, dice):
    barrel = barrel_mesh("barrel")
    slats = [((-0.4, -0.3, z), (0.4, 0.3, z + 0.10)) for z in (0.0, 0.125, 0.25, 0.375)]
    crate = joined("crate", slats + [((x - 0.05, -0.32, -SINK), (x + 0.05, 0.32, 0.48))
                                     for x in (-0.3, 0.0, 0.3)])
    number = 0
    for y in (0.9, 5.1, 9.6, 13.6, 17.4, 21.6):
        for x in (-0.42, 0.20):
            number += 1
            here = Place(f"barrel {number}", (x + dice.uniform(-0.05, 0.05), y, 0.0))
            here.add(barrel, s[("red", "blue", "yellow")[number % 3]], turn=31.0 * number)
            if number % 3 == 0:
                here.add(barrel, s["green"], (0.05, 0.02, 0.881), turn=20.0)
        here = Place(f"crates {number}", (dice.uniform(-0.15, 0.15), y + 1.6, 0.0),
                     dice.uniform(-20.0, 20.0))
        here.add(crate, s["wood"])
        here.add(crate, s["wood"], (0.06, 0.03, 0.48), 14.0)
        if number % 4 == 2:
            here.add(crate, s["wood"], (0.95, 0.1, 0.0), -8.0)


m.begin()
surfaces = colours()
random_numbers = random.Random(1)
hall(surfaces)
conveyors(surfaces, random_numbers)
presses(surfaces)
pipes(surfaces)
goods(surfaces, random_numbers)
m.camera("main", (0.3, -2.4, 3.0), (-0.25, 6.5, 1.15), 62.0)
m.camera("press", (-2.9, -1.2, 2.1), (-4.9, 2.6, 1.5), 52.0)
m.probe_world("sky_sun")
m.finish()
