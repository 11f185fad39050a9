"""Closed forms of occlusion, and expectations of the screen-space march, by quadrature where there
is none. Cosine-weighted occlusion is the area of the blockers' projection onto the tangent plane's
unit disc, over pi. Standard library only."""

import math

from scene_file import add, dot, scale

PI = math.pi


def agrees(value, published, digits=6):
    """A literal number of the literature, so that a slip in a formula shows."""
    if not abs(value - published) <= 0.51 * 10.0 ** -digits:
        raise AssertionError(f"{value} is not {published}")
    return value


def integrate(low, high, f, steps=20000):
    """Midpoint rule."""
    h = (high - low) / steps
    return h * sum(f(low + (i + 0.5) * h) for i in range(steps))


def wall(kappa):
    """k beside an infinite perpendicular wall at distance kappa d_max."""
    return 1.0 - (math.acos(kappa) - kappa * math.sqrt(1.0 - kappa * kappa)) / PI


def weighted_wall(a, kappa, v):
    """k beside an infinite wall at distance a whose points at distance d let v(d) through. A
    direction's component u toward the wall has the density (2/pi) sqrt(1 - u^2)."""
    # u = sin t: smooth at both ends.
    first = math.asin(kappa)
    return 1.0 - 2.0 / PI * integrate(first, PI / 2, lambda t: math.cos(t) ** 2 * (
        1.0 - v(a / math.sin(t))))


def lambda_wall(K):
    """k beside an infinite wall at distance a, K = lambda a, d_max = infinity."""
    if K < 1.0:
        J = math.acosh(1.0 / K) / math.sqrt(1.0 - K * K)
    elif K > 1.0:
        J = math.acos(1.0 / K) / math.sqrt(K * K - 1.0)
    else:
        J = 1.0
    return 0.5 + 2.0 * K / PI * (K * PI / 2.0 - 1.0 + (1.0 - K * K) * J)


def detection(kappa, u, steps):
    """With what probability jittered steps notice a solid wall [S = steps]."""
    return 0.0 if u <= kappa else min(1.0, (1.0 - kappa / u) * steps)


def hemisphere(f, heights=400, azimuths=800):
    """The integral over the hemisphere about +Z of a tuple f(w): midpoint rule."""
    total = None
    for i in range(heights):
        t = 1.0 - (i + 0.5) / heights
        z = 1.0 - t * t  # so that r is smooth at the pole
        r = math.sqrt(1.0 - z * z)
        weight = 2.0 * t * 2.0 * PI / (heights * azimuths)
        for j in range(azimuths):
            phi = 2.0 * PI * (j + 0.5) / azimuths
            values = scale(weight, f((r * math.cos(phi), r * math.sin(phi), z)))
            total = values if total is None else add(total, values)
    return list(total)


def marched_wall(kappa, steps, f):
    """The integral of f(w) over what S steps leave visible beside a wall at -X."""
    return hemisphere(lambda w: scale(1.0 - detection(kappa, -w[0], steps), f(w)))


def rectangle_occlusion(a, half_width, height):
    """What a rectangle that stands on the tangent plane hides: its form factor [Howell C-11]."""
    slant = math.hypot(a, height)
    w = half_width
    return (math.atan(w / a) - a / slant * math.atan(w / slant)) / PI


def sh_basis(d):
    """Real spherical harmonics, order 4, index l(l+1)+m [Sloan 2008, appendix A2]."""
    x, y, z = d
    s = math.sqrt(PI)
    return (0.5 / s,
            -math.sqrt(3) * y / (2 * s), math.sqrt(3) * z / (2 * s), -math.sqrt(3) * x / (2 * s),
            math.sqrt(15) * x * y / (2 * s), -math.sqrt(15) * y * z / (2 * s),
            math.sqrt(5) * (3 * z * z - 1) / (4 * s), -math.sqrt(15) * x * z / (2 * s),
            math.sqrt(15) * (x * x - y * y) / (4 * s),
            -math.sqrt(70) * y * (3 * x * x - y * y) / (8 * s),
            math.sqrt(105) * x * y * z / (2 * s),
            -math.sqrt(42) * y * (5 * z * z - 1) / (8 * s),
            math.sqrt(7) * z * (5 * z * z - 3) / (4 * s),
            -math.sqrt(42) * x * (5 * z * z - 1) / (8 * s),
            math.sqrt(105) * z * (x * x - y * y) / (4 * s),
            -math.sqrt(70) * x * (x * x - 3 * y * y) / (8 * s))


def at_zonal(z):
    """16 coefficients of a function that is symmetric about +Z."""
    c = [0.0] * 16
    c[0], c[2], c[6], c[12] = z
    return c


def march(eye, first_surface, p, n, d_max, steps, bias=1e-4, epsilon=1e-4, heights=96, azimuths=96,
          offsets=24, through=lambda d: 0.0):
    """What the screen-space march finds at p with normal n through pixels of no size: the mean
    over the hemisphere of (V, 2 V cos). A blocker at distance d lets through(d) through.

    first_surface(q): the point that `eye` sees in the direction of q; None where that is nothing.
    A surface blocks where it is nearer than the sample, above the tangent plane and within d_max
    of p [Herholz et al. 2012, sec. 2.1]. One azimuth is enough where all is symmetric about n.
    """
    tangent = (1.0, 0.0, 0.0) if abs(n[0]) < 0.5 else (0.0, 1.0, 0.0)
    x = add(tangent, scale(-dot(tangent, n), n))
    x = scale(1.0 / math.sqrt(dot(x, x)), x)
    y = (n[1] * x[2] - n[2] * x[1], n[2] * x[0] - n[0] * x[2], n[0] * x[1] - n[1] * x[0])
    uniform = cosine = 0.0
    for i in range(heights):
        h = (i + 0.5) / heights
        r = math.sqrt(1.0 - h * h)
        for j in range(azimuths):
            phi = 2.0 * PI * (j + 0.5) / azimuths
            s = add(scale(r * math.cos(phi), x), scale(r * math.sin(phi), y), scale(h, n))
            visible = 0.0
            for o in range(offsets):
                xi = (o + 0.5) / offsets
                for k in range(steps):
                    q = add(p, scale(d_max * (k + xi) / steps, s))
                    seen = first_surface(q)
                    if seen is None or math.dist(seen, eye) >= math.dist(q, eye) - bias:
                        continue
                    to = add(seen, scale(-1.0, p))
                    if dot(to, n) > epsilon and dot(to, to) <= d_max * d_max:
                        visible += through(math.sqrt(dot(to, to)))
                        break
                else:
                    visible += 1.0
            uniform += visible / offsets
            cosine += 2.0 * h * visible / offsets
    count = heights * azimuths
    return uniform / count, cosine / count
