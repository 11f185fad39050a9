"""Cases of one bounce of light. All surfaces have albedo 1 and L = 1, so that a sender that nothing
blocks sends 1."""

import math

import closed_forms as exact
from closed_forms import PI, agrees
from scene_file import add, dot, scale
from traced import FLOATS, HALVES, MARCHED, close_up, point, traced


def traced_point(scene, name, source, position, normal, method, quantity, expected, bound, why,
                 settings):
    scene.case(name, source, [method], quantity, [expected] * 3, bound, why,
               point=point(position, normal), seeds=64,
               settings=["rays_per_pixel=2048", *settings])


def furnace(scene):
    """What is blocked sends as much as the sky would: E = pi whatever blocks, sample by sample."""
    view = {"camera": "main", "resolution": [48, 32]}
    open_sky = {"method": "ssao", "quantity": "ambient_occlusion",
                "set": ["d_max_world=1e-6", "filter=none"]}
    for visibility in ("depth", "traced"):
        for weight in ("binary", "lambda", "smoothstep"):
            scene.case(f"furnace with a bounce, {weight}, {visibility}",
                       "E = pi for L = 1, rho = 1: V + (1 - V) = 1 and sum cos = N/2", ["s3hogi"],
                       "radiance", None, 2e-3, FLOATS, view=view, equals=open_sky,
                       settings=["form_factor=solid_angle", "filter=none", f"weight={weight}",
                                 f"visibility={visibility}"])
    for estimator in ("mis", "cosine", "environment"):
        scene.case(f"furnace with a bounce, {estimator}", "E = pi for L = 1, rho = 1",
                   ["rtgi_unoccluded"], "radiance", [1, 1, 1], 1e-5, "floats", view=view, seeds=8,
                   settings=["rays_per_pixel=256", "d_max_world=1", f"estimator={estimator}"])


# Of form factor (i), not clamped, and the truth, at a wall.
PUBLISHED_RATIOS = {0.1: (9.7, 1), 0.25: (1.97, 2), 0.5: (0.78, 2), 0.8: (0.54, 2)}


def patch_wall(kappa):
    """E/pi of form factor (i) beside an infinite wall at distance kappa d_max whose points send 1:
    r^2/(2 pi) int u (n.w) (u/a)^2 dw over directions with component u > kappa toward it."""
    t = 1 - kappa * kappa
    return (2 / 3 * t ** 1.5 - 2 / 5 * t ** 2.5) / (2 * kappa * kappa * PI)


def clamped_wall(a, least):
    """The same with distances of at least `least`, a = kappa, d_max = 1."""
    first = math.asin(a)  # u = sin t: smooth at both ends
    return 1 / PI * exact.integrate(first, PI / 2, lambda t: math.sin(t) * math.cos(t) ** 2 / max(
        a / math.sin(t), least) ** 2)


def wall(scene, wall_eye):
    """A floor point beside the wall x = 0, d_max = 1: the wall alone sends."""
    for kappa, (ratio, digits) in PUBLISHED_RATIOS.items():
        truth = 1 - exact.wall(kappa)
        patch = patch_wall(kappa)
        agrees(patch / truth, ratio, digits)
        p, n = (kappa, 0, 0), (0, 0, 1)
        traced_point(scene, f"bounce, kappa = {kappa:g}", "E/pi = 1 - k, unoccluded senders of 1",
                     p, n, "rtgi_unoccluded", "radiance_indirect", truth, 1e-5, "floats",
                     ["d_max_world=1"])
        view = close_up(scene, f"bounce {kappa:g}", p, n, near=0.05)
        common = {"view": view, "seeds": 16}
        scene.case(f"bounce, kappa = {kappa:g}, solid angle, traced", "E/pi = 1 - k", ["s3hogi"],
                   "radiance_indirect", [truth] * 3, HALVES, FLOATS,
                   settings=traced("d_max_world=1", "form_factor=solid_angle"), **common)
        scene.case(f"bounce, kappa = {kappa:g}, patch, traced",
                   f"{ratio:g} times the truth: pi r_max^2/N cos cos/d^2 [Ritschel et al. 2009]",
                   ["s3hogi"], "radiance_indirect", [patch] * 3, 1e-3 * patch + HALVES,
                   f"{FLOATS}; height strata",
                   settings=traced("d_max_world=1", "form_factor=patch", "distance_clamp=none"),
                   **common)
    agrees(clamped_wall(0.25, 0.0), patch_wall(0.25))
    view = close_up(scene, "bounce 0.05", (0.05, 0, 0), (0, 0, 1), near=0.02)
    for clamp, least in (("patch_radius", 1 / 16), ("unit", 1.0)):
        expected = clamped_wall(0.05, least)
        scene.case(f"bounce, kappa = 0.05, patch, clamp {clamp}, traced",
                   "pi r_max^2/N cos cos/max(d, clamp)^2, N = 256 [Ritschel et al. 2009]",
                   ["s3hogi"], "radiance_indirect", [expected] * 3, 1e-3 * expected + HALVES,
                   f"{FLOATS}; height strata", view=view, seeds=16,
                   settings=traced("d_max_world=1", "form_factor=patch",
                                   f"distance_clamp={clamp}"))
    marched_patch(scene, wall_eye)


def marched_patch(scene, eye):
    """The march meets points behind the wall, and the eye sees the wall before them."""
    def first(q):
        hits = [t for t in (eye[k] / (eye[k] - q[k]) for k in (0, 2) if q[k] < eye[k])]
        return add(scale(1 - min(hits), eye), scale(min(hits), q))

    for kappa in (0.25, 0.5):
        p = (kappa, 0.0, 0.0)
        view = {"camera": f"kappa {kappa:g}", "resolution": [160, 72], "pixels": [56, 66, 48, 1]}
        for clamp, least in (("none", 0.0), ("unit", 1.0)):
            def sent(surface):
                to = add(surface, scale(-1, p))
                d = math.sqrt(dot(to, to))
                return to[2] / d * -to[0] / d / max(d, least) ** 2

            expected = marched_mean(eye, first, p, sent)
            scene.case(f"bounce, kappa = {kappa:g}, S = 2, patch, clamp {clamp}",
                       "the march against planes instead of pixels, by quadrature", ["s3hogi"],
                       "radiance_indirect", [expected] * 3, 0.012 * expected + HALVES,
                       f"{FLOATS}; pixels of 0.02 in distances of 0.25 and more; quadrature",
                       settings=[*MARCHED, "steps=2", "form_factor=patch",
                                 f"distance_clamp={clamp}"], view=view)


def marched_mean(eye, first, p, sent, heights=64, azimuths=96, offsets=24, bias=1e-4):
    """The mean over the hemisphere of sent(p'), p' being what decides the march of two steps over
    d_max = 1; 0 where nothing blocks."""
    total = 0.0
    for i in range(heights):
        h = (i + 0.5) / heights
        r = math.sqrt(1.0 - h * h)
        for j in range(azimuths):
            phi = 2.0 * PI * (j + 0.5) / azimuths
            s = (r * math.cos(phi), r * math.sin(phi), h)
            for o in range(offsets):
                for k in range(2):
                    q = add(p, scale((k + (o + 0.5) / offsets) / 2, s))
                    seen = first(q)
                    if math.dist(seen, eye) >= math.dist(q, eye) - bias:
                        continue
                    to = add(seen, scale(-1.0, p))
                    if to[2] > bias and dot(to, to) <= 1.0:
                        total += sent(seen)
                        break
    return total / (heights * azimuths * offsets)


def bowl(scene, psi, k, theta, place, normal, bound, why):
    """Every point of a bowl sees k of the sky and 1 - k of the bowl."""
    for method, expected, source in (
            ("rtgi_shaded", k + (1 - k) * k, "E/pi = k + (1 - k) rho k, rho = 1"),
            ("rtgi_unoccluded", 1.0, "E/pi = k + (1 - k) rho, rho = 1")):
        traced_point(scene, f"bounce, psi = {psi:g}, theta = {theta:g}", source, place, normal,
                     method, "radiance", expected, 2 * bound, why, ["d_max_world=inf"])
