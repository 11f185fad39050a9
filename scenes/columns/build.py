"""Builds the scene of the SSDO paper's Figure 7: a pink column hidden behind a white one.

    blender --background --factory-startup --python-exit-code 3 \
        --python scenes/columns/build.py -- scenes/columns/columns.glb

Seen from `main`, no pixel shows the pink column. The sun, from the left, lights its left side, which
throws pink light onto the floor and the wall beside the white column, and it casts a shadow to the
right of it: both are missing from what a single view knows. `side` sees the pink column.
"""

import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import modelling as m  # noqa: E402

SINK = m.SINK


def column(name, surface, centre, radius, height):
    """A round shaft on a round foot; both are solids of their own."""
    profile = [(radius + 0.03, -SINK), (radius + 0.03, 0.04), (radius + 0.015, 0.055),
               (radius, 0.06), (radius, height)]
    m.add(name, m.lathe_mesh(name, profile, 96), surface, location=(*centre, 0.0))


m.begin()
white, pink = m.lambert("white", 0.8), m.lambert("pink", (0.8, 0.12, 0.35))
m.add("floor", m.box_mesh("floor", (-2.6, -2.4, -0.1), (2.6, 1.3, 0.0)), white)
m.add("wall", m.box_mesh("wall", (-2.6, 0.95, -SINK), (2.6, 1.1, 1.9)), white)
column("white column", white, (0.0, 0.0), 0.24, 1.5)
column("pink column", pink, (0.0, 0.52), 0.21, 1.2)
m.sun("sun", (-0.82, -0.30, 0.62), (1.0, 0.97, 0.90), 3.0)
m.camera("main", (0.0, -3.4, 1.15), (0.0, 0.3, 0.45), 40.0)
m.camera("side", (-2.2, -2.0, 1.15), (0.0, 0.3, 0.45), 40.0)
m.probe_world("dusk", 0.6)
m.finish()
