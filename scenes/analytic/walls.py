"""The scenes of flat walls: closed forms, the march's expectation, the corner of Herholz et al."""

import math
import pathlib

import bounce
import closed_forms as exact
from closed_forms import PI, agrees
from scene_file import SceneFile, add, camera_at, quad, scale
from traced import (CLOSE, FLOATS, HALVES, LINEAR, MARCHED, SKY, close_up, ray, traced)

HERE = pathlib.Path(__file__).resolve().parent

WALL_EYE = (8.0, 0.0, 2.2)


def wall_camera(kappa, rows, row, focal):
    """Eight units before the wall x = 0, 15 degrees above; the centre of `row` shows (kappa, 0, 0).
    Returns (matrix, yfov, function of a row: the kappa that it shows)."""
    eye = WALL_EYE
    below = math.atan2(eye[2], eye[0] - kappa)
    pitch = below - math.atan((row + 0.5 - rows / 2) / focal)
    forward = (-math.cos(pitch), 0.0, -math.sin(pitch))

    def kappa_at(other):
        return eye[0] - eye[2] / math.tan(pitch + math.atan((other + 0.5 - rows / 2) / focal))

    return camera_at(eye, add(eye, forward)), 2 * math.atan(0.5 * rows / focal), kappa_at


def wall():
    """The floor before a wall at x = 0: the 90 degree corner, d_max = 1."""
    scene = SceneFile()
    scene.mesh(quad((0, -2, 0), (2, 0, 0), (0, 4, 0))).mesh(quad((0, -2, 0), (0, 4, 0), (0, 0, 2)))
    source = "k = 1 - (acos kappa - kappa sqrt(1 - kappa^2))/pi, projected disc area"
    for kappa, published in ((0.002, None), (0.25, 0.657481), (0.5, 0.804499), (0.75, None),
                             (0.95, None)):
        k = exact.wall(kappa) if published is None else agrees(exact.wall(kappa), published)
        ray(scene, f"kappa = {kappa:g}", source, (kappa, 0, 0), (0, 0, 1), k, 1e-6, "floats",
            settings=["d_max_world=1"])
    ray(scene, "kappa = 1.01", "k = 1: beyond d_max", (1.01, 0, 0), (0, 0, 1), 1.0,
        settings=["d_max_world=1"])
    for estimator in ("mis", "environment"):
        ray(scene, f"white furnace, kappa = .25, {estimator}", "E/pi = k for L = 1", (0.25, 0, 0),
            (0, 0, 1), [exact.wall(0.25)] * 3, 1e-5, "floats", quantity="radiance",
            settings=["d_max_world=1", f"estimator={estimator}"])
    blockers = {
        "weight=lambda": (["lambda_per_world=3"], lambda d: 3 * d / (1 + 3 * d)),
        "weight=smoothstep": (["fade_start=0.25"], lambda d: smoothstep(0.25, d))}
    for weight, (more, v) in blockers.items():
        k = exact.weighted_wall(0.25, 0.25, v)
        ray(scene, f"{weight}, kappa = .25", "projected disc area, weighted by the distance",
            (0.25, 0, 0), (0, 0, 1), k, 1e-5, "quadrature, floats",
            settings=["d_max_world=1", weight, *more])
    for kappa in (0.25, 0.5):
        marched_wall(scene, kappa)
    traced_wall(scene)
    leak(scene)
    bounce.wall(scene, WALL_EYE)
    scene.write(HERE / "wall.glb")


PUBLISHED_MARCH = {(0.25, 1): 0.831786, (0.5, 1): 0.948035, (0.25, 2): 0.715537,
                   (0.5, 2): 0.896070, (0.25, 4): 0.680531, (0.5, 4): 0.844415}


def marched_wall(scene, kappa):
    """The finite-S expectation of the march: the GPU's bias, without a ray tracer."""
    columns, rows, row, focal = 160, 72, 66, 400
    name = f"kappa {kappa:g}"
    matrix, yfov, at = wall_camera(kappa, rows, row, focal)
    scene.camera(name, matrix, yfov)
    view = {"camera": name, "resolution": [columns, rows], "pixels": [56, row, 48, 1]}
    rows_view = {**view, "pixels": [56, row - 2, 48, 4]}
    # The nearest pixel errs by half a pixel to either side, which cancels but for about a tenth.
    pixel = 0.1 * 8 / focal
    pixels = "0.1 pixel of the nearest fetch"
    source = "directions u toward the wall are noticed with probability (1 - kappa/u) S"
    for steps in (1, 2, 4):
        k, share = exact.marched_wall(kappa, steps, lambda w: (w[2] / PI, 0.5 / PI))
        agrees(k, PUBLISHED_MARCH[kappa, steps], 5)
        # Four rows hold all 16 sample sets: the same with less noise.
        rows_k = [exact.marched_wall(at(r), steps, lambda w: (w[2] / PI, 0.5 / PI))
                  for r in range(row - 2, row + 2)]
        row_means = [sum(values) / 4 for values in zip(*rows_k)]
        settings = [*MARCHED, f"steps={steps}"]
        bound = 2 / PI * min(steps, 2) * pixel + 2e-4
        name = f"kappa = {kappa:g}, S = {steps}"
        scene.case(name, source, ["ssao"], "ambient_occlusion", agrees(k, k), bound, pixels,
                   settings=settings, view=view)
        scene.case(name, source, ["ssbn"], "uniform_occlusion", share, bound, pixels,
                   settings=settings, view=view)
        for methods, layer, value in ((["ssao"], "ambient_occlusion", row_means[0]),
                                      (["ssbn"], "uniform_occlusion", row_means[1])):
            scene.case(f"{name}, mean of four rows", source, methods, layer, value, bound, pixels,
                       settings=settings, view=rows_view)
        if steps == 2:
            scene.case(name, source, ["s3ho"], "ambient_occlusion", k, bound, pixels,
                       settings=settings, view=view)
            scene.case(f"{name}, white sky", f"E/pi = k; {source}", ["ssdo"], "radiance", [k] * 3,
                       bound, pixels, settings=settings, view=view)
    if kappa != 0.25:
        return
    settings = [*MARCHED, "steps=2"]
    name = "kappa = 0.25, S = 2"
    marched_weights(scene, name, settings, view, bound, pixels)
    scene.case(f"{name}, harmonics", f"c_i = int V cos y_i; {source}", ["s3ho"], "sh_visibility",
               exact.marched_wall(kappa, 2, lambda w: scale(w[2], exact.sh_basis(w))),
               4 * pixel + HALVES, f"{pixels}; {FLOATS}", settings=settings, view=view)
    x, y, z, share = exact.marched_wall(kappa, 2, lambda w: (*w, 1.0))
    scene.case(f"{name}, bent normal", f"N = int V w / int V; {source}", ["ssbn"], "bent_normal",
               [x / share, y / share, z / share], pixel + 1e-3,
               f"{pixels}; the ratio of two sums of 128 samples", settings=settings, view=view)

    def light(w):
        return (w[2] * (1 - 0.5 * w[0] + 0.5 * w[2]), w[2] * (1 + 0.7 * w[1]),
                w[2] * (1 + 0.8 * w[2]))

    E = exact.marched_wall(kappa, 2, light)
    scene.case(f"{name}, linear sky", f"E = int L V cos; {source}", ["s3ho", "ssdo"], "radiance",
               scale(1 / PI, E), 2 * pixel + 5e-4, f"{pixels}; {SKY}", settings=settings, view=view,
               sky=LINEAR)


def smoothstep(low, d):
    t = min(max((d - low) / (1.0 - low), 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


def marched_weights(scene, name, settings, view, bound, pixels):
    """What the blocker that the pixels show lets through, at its own distance."""
    def first(q):
        """The eye before the wall sees the wall or, in front of it, the floor."""
        eye = WALL_EYE
        hits = [t for t in (eye[k] / (eye[k] - q[k]) for k in (0, 2) if q[k] < eye[k])]
        return add(scale(1 - min(hits), eye), scale(min(hits), q))

    weights = {"lambda": ("lambda_per_world=2.5", lambda d: 2.5 * d / (1 + 2.5 * d)),
               "smoothstep": ("fade_start=0.3", lambda d: smoothstep(0.3, d))}
    for weight, (parameter, through) in weights.items():
        uniform, k = exact.march(WALL_EYE, first, (0.25, 0, 0), (0, 0, 1), 1.0, 2, through=through)
        source = "the march against planes instead of pixels, by quadrature"
        more = [*settings, f"weight={weight}", parameter]
        for method, layer, value in (("ssao", "ambient_occlusion", k),
                                     ("ssbn", "uniform_occlusion", uniform)):
            scene.case(f"{name}, {weight}", source, [method], layer, value, bound + 5e-4,
                       f"{pixels}; quadrature", settings=more, view=view)


def traced_wall(scene):
    """The same point with visibility traced: the closed forms themselves."""
    kappa = 0.25
    view = close_up(scene, "at kappa .25", (kappa, 0, 0), (0, 0, 1))
    settings = traced("d_max_world=1")
    source = "k = 1 - (acos kappa - kappa sqrt(1 - kappa^2))/pi, projected disc area"
    k = exact.wall(kappa)
    scene.case("kappa = .25, traced", source, ["ssao", "s3ho"], "ambient_occlusion", k, HALVES,
               FLOATS, settings=settings, view=view)
    scene.case("kappa = .25, traced", "uniform: 1 - (1 - kappa)/2", ["ssbn"], "uniform_occlusion",
               1 - (1 - kappa) / 2, 2e-4, "height strata", settings=settings, view=view)
    scene.case("kappa = .25, traced, white sky", f"E/pi = k; {source}", ["ssdo", "s3ho", "ssao"],
               "radiance", [k] * 3, HALVES, FLOATS, settings=settings, view=view)


def leak(scene):
    """Light from behind the wall alone: half the sky on the floor, none on the wall, whose pixels
    are filtered across the edge. Nothing occludes within so short a reach."""
    scene.camera("edge", camera_at((3, 0, 3), (0, 0, 0)), 0.1)
    behind = {"halves": {"up": [-1, 0, 0], "above": [1, 1, 1], "below": [0, 0, 0]}}
    # The wall's last rows before the edge.
    view = {"camera": "edge", "resolution": [32, 24], "pixels": [8, 8, 16, 4]}
    for power in (5, 32):
        beyond = 0.5 ** power  # the weight of a neighbour at 90 degrees
        shares = [8 * n * beyond / (64 - 8 * n + 8 * n * beyond) for n in range(4)]
        scene.case(f"filter leaks across 90 degrees, power {power}",
                   "0 to 3 of the window's 8 rows are the floor's, at (1/2)^power each", ["ssdo"],
                   "radiance", [0.5 * sum(shares) / 4] * 3, 1e-5, "floats", view=view, sky=behind,
                   settings=["samples=64", "d_max_world=1e-3", "filter_scale=1e6",
                             f"filter_power={power}"])


def corner():
    """The 90 degree corner of floor (n = z) and wall (n = x), d_max = 15 of walls of 20."""
    scene = SceneFile()
    scene.mesh(quad((0, -20, 0), (20, 0, 0), (0, 40, 0)))
    scene.mesh(quad((0, -20, 0), (0, 40, 0), (0, 0, 20)))
    a, d_max = 5e-4, 15.0
    sky = {"linear": {"constant": [1, 1, 1], "x": [-0.5] * 3, "z": [0.5] * 3}}
    strip = 2 * a / d_max * 1.71  # what is beyond d_max, of radiance below 1.71
    E_floor = agrees(PI / 2 - 2 / 3 * 0.5 + PI / 3 * 0.5, 1.761062)
    E_wall = agrees(PI / 2 + 2 / 3 * 0.5 - PI / 3 * 0.5, 1.380531)
    places = {"floor": ((a, 0, 0), (0, 0, 1), E_floor), "wall": ((0, 0, a), (1, 0, 0), E_wall)}
    source = "E_floor = a pi/2 + (2/3) b_x + (pi/3) b_z; E_wall swaps b_x and b_z"
    for name, (p, n, E) in places.items():
        for estimator in ("mis", "cosine", "environment"):
            ray(scene, f"{name}, E = {E:.6f}, {estimator}", source, p, n, [E / PI] * 3,
                (strip + 3e-4) / PI, f"strip beyond d_max; {SKY}", quantity="radiance", sky=sky,
                settings=[f"d_max_world={d_max:g}", f"estimator={estimator}"])
        view = close_up(scene, name, p, n, near=0.05, aside=(0, 1, 0))
        settings = traced(f"d_max_world={d_max:g}")
        scene.case(f"{name}, E = {E:.6f}, traced", source, ["s3ho", "ssdo"], "radiance",
                   [E / PI] * 3, 1e-3 / PI, "1e-3 of E: half floats, strip beyond d_max",
                   settings=settings, view=view, sky=sky)
        for angle, published in (("exact", 1.570796), ("linear", 1.783484)):
            C = math.acos(math.sqrt(2) - 1) if angle == "exact" else (2 - math.sqrt(2)) * PI / 2
            # AO = 1/2, N.n = 1/sqrt 2, b.N = 0, so that L_c = 1 + cos C; times |N|'s cosine.
            E_bent = agrees(PI * 0.5 * (1 + math.cos(C)) * math.sqrt(0.5), published)
            scene.case(f"{name}, {angle} cone, E = {E_bent:.6f}, traced",
                       "E = pi AO L_c N.n, L_c = 1 + cos C: the same on both surfaces", ["ssbn"],
                       "radiance", [E_bent / PI] * 3, 1e-3 / PI, "1e-3 of E", view=view, sky=sky,
                       settings=[*settings, f"cone_angle={angle}"])
    floor_harmonics(scene, d_max)
    scene.write(HERE / "corner.glb")


def floor_harmonics(scene, d_max):
    view = {"camera": "floor", "resolution": CLOSE}
    settings = traced(f"d_max_world={d_max:g}")
    c = exact.hemisphere(
        lambda w: scale(w[2] if w[0] > 0 else 0.0, exact.sh_basis(w)))
    published = {0: 0.443113, 2: 0.511663, 3: -0.325735, 6: 0.247708, 7: -0.429043, 13: -0.304697,
                 15: 0.078672}
    for i, value in enumerate(c):
        agrees(value, published.get(i, 0.0), 5)
    scene.case("floor, harmonics, traced", "c_i = int V cos y_i over a quarter of the sphere",
               ["s3ho"], "sh_visibility", c, HALVES, f"{FLOATS}; quadrature", settings=settings,
               view=view)
    # A white half behind the wall, of which nothing arrives: order 4 lets 8.9% of pi/2 through.
    behind = {"halves": {"up": [-1, 0, 0], "above": [1, 1, 1], "below": [0, 0, 0]}}
    half = [0.0] * 16
    for i, value in enumerate(exact.hemisphere(exact.sh_basis)):
        half[i] = value  # about +Z; zonal
    zonal = [half[band * (band + 1)] for band in range(4)]
    toward = exact.sh_basis((-1.0, 0.0, 0.0))
    light = [math.sqrt(4 * PI / (2 * band + 1)) * zonal[band] * toward[i]
             for band in range(4) for i in range(band * band, (band + 1) ** 2)]
    leaked = agrees(sum(a * b for a, b in zip(light, c)), 0.139565, 5)
    scene.case("floor, light behind the wall, E = 0.139565, traced",
               "c_light . c_visibility: what order 4 leaks", ["s3ho"], "radiance",
               [leaked / PI] * 3, 5e-4, f"{FLOATS}; sky texels", settings=settings, view=view,
               sky=behind)
    scene.case("floor, light behind the wall, traced", "E = 0: the wall hides it", ["ssdo"],
               "radiance", [0, 0, 0], 1e-4, "strip beyond d_max", settings=settings, view=view,
               sky=behind)
    ray(scene, "floor, light behind the wall", "E = 0: the wall hides it", (5e-4, 0, 0), (0, 0, 1),
        [0, 0, 0], 1e-4, "strip beyond d_max", quantity="radiance", sky=behind,
        settings=[f"d_max_world={d_max:g}"])


def three_planes():
    """A corner of three planes, d_max = 1."""
    scene = SceneFile()
    scene.mesh(quad((0, 0, 0), (2, 0, 0), (0, 2, 0))).mesh(quad((0, 0, 0), (0, 2, 0), (0, 0, 2)))
    scene.mesh(quad((0, 0, 0), (0, 0, 2), (2, 0, 0)))
    kappa = 1e-3
    strips = math.asin(kappa) + kappa * math.sqrt(1 - kappa * kappa) + kappa * kappa
    ray(scene, "corner of three planes", "k = 1/4, and the strips beyond d_max", (kappa, kappa, 0),
        (0, 0, 1), 0.25 + strips / PI, 1e-6, "floats", settings=["d_max_world=1"])
    view = close_up(scene, "close", (kappa, kappa, 0), (0, 0, 1), near=0.05,
                    aside=(math.sqrt(0.5), math.sqrt(0.5), 0))
    scene.case("corner of three planes, traced", "k = 1/4, and the strips beyond d_max",
               ["ssao", "s3ho"], "ambient_occlusion", 0.25 + strips / PI, HALVES, FLOATS,
               settings=traced("d_max_world=1"), view=view)
    scene.case("corner of three planes, traced", "uniform: 1/4, and the strips beyond d_max",
               ["ssbn"], "uniform_occlusion", 0.25 + 2 * kappa / 4, 3e-4, "height strata, kappa^2",
               settings=traced("d_max_world=1"), view=view)
    p, eye = (0.25, 0.25, 0.0), (5.0, 5.0, 5.0)
    scene.camera("diagonal", camera_at(eye, p), 2 * math.atan(40 / 250))

    def first(q):
        hits = [t for t in (eye[k] / (eye[k] - q[k]) for k in range(3) if q[k] < eye[k])]
        return add(scale(1 - min(hits), eye), scale(min(hits), q))

    for steps in (1, 2):
        uniform, k = exact.march(eye, first, p, (0, 0, 1), 1.0, steps)
        source = "the march against planes instead of pixels, by quadrature"
        why = "0.1 pixel of the nearest fetch; quadrature; 4x4 pixels about the point"
        view = {"camera": "diagonal", "resolution": [80, 80], "pixels": [38, 38, 4, 4]}
        settings = ["samples=256", "filter=none", "bias_world=1e-4", "epsilon_world=1e-4",
                    f"steps={steps}"]
        name = f"kappa = .25 twice, S = {steps}"
        scene.case(name, source, ["ssao"], "ambient_occlusion", k, 4e-3, why, settings=settings,
                   view=view)
        scene.case(name, source, ["ssbn"], "uniform_occlusion", uniform, 4e-3, why,
                   settings=settings, view=view)
    scene.write(HERE / "three_planes.glb")


def walls_of_finite_height():
    scene = SceneFile()
    width = 20.0
    scene.mesh(quad((0, -width, 0), (0, 2 * width, 0), (0, 0, 1)))
    scene.mesh(quad((0, -2, 0), (4, 0, 0), (0, 4, 0)))
    for a in (0.5, 1.0, 2.0):
        blocked = exact.rectangle_occlusion(a, width, 1.0)
        if a == 1.0:
            agrees(0.5 * (1 + a / math.hypot(a, 1.0)), 0.853553)
        bound = abs(blocked - exact.rectangle_occlusion(a, width, 1.0 - scene.lift())) + 1e-6
        ray(scene, f"height 1, a = {a:g}",
            "k = 1 - form factor of a rectangle [Howell C-11]; (1 + a/sqrt(a^2 + h^2))/2 if wide",
            (a, 0, 0), (0, 0, 1), 1 - blocked, bound, "lift of the rays' origin",
            settings=["d_max_world=inf"])
        view = close_up(scene, f"a = {a:g}", (a, 0, 0), (0, 0, 1))
        scene.case(f"height 1, a = {a:g}, traced",
                   "k = 1 - form factor of a rectangle [Howell C-11]", ["ssao", "s3ho"],
                   "ambient_occlusion", 1 - blocked, bound + HALVES,
                   f"lift of the rays' origin; {FLOATS}", settings=traced("d_max_world=1e6"),
                   view=view)
    scene.write(HERE / "low_wall.glb")

    scene = SceneFile()
    scene.mesh(quad((0, -1000, 0), (0, 2000, 0), (0, 0, 1000)))
    scene.mesh(quad((0, -1, 0), (2, 0, 0), (0, 2, 0)))
    view = close_up(scene, "close", (1, 0, 0), (0, 0, 1))
    for K, published in ((0.3, 0.740403), (1.0, 0.863380), (3.0, 0.940624)):
        k = agrees(exact.lambda_wall(K), published)
        source = "k = 1/2 + (2K/pi)(K pi/2 - 1 + (1 - K^2) J), K = lambda a"
        ray(scene, f"lambda, K = {K:g}", source, (1, 0, 0), (0, 0, 1), k, 2e-5,
            "what is missing of the wall", settings=["d_max_world=inf", "weight=lambda",
                                                     f"lambda_per_world={K:g}"])
        scene.case(f"lambda, K = {K:g}, traced", source, ["ssao", "s3ho"], "ambient_occlusion", k,
                   HALVES, FLOATS, view=view,
                   settings=traced("d_max_world=1e6", "weight=lambda", f"lambda_per_world={K:g}"))
    scene.write(HERE / "lambda_wall.glb")
