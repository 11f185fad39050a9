"""How the cases of this folder are measured: rays at a point, passes with traced or marched
visibility."""

from scene_file import add, camera_at, cross, scale, unit

PASSES = ["ssao", "s3ho", "ssdo", "ssbn"]
RAYS = 4096
CLOSE = [4, 4]  # pixels: each of the 16 sample sets once
HALVES = 5e-4
FLOATS = "half floats"
SKY = "texels of a linear sky"
LINEAR = {"linear": {"constant": [1, 1, 1], "x": [-0.5, 0, 0], "y": [0, 0.7, 0],
                     "z": [0.5, 0, 0.8]}}
MARCHED = ["samples=128", "filter=none", "bias_world=1e-4", "epsilon_world=1e-4"]


def traced(*settings):
    return ["samples=256", "filter=none", "visibility=traced", *settings]


def point(position, normal, **more):
    return {"position": list(position), "normal": list(normal), **more}


def ray(scene, name, source, position, normal, expected, bound=0.0, why="", settings=(),
        quantity="ambient_occlusion", sky=None, geometric_normal=None):
    """A case of the ray tracer at one point."""
    estimator = [] if any(s.startswith("estimator=") for s in settings) else (
        ["estimator=cosine"] if quantity == "ambient_occlusion" else [])
    where = point(position, normal)
    if geometric_normal:
        where["geometric_normal"] = geometric_normal
    scene.case(name, source, ["rtdo"], quantity, expected, bound, why, point=where, seeds=64,
               settings=[f"rays_per_pixel={RAYS}", *estimator, *settings],
               **({"sky": sky} if sky else {}))


def close_up(scene, name, p, n, near=0.3, aside=None):
    """A camera that sees nothing but p, 16 pixels of it; adds it and returns the view. It looks
    along the normal from a distance of `near`, and a little from `aside`, a unit tangent."""
    n = unit(n)
    if aside is None:
        aside = unit(cross(n, (0.36, 0.48, 0.8) if abs(n[1]) > 0.5 else (0.28, 0.96, 0.0)))
    eye = add(p, scale(near, n), scale(0.2 * near, aside))
    scene.camera(name, camera_at(eye, p, up=aside), 1e-3, znear=0.1 * near, zfar=10 * near)
    return {"camera": name, "resolution": CLOSE}
