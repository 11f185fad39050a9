"""Builds the scenes of known occlusion in this folder.

    python3 scenes/analytic/build.py

World space: tangent planes are z = 0 with normal +Z unless a comment says otherwise.
"""

import math
import pathlib

import bounce
import closed_forms as exact
import curved
import walls
from closed_forms import PI, agrees
from scene_file import SceneFile, camera_at, quad, sphere_part
from traced import FLOATS, HALVES, LINEAR, MARCHED, PASSES, SKY, ray

HERE = pathlib.Path(__file__).resolve().parent

LINEAR_ON_FLOOR = [1 + 2 / 3 * 0.5, 1.0, 1 + 2 / 3 * 0.8]  # E/pi = a + (2/3) b.n
CONES = "128x64 texels of the cone levels"


def plane():
    scene = SceneFile().mesh(quad((-20, -20, 0), (40, 0, 0), (0, 40, 0)))
    scene.camera("oblique", camera_at((1, -5, 4), (0, 0, 0)), 0.5)
    view = {"camera": "oblique", "resolution": [32, 20]}
    marched = [*MARCHED, "steps=2"]
    for d_max in ("1", "inf"):
        ray(scene, f"open, d_max = {d_max}", "k = 1: nothing blocks", (0, 0, 0), (0, 0, 1), 1.0,
            settings=[f"d_max_world={d_max}"])
    for angle in (0.3, 0.8, 1.2):
        tilted = (math.sin(angle), 0.0, math.cos(angle))
        ray(scene, f"shading normal {angle:g} off",
            "k = (1 + cos t)/2: below the surface is itself", (0, 0, 0), tilted,
            0.5 * (1 + math.cos(angle)), scene.lift(), "lift of the rays' origin",
            settings=["d_max_world=1"], geometric_normal=[0, 0, 1])
    ray(scene, "linear sky", "E = pi a + (2 pi/3) b.n", (0, 0, 0), (0, 0, 1), LINEAR_ON_FLOOR, 2e-4,
        SKY, quantity="radiance", settings=["d_max_world=1"], sky=LINEAR)
    for methods, layer in ((("ssao", "s3ho"), "ambient_occlusion"),
                           (("ssbn",), "uniform_occlusion")):
        scene.case("open", "k = 1: heights are stratified", methods, layer, 1.0, HALVES, FLOATS,
                   settings=marched, view=view, seeds=4)
    scene.case("white sky", "E/pi = k = 1", PASSES, "radiance", [1, 1, 1], 3e-3,
               "half floats; a cone of 128 directions", settings=marched, view=view, seeds=4)
    scene.case("linear sky", "E = pi a + (2 pi/3) b.n", PASSES, "radiance", LINEAR_ON_FLOOR, 2e-3,
               f"half floats, {CONES}", settings=marched, view=view, sky=LINEAR)
    scene.case("cosine lobe", "zonal sqrt(pi)/2, sqrt(pi/3), sqrt(5 pi)/8, 0 [Herholz et al. 2012]",
               ["s3ho"], "sh_visibility",
               exact.at_zonal([agrees(math.sqrt(PI) / 2, 0.886227),
                               agrees(math.sqrt(PI / 3), 1.023327),
                               agrees(math.sqrt(5 * PI) / 8, 0.495416), 0.0]),
               HALVES, f"{FLOATS}; height strata", settings=marched, view=view)
    scene.case("bent normal", "N = n/2: the hemisphere's mean [Klehm et al. 2011]", ["ssbn"],
               "bent_normal", [0, 0, 0.5], 1e-4, "floats", settings=marched, view=view)
    two_colours(scene, view)
    filters(scene, view)
    scene.write(HERE / "plane.glb")


def two_colours(scene, view):
    """A white half of the sky, tilted by theta from the normal: E/pi = (1 + cos theta)/2."""
    for degrees in (0, 60, 90, 120, 180):
        t = math.radians(degrees)
        # Turned aside by what leaves no texel edge on the tangent plane.
        up = (math.sin(t) * math.cos(0.3), math.sin(t) * math.sin(0.3), math.cos(t))
        sky = {"halves": {"up": up, "above": [1, 0.5, 0], "below": [0, 0.5, 1]}}
        share = 0.5 * (1 + math.cos(t))
        expected = [share, 0.5, 1 - share]
        source = "E/pi = (1 + cos theta)/2, exact for two halves"
        for estimator in ("mis", "cosine", "environment"):
            ray(scene, f"two halves, theta = {degrees}, {estimator}", source, (0, 0, 0), (0, 0, 1),
                expected, 2e-5, "float cosines beside the border", quantity="radiance", sky=sky,
                settings=["d_max_world=1", f"estimator={estimator}"])
        if degrees in (60, 120):
            # Order 4 is exact too: the cosine lobe has no band 3, the halves no even band above 0.
            scene.case(f"two halves, theta = {degrees}", source, PASSES, "radiance", expected, 4e-3,
                       f"half floats, {CONES}", settings=[*MARCHED, "steps=1"], view=view, sky=sky)


def filters(scene, view):
    """What the 8x8 filter must keep."""
    few = ["samples=16", "steps=1"]
    scene.case("filter keeps a constant", "weights are normalised", ["ssao", "s3ho", "ssdo"],
               "radiance", [1, 1, 1], HALVES, FLOATS, settings=few, view=view, seeds=4)
    scene.case("filter keeps the mean", "E = pi a + (2 pi/3) b.n, of 4x4 sets in an 8x8 window",
               ["s3ho", "ssdo"], "radiance", LINEAR_ON_FLOOR, 2e-3, f"half floats, {SKY}",
               settings=["samples=64", "steps=1", "filter_scale=1e6"], sky=LINEAR,
               view={**view, "pixels": [8, 4, 16, 12]})


def sun():
    """A light of E_perp = 1 along the normal."""
    scene = SceneFile().mesh(quad((-20, -20, 0), (40, 0, 0), (0, 40, 0)))
    scene.camera("oblique", camera_at((1, -5, 4), (0, 0, 0)), 0.5)
    scene.sun("sun", camera_at((0, 0, 9), (0, 0, 0), up=(0, 1, 0)), [1, 1, 1])
    view = {"camera": "oblique", "resolution": [16, 12]}
    dark = {"constant": [0, 0, 0]}
    ray(scene, "directional", "E = E_perp cos", (0, 0, 0), (0, 0, 1), [1 / PI] * 3, 1e-6, "floats",
        quantity="radiance", sky=dark)
    scene.case("directional", "E = E_perp cos", ["ssao", "ssdo", "ssbn"], "radiance", [1 / PI] * 3,
               1e-3, "a cone of 128 directions", settings=[*MARCHED, "steps=1"], view=view,
               sky=dark, seeds=4)
    window = [0.5 * (1 + math.cos(PI * band / 4)) for band in range(4)]
    lobe = [PI, 2 * PI / 3, PI / 4, 0]  # times A_l, of the delta light's (2l+1)/4pi
    for name, width, weights, published in (("no window", 0, [1] * 4, 17 / 16),
                                            ("Hanning window of 4", 4, window, 0.833027)):
        response = sum(w * a * (2 * band + 1) / (4 * PI)
                       for band, (w, a) in enumerate(zip(weights, lobe)))
        agrees(response, published, 5)
        scene.case(f"directional, {name}", "sum w_l A_l (2l+1)/(4 pi)", ["s3ho"], "radiance",
                   [response / PI] * 3, 1e-3, f"{FLOATS}; height strata", view=view, sky=dark,
                   seeds=4, settings=[*MARCHED, "steps=1", f"hanning_width={width}"])
    scene.write(HERE / "sun.glb")


def asymmetric():
    """No symmetry, and a sky with every band: what turning and mirroring must not change."""
    scene = SceneFile()
    scene.mesh(quad((-9, -9, 0), (18, 0, 0), (0, 18, 0)))
    scene.mesh(quad((-0.2, -0.5, 0), (0.3, 0, 1.4), (0.2, 2, 0)))
    scene.mesh(sphere_part((1.1, -0.2, 0.5), 0.5))
    scene.camera("main", camera_at((4, -3, 3), (0.5, 0, 0.5)), 0.45)
    scene.sun("sun", camera_at((1, 0.5, 2), (0, 0, 0)), [0.6, 0.4, 0.2])
    view = {"camera": "main", "resolution": [48, 32]}
    harmonics = [[4, 3, 2.5], [0.2, -0.4, 0.3], [0.5, 0.1, -0.2], [-0.3, 0.4, 0.2],
                 [0.3, -0.2, 0.1], [-0.2, 0.1, 0.3], [0.1, 0.2, -0.1], [0.3, -0.1, 0.2],
                 [-0.1, 0.2, 0.2], [0.2, 0.1, -0.2], [-0.2, 0.2, 0.1], [0.1, -0.2, 0.2],
                 [0.2, 0.1, 0.1], [-0.2, 0.1, -0.1], [0.1, 0.2, -0.2], [0.2, -0.1, 0.1]]
    sky = {"harmonics": harmonics}
    sources = {"turn": "scene, camera, light and sky turned and moved together",
               "roll": "the camera on its head, the picture upside down",
               "mirror": "scene, light and sky mirrored, the picture mirrored"}
    edges = "rounding at the edges of pixels, texels and facets"
    for word, source in sources.items():
        scene.case(word, source, ["rtdo"], "radiance",
                   None, 1e-3, edges, settings=["rays_per_pixel=256", "d_max_world=1"],
                   view=view, sky=sky, same_under=word, seeds=16)
        scene.case(word, source, PASSES, "radiance",
                   None, 4e-3, edges, settings=["samples=64", "filter=none"], view=view, sky=sky,
                   same_under=word, seeds=16)
        scene.case(f"{word}, traced", source,
                   ["s3ho", "ssdo", "ssbn"], "radiance", None, 4e-3, edges, view=view, sky=sky,
                   settings=["samples=64", "filter=none", "visibility=traced"], same_under=word,
                   seeds=8)
    scene.write(HERE / "asymmetric.glb")

    scene = SceneFile()
    scene.mesh(quad((-9, -9, 0), (18, 0, 0), (0, 18, 0)))
    scene.mesh(quad((-0.2, -0.5, 0), (0.3, 0, 1.4), (0.2, 2, 0)))
    scene.camera("main", camera_at((4, -3, 3), (0.5, 0, 0.5)), 0.45)
    furnace(scene)
    bounce.furnace(scene)
    scene.write(HERE / "furnace.glb")


def furnace(scene):
    """L = 1, sample by sample, pixel by pixel: E/pi = k."""
    view = {"camera": "main", "resolution": [48, 32]}
    scene.case("furnace", "E/pi = k for L = 1, the same rays", ["rtdo"], "radiance", None, 1e-5,
               "floats", settings=["estimator=cosine", "rays_per_pixel=256"], view=view,
               equals={"method": "rtdo", "quantity": "ambient_occlusion",
                       "set": ["estimator=cosine", "rays_per_pixel=256"]})
    for visibility in ("depth", "traced"):
        for weight in ("binary", "lambda", "smoothstep"):
            settings = ["filter=none", f"weight={weight}", f"visibility={visibility}"]
            same = {"view": view, "settings": settings, "equals": {
                "method": "ssao", "quantity": "ambient_occlusion", "set": settings}}
            name = f"furnace, {weight}, {visibility}"
            scene.case(name, "k_A = (2/sqrt(pi)) c_0, the same samples", ["s3ho"],
                       "ambient_occlusion", None, 2 ** -10, "a last bit of a half float", **same)
            scene.case(name, "E/pi = k for L = 1, the same samples", ["ssao", "s3ho", "ssdo"],
                       "radiance", None, 2e-3, "half floats", **same)


def main():
    for build in (plane, sun, asymmetric, walls.wall, walls.corner, walls.three_planes,
                  walls.walls_of_finite_height, curved.sphere_on_a_plane, curved.bowls,
                  curved.closed_sphere, curved.well):
        build()


if __name__ == "__main__":
    main()
