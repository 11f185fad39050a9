"""Builds the stand-in for the scene of the S3HO paper's Figure 6: towers under a sky with a sun.

    blender --background --factory-startup --python-exit-code 3 \
        --python scenes/skyline/build.py -- scenes/skyline/skyline.glb

A model of a city on a table, all white: rectangular towers on a grid of streets, up to 1.4 m high,
some on a podium, some with a setback. The probe's sun stands to the right of the camera, a little
behind it, so that streets have a side that it lights and one that only the blue sky does. The middle
of the view is a wide street with a free-standing tower, whose two shadows the closeups compare.
"""

import pathlib
import random
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import modelling as m  # noqa: E402

SINK = m.SINK
PITCH = 0.92  # from one plot's middle to the next's


def tower(name, white, centre, half, height, turn=0.0, base=0.0):
    x, y = half
    m.add(name, m.box_mesh(name, (-x, -y, base - SINK), (x, y, height)), white,
          location=(*centre, 0.0), rotation_z=turn)


def plot(number, centre, dice, white):
    """A tower, or one on a podium, or one that narrows upwards."""
    half = (dice.uniform(0.19, 0.29), dice.uniform(0.19, 0.29))
    height = dice.choice((0.35, 0.5, 0.62, 0.75, 0.9, 1.1, 1.3)) * dice.uniform(0.9, 1.1)
    kind = dice.choice(("plain", "plain", "podium", "setback"))
    name = f"tower {number}"
    if kind == "podium":
        podium = 0.12
        tower(f"{name} podium", white, centre, (0.34, 0.34), podium)
        tower(name, white, centre, half, height, base=podium)
    elif kind == "setback":
        tower(name, white, centre, half, 0.65 * height)
        tower(f"{name} top", white, centre, (0.65 * half[0], 0.65 * half[1]), height,
              base=0.65 * height)
    else:
        tower(name, white, centre, half, height)


def city(white):
    dice = random.Random(6)
    m.add("ground", m.mesh_of("ground", [(-14, -14, 0), (14, -14, 0), (14, 14, 0), (-14, 14, 0)],
                              [(0, 1, 2, 3)]), white)
    number = 0
    for row in range(6):
        for column in range(-4, 5):
            centre = (PITCH * column, PITCH * row - 0.4)
            if row < 2 and abs(column) <= 1:
                continue  # the square in front
            number += 1
            plot(number, centre, dice, white)
    tower("free tower", white, (0.0, 0.0), (0.24, 0.22), 0.85, turn=8.0)
    tower("low block", white, (0.95, -0.55), (0.22, 0.16), 0.30, turn=-6.0)
    tower("pavilion", white, (-1.0, -0.62), (0.17, 0.15), 0.22, turn=14.0)


m.begin()
city(m.lambert("white", 0.8))
m.camera("main", (0.15, -3.9, 2.75), (0.0, 0.45, 0.36), 46.0)
m.probe_world("sky_sun")
m.finish()
