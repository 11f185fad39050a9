"""The scenes of curved surfaces. Their facets lie on both sides of the surface they stand for;
how far is part of each bound."""

import math
import pathlib

import bounce
import closed_forms as exact
from closed_forms import PI, agrees
from scene_file import (SceneFile, add, camera_at, dot, facet_share, quad, revolution, scale,
                        sphere_part)
from traced import FLOATS, HALVES, MARCHED, close_up, ray, traced

HERE = pathlib.Path(__file__).resolve().parent
# Facets are within this share of the radius from the sphere.
FACETS = (1.0 - facet_share()) / (1.0 + facet_share())
TESSELLATION = "facets and the lift of the rays' origin"


def sphere_on_a_plane():
    """A sphere of radius 1 that touches the plane z = 0 at the origin."""
    scene = SceneFile()
    scene.mesh(sphere_part((0, 0, 1), 1.0)).mesh(quad((-4, -4, 0), (8, 0, 0), (0, 8, 0)))
    lift = scene.lift()
    for r, published in ((0.5, 0.284458), (1.0, 0.646447), (2.0, 0.910557)):
        blocked = (1 + r * r) ** -1.5
        agrees(1 - blocked, published)
        lower = (1 - lift) * (r * r + (1 - lift) ** 2) ** -1.5
        bound = abs(lower - blocked) + 2 * FACETS * blocked
        source = "k = 1 - (1 + r^2/R^2)^(-3/2): cos(theta) R^2/d^2"
        ray(scene, f"r/R = {r:g}", source, (r, 0, 0), (0, 0, 1), 1 - blocked, bound, TESSELLATION,
            settings=["d_max_world=inf"])
        bent_light(scene, r, bound)
        view = close_up(scene, f"r = {r:g}", (r, 0, 0), (0, 0, 1), near=0.02)
        settings = traced("d_max_world=1e6")
        scene.case(f"r/R = {r:g}, traced", source, ["ssao", "s3ho"], "ambient_occlusion",
                   1 - blocked, bound + HALVES, f"{TESSELLATION}; {FLOATS}", settings=settings,
                   view=view)
        d = math.hypot(r, 1.0)
        uniform = r / d  # 1 - (1 - cos s)
        scene.case(f"r/R = {r:g}, traced", "uniform: cos s, sin s = R/d", ["ssbn"],
                   "uniform_occlusion", uniform, 2 * bound + HALVES, TESSELLATION,
                   settings=settings, view=view)
        toward = (-r / d, 0.0, 1.0 / d)
        bent = scale(0.5 / uniform, add((0, 0, 1), scale(-1.0 / (d * d), toward)))
        scene.case(f"r/R = {r:g}, bent normal, traced", "N = (n - sin^2 s u)/(2 cos s)", ["ssbn"],
                   "bent_normal", bent, 4 * bound + 1e-3,
                   f"{TESSELLATION}; the ratio of two sums of 256 samples", settings=settings,
                   view=view)
    marched_sphere(scene)
    scene.write(HERE / "sphere_on_a_plane.glb")


def bent_light(scene, r, bound):
    """The bent vector B = int V w cos, of three skies 1 + w.x, 1 + w.y, 1 + w.z:
    E/pi = k + B/pi. B = (2 pi/3) n - A n - B' (u.n) u, u toward the centre, sin s = R/d,
    A + B' = 2 pi (1 - cos^3 s)/3, 3 A + B' = 2 pi (1 - cos s)."""
    d = math.hypot(r, 1.0)
    u, cos_s = (-r / d, 0.0, 1.0 / d), r / d
    both, three = 2 * PI * (1 - cos_s ** 3) / 3, 2 * PI * (1 - cos_s)
    A = 0.5 * (three - both)
    B = add((0, 0, 2 * PI / 3 - A), scale(-(both - A) * u[2], u))
    if r == 1.0:
        norm = math.sqrt(dot(B, B))
        for value, published in zip(B, (0.3939, 0.0, 0.9191)):  # the sphere is at -x here
            agrees(value / norm, published, 4)
    k = 1 - (1 + r * r) ** -1.5
    sky = {"linear": {"constant": [1, 1, 1], "x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, 1]}}
    ray(scene, f"r/R = {r:g}, bent vector", "E/pi = k + B/pi, B = (2 pi/3) n - A n - B' (u.n) u",
        (r, 0, 0), (0, 0, 1), [k + b / PI for b in B], 2 * bound + 3e-4,
        f"{TESSELLATION}; texels of a linear sky", quantity="radiance", sky=sky,
        settings=["d_max_world=inf"])


def marched_sphere(scene):
    """Beside the sphere, seen from the side where the point is in front of it."""
    p, eye = (1.0, 0.0, 0.0), (6.0, 0.0, 5.0)
    scene.camera("side", camera_at(eye, p), 2 * math.atan(40 / 235))

    def first(q):
        """The plane or the sphere, whichever the eye meets first."""
        along = add(q, scale(-1, eye))
        ts = [eye[2] / (eye[2] - q[2])] if q[2] < eye[2] else []
        to = add(eye, (0, 0, -1))
        a, b, c = dot(along, along), dot(along, to), dot(to, to) - 1.0
        if b * b > a * c:
            ts.append((-b - math.sqrt(b * b - a * c)) / a)
        return add(eye, scale(min(ts), along)) if ts else None

    for steps in (1, 2):
        uniform, k = exact.march(eye, first, p, (0, 0, 1), 1.0, steps)
        view = {"camera": "side", "resolution": [80, 80], "pixels": [38, 38, 4, 4]}
        settings = ["samples=256", "filter=none", "bias_world=1e-4", "epsilon_world=1e-4",
                    f"steps={steps}"]
        why = "facets; 0.1 pixel of the nearest fetch; quadrature; 4x4 pixels about the point"
        source = "the march against a sphere instead of pixels, by quadrature"
        for method, layer, value in (("ssao", "ambient_occlusion", k),
                                     ("ssbn", "uniform_occlusion", uniform)):
            scene.case(f"r/R = 1, S = {steps}", source, [method], layer, value, 4e-3, why,
                       settings=settings, view=view)


def bowls():
    """A bowl with centre at the origin, opening upward, psi seen from the centre."""
    for name, degrees, published in (("bowl", 90.0, 0.5), ("deep_bowl", 60.0, 0.25)):
        psi = math.radians(degrees)
        scene = SceneFile().mesh(sphere_part((0, 0, 0), 1.0, psi, PI, inward=True))
        k = agrees(0.5 * (1 - math.cos(psi)), published)
        source = "k = (1 - cos psi)/2 everywhere: the opening's disc seen from the sphere"
        # A point raised by e sees the opening larger by less than 4 e in k.
        bound = 4 * (FACETS + scene.lift())
        for theta in (180.0, 160.0, 130.0):
            t = math.radians(theta)
            out = (math.sin(t), 0.0, math.cos(t))
            ray(scene, f"psi = {degrees:g}, theta = {theta:g}", source, scale(1 - FACETS, out),
                scale(-1, out), k, bound, TESSELLATION, settings=["d_max_world=inf"])
            bounce.bowl(scene, degrees, k, theta, scale(1 - FACETS, out), scale(-1, out), bound,
                        TESSELLATION)
            view = close_up(scene, f"theta {theta:g}", out, scale(-1, out), near=0.2)
            scene.case(f"psi = {degrees:g}, theta = {theta:g}, traced", source, ["ssao", "s3ho"],
                       "ambient_occlusion", k, bound + HALVES, f"{TESSELLATION}; {FLOATS}",
                       settings=traced("d_max_world=1e6"), view=view)
        if degrees == 90.0:
            marched_bowl(scene)
        scene.write(HERE / f"{name}.glb")


def marched_bowl(scene):
    """The bottom, seen from above through the opening."""
    eye, p, d_max = (0.0, 0.0, 6.0), (0.0, 0.0, -1.0), 0.8
    scene.camera("above", camera_at(eye, p, up=(0, 1, 0)), 2 * math.atan(1.15 / 6))

    def first(q):
        along = add(q, scale(-1, eye))
        a, b, c = dot(along, along), dot(along, eye), dot(eye, eye) - 1.0
        if b * b <= a * c:
            return None
        far = add(eye, scale((-b + math.sqrt(b * b - a * c)) / a, along))
        return far if far[2] <= 0.0 else None

    for steps in (1, 2):
        uniform, k = exact.march(eye, first, p, (0, 0, 1), d_max, steps, heights=2000, azimuths=1,
                                 offsets=200)
        view = {"camera": "above", "resolution": [96, 96], "pixels": [46, 46, 4, 4]}
        settings = ["samples=256", "filter=none", "bias_world=1e-4", "epsilon_world=1e-4",
                    f"steps={steps}", f"d_max_world={d_max:g}"]
        why = "facets; 0.1 pixel of the nearest fetch; 4x4 pixels about the point"
        source = "the march against a bowl instead of pixels, by quadrature"
        for method, layer, value in (("ssao", "ambient_occlusion", k),
                                     ("ssbn", "uniform_occlusion", uniform)):
            scene.case(f"bottom, S = {steps}", source, [method], layer, value, 4e-3, why,
                       settings=settings, view=view)


def closed_sphere():
    scene = SceneFile().mesh(sphere_part((0, 0, 0), 1.0, inward=True))
    start = 1 - FACETS - scene.lift()
    places = {"bottom": (0.0, 0.0, -1.0), "side": (1.0, 0.0, 0.0)}

    def blocked_below(d_max, radius, origin):
        """Directions whose cosine to the inward normal is below this meet the sphere in time."""
        return (d_max ** 2 + origin ** 2 - radius ** 2) / (2 * d_max * origin)

    for place, out in places.items():
        view = close_up(scene, place, out, scale(-1, out), near=0.2)
        p, n = scale(1 - FACETS, out), scale(-1, out)
        for q in (0.25, 0.5, 0.8):
            k = 1 - q * q
            found = [1 - blocked_below(2 * q, radius, start) ** 2
                     for radius in (1 - FACETS, 1 + FACETS)]
            bound = max(abs(value - k) for value in found) + 1e-6
            ray(scene, f"{place}, q = {q:g}", "k = 1 - q^2, q = d_max/2R", p, n, k, bound,
                TESSELLATION, settings=[f"d_max_world={2 * q:g}"])
            scene.case(f"{place}, q = {q:g}, traced", "k = 1 - q^2, q = d_max/2R", ["ssao", "s3ho"],
                       "ambient_occlusion", k, bound + HALVES + strata(lambda z, q=q: z > q, k),
                       f"{TESSELLATION}; {FLOATS}; height strata",
                       settings=traced(f"d_max_world={2 * q:g}"), view=view)
        ray(scene, f"{place}, d_max = inf", "k = 0: nothing escapes", p, n, 0.0,
            settings=["d_max_world=inf"])
        K = 2.0
        k = agrees(1 - 2 / K + 2 * math.log(1 + K) / K ** 2, 0.549306)
        ray(scene, f"{place}, lambda, K = 2", "k = 1 - 2/K + 2 ln(1 + K)/K^2, K = 2 R lambda", p, n,
            k, 2 * (FACETS + scene.lift()), TESSELLATION,
            settings=["d_max_world=inf", "weight=lambda", "lambda_per_world=1"])
        scene.case(f"{place}, lambda, K = 2, traced",
                   "k = 1 - 2/K + 2 ln(1 + K)/K^2, K = 2 R lambda", ["ssao", "s3ho"],
                   "ambient_occlusion", k, 4 * (FACETS + scene.lift()) + HALVES,
                   f"{TESSELLATION}; {FLOATS}", view=view,
                   settings=traced("d_max_world=1e6", "weight=lambda", "lambda_per_world=1"))
    scene.write(HERE / "closed_sphere.glb")


def strata(visible, k, N=256):
    """How far N stratified heights are from k, where only the height decides what is visible."""
    heights = [(i + 0.5) / N for i in range(N)]
    return abs(2 / N * sum(z for z in heights if visible(z)) - k)


def well():
    """A cylinder of radius 1/2 and height 1, at the centre of its floor: tan alpha = R/h."""
    segments, h = 256, 1.0
    # The polygon's area is the disc's.
    radius = 0.5 * math.sqrt(2 * PI / segments / math.sin(2 * PI / segments))
    scene = SceneFile()
    scene.mesh(revolution(lambda t: (radius, h * t), 1, segments, lambda *_: (-1.0, 0.0)))
    scene.mesh(revolution(lambda t: (radius * t, 0.0), 1, segments, lambda *_: (0.0, 1.0)))
    c = h / math.hypot(0.5, h)
    k = agrees(1 - c * c, 0.2)
    seen = h - scene.lift()
    bound = abs(0.25 / (0.25 + seen * seen) - k) + k * (2 * PI / segments) ** 2
    source = "k = sin^2 alpha, tan alpha = R/h"
    ray(scene, "centre of the floor", source, (0, 0, 0), (0, 0, 1), k, bound, TESSELLATION,
        settings=["d_max_world=inf"])
    view = close_up(scene, "close", (0, 0, 0), (0, 0, 1), near=0.1)
    settings = traced("d_max_world=1e6")
    rings = strata(lambda z: z > c, k)
    bound += rings
    why = f"{TESSELLATION}; {FLOATS}; height strata"
    scene.case("centre of the floor, traced", source, ["ssao", "s3ho"], "ambient_occlusion", k,
               bound + HALVES, why, settings=settings, view=view)
    scene.case("centre of the floor, white sky, traced", f"E/pi = k; {source}", ["ssdo", "ssao"],
               "radiance", [k] * 3, bound + 1e-3, why, settings=settings, view=view)
    scene.case("centre of the floor, exact cone, white sky, traced",
               "E/pi = AO (1 + cos alpha) = sin^2 alpha [Klehm et al. 2011, their t]", ["ssbn"],
               "radiance", [k] * 3, bound + 2e-3, f"{why}; cone levels", view=view,
               settings=[*settings, "cone_angle=exact"])
    scene.case("centre of the floor, traced", "uniform: 1 - cos alpha", ["ssbn"],
               "uniform_occlusion", 1 - c, bound, why, settings=settings, view=view)
    scene.case("centre of the floor, bent normal, traced", "|N| = (1 + cos alpha)/2", ["ssbn"],
               "bent_normal", [0, 0, 0.5 * (1 + c)], bound + 1e-3, why, settings=settings,
               view=view)
    zonal = [math.sqrt(PI) / 2 * (1 - c * c), math.sqrt(3 * PI) / 3 * (1 - c ** 3),
             math.sqrt(5 * PI) / 8 * (1 - c * c) * (1 + 3 * c * c),
             math.sqrt(7 * PI) / 2 * c ** 3 * (1 - c * c)]
    scene.case("centre of the floor, harmonics, traced", "zonal c_l = int_c^1 2 pi z y_l(z) dz",
               ["s3ho"], "sh_visibility", exact.at_zonal(zonal), 3 * bound + 1e-3, why,
               settings=settings, view=view)
    marched_well(scene, h)
    scene.write(HERE / "well.glb")


def marched_well(scene, h):
    """The centre of the floor, seen from above along the axis."""
    eye, d_max = (0.0, 0.0, 3.0), 1.0
    scene.camera("above", camera_at(eye, (0, 0, 0), up=(0, 1, 0)), 2 * math.atan(0.6 / 2.0))

    def first(q):
        """The wall where the ray is beyond R before the floor, nothing where it passes the rim."""
        out = math.hypot(q[0], q[1])
        at_wall = eye[2] - (eye[2] - q[2]) * 0.5 / out if out > 0.0 else -1.0
        if at_wall > h:
            return None
        t = (eye[2] - max(at_wall, 0.0)) / (eye[2] - q[2])
        return add(scale(1 - t, eye), scale(t, q))

    for steps in (1, 2):
        uniform, k = exact.march(eye, first, (0, 0, 0), (0, 0, 1), d_max, steps, heights=2000,
                                 azimuths=1, offsets=200)
        view = {"camera": "above", "resolution": [160, 160], "pixels": [78, 78, 4, 4]}
        settings = [*MARCHED, f"steps={steps}", f"d_max_world={d_max:g}"]
        why = "facets; 0.1 pixel of the nearest fetch, of the wall's slant; 4x4 pixels"
        source = "the march against a cylinder instead of pixels, by quadrature"
        for method, layer, value in (("ssao", "ambient_occlusion", k),
                                     ("ssbn", "uniform_occlusion", uniform)):
            scene.case(f"centre of the floor, S = {steps}", source, [method], layer, value, 8e-3,
                       why, settings=settings, view=view)
