"""Makes the light probes of this repository: cathedral.exr, cathedral_ldr.exr and sky_sun.exr.

    blender --background --factory-startup --python-exit-code 3 --python scenes/probes/build.py \
        [-- FOLDER]

(Blender only for its numpy: any Python with numpy does.) All are equirect, 256 x 128, linear RGB
radiance, row 0 at the top. A direction's angles are glTF's: azimuth 0 is +X, 90 degrees is +Z, and
elevation 90 degrees is +Y. Seen from the `main` cameras, which look along -Z, azimuth 0 is to the
right, 90 behind the camera, 180 to the left and -90 straight ahead.
"""

import pathlib
import sys

import numpy

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import exr  # noqa: E402

WIDTH, HEIGHT = 256, 128
LUMINANCE = numpy.array([0.2126, 0.7152, 0.0722])  # Rec. 709


def grid():
    """Azimuth and elevation of the texel centres, radians, (HEIGHT, WIDTH)."""
    u = (numpy.arange(WIDTH) + 0.5) / WIDTH
    v = (numpy.arange(HEIGHT) + 0.5) / HEIGHT
    azimuth, elevation = numpy.meshgrid(2 * numpy.pi * (u - 0.5), numpy.pi * (0.5 - v))
    return azimuth, elevation


def directions(azimuth, elevation):
    return numpy.stack([numpy.cos(elevation) * numpy.cos(azimuth), numpy.sin(elevation),
                        numpy.cos(elevation) * numpy.sin(azimuth)], axis=-1)


def angle_to(direction, azimuth_degrees, elevation_degrees):
    """Angle in radians between every direction and the given one."""
    centre = directions(numpy.radians(azimuth_degrees), numpy.radians(elevation_degrees))
    return numpy.arccos(numpy.clip(direction @ centre, -1.0, 1.0))


def smoothstep(low, high, x):
    t = numpy.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def value_noise(points, seed):
    """Smoothly interpolated lattice noise in [0, 1] at `points` (..., 3)."""
    lattice = numpy.random.RandomState(seed).random_sample((32, 32, 32))
    cell = numpy.floor(points).astype(int)
    t = points - cell
    t = t * t * (3.0 - 2.0 * t)
    total = numpy.zeros(points.shape[:-1])
    for corner in range(8):
        offset = numpy.array([corner & 1, corner >> 1 & 1, corner >> 2])
        weight = numpy.prod(numpy.where(offset == 1, t, 1.0 - t), axis=-1)
        index = (cell + offset) % 32
        total += weight * lattice[index[..., 0], index[..., 1], index[..., 2]]
    return total


def fractal_noise(points, seed, octaves):
    total, amplitude, norm = 0.0, 1.0, 0.0
    for octave in range(octaves):
        total = total + amplitude * value_noise(points * 2.0 ** octave, seed + octave)
        norm += amplitude
        amplitude *= 0.55
    return total / norm


# Small windows: azimuth, elevation (degrees), colour, luminance of the core. The walls, the floor
# and every side of an object see a different mixture of them.
WINDOWS = (
    (14.0, 27.0, (1.00, 0.50, 0.14), 3200.0),   # orange, from the right
    (78.0, 38.0, (0.10, 0.30, 1.00), 760.0),    # blue, from behind the camera
    (166.0, 58.0, (0.22, 1.00, 0.38), 900.0),   # green, above the left
    (-76.0, 52.0, (1.00, 0.10, 0.42), 520.0),   # red to purple, above straight ahead
    (48.0, 71.0, (1.00, 0.82, 0.50), 260.0),    # pale lamp, high
    (118.0, 20.0, (0.42, 0.16, 1.00), 150.0),   # violet, low and behind on the left
)
GLOW = 0.004  # of the core's luminance, in the leaded glass around it


def cathedral():
    azimuth, elevation = grid()
    direction = directions(azimuth, elevation)
    stone = fractal_noise(direction * 6.0, 11, 4)

    # Masonry: warm brown, pillars every 22.5 degrees, a gallery, ribs that meet in the vault.
    pillar = smoothstep(0.55, 0.95, numpy.cos(16.0 * azimuth)) * smoothstep(
        1.05, 0.85, numpy.abs(elevation))
    arch = smoothstep(0.035, 0.0, numpy.abs(
        elevation - 0.55 - 0.16 * numpy.abs(numpy.sin(8.0 * azimuth))))
    cornice = smoothstep(0.03, 0.0, numpy.abs(elevation - 0.12))
    ribs = smoothstep(0.93, 1.0, numpy.cos(16.0 * azimuth)) * smoothstep(0.75, 0.95, elevation)
    brightness = (0.045 + 0.05 * stone) * (1.0 + 1.1 * pillar + 0.9 * arch + 0.8 * cornice
                                           + 0.9 * ribs)
    brightness *= 0.75 + 0.25 * numpy.cos(azimuth - 0.6)  # darker away from the altar
    floor = smoothstep(0.0, -0.08, elevation)
    tiles = numpy.where((numpy.floor(azimuth * 12.0 / numpy.pi)
                         + numpy.floor(4.0 / numpy.maximum(numpy.sin(-elevation), 0.05))) % 2 == 0,
                        1.0, 0.55)
    tiles += (0.775 - tiles) * smoothstep(-0.30, -0.12, elevation)  # too small to show at the rim
    brightness = brightness * (1.0 - floor) + floor * 0.05 * tiles * (0.6 + 0.8 * stone)
    image = brightness[..., None] * numpy.array([1.30, 0.95, 0.62])

    # The altar: lit gold behind and to the right of the camera, mirrored weakly by the floor.
    altar = numpy.exp(-(((azimuth - numpy.radians(40.0)) / 0.16) ** 2
                        + ((elevation - 0.10) / 0.22) ** 2))
    mirrored = numpy.exp(-(((azimuth - numpy.radians(40.0)) / 0.20) ** 2
                           + ((elevation + 0.35) / 0.20) ** 2))
    image += (3.4 * altar * (0.5 + stone))[..., None] * numpy.array([1.25, 0.95, 0.50])
    image += (0.35 * mirrored)[..., None] * numpy.array([1.2, 0.95, 0.6])

    for at_azimuth, at_elevation, colour, core in WINDOWS:
        colour = numpy.array(colour) / (LUMINANCE @ numpy.array(colour))
        column = int((at_azimuth / 360.0 + 0.5) * WIDTH)
        row = int((0.5 - at_elevation / 180.0) * HEIGHT)
        # A lancet: one bright texel, half of it above and a quarter below, in a leaded frame.
        image[row, column] += core * colour
        image[row - 1, column] += 0.40 * core * colour
        image[row + 1, column] += 0.20 * core * colour
        frame = smoothstep(0.11, 0.0, angle_to(direction, at_azimuth, at_elevation))
        image += (GLOW * core * frame ** 2)[..., None] * colour
    return image


SUN_AZIMUTH, SUN_ELEVATION = 18.0, 36.0  # from the right, a little behind the camera


def sky_sun():
    azimuth, elevation = grid()
    direction = directions(azimuth, elevation)
    height = numpy.maximum(numpy.sin(elevation), 0.0)

    # A clear sky: deep blue above, pale at the horizon.
    pale = numpy.array([0.52, 0.66, 0.86])
    deep = numpy.array([0.10, 0.24, 0.66])
    blue = (pale - deep) * ((1.0 - height) ** 4)[..., None] + deep

    # Clouds on a plane above, so that they shrink towards the horizon.
    plane = direction / (height + 0.18)[..., None]
    cover = fractal_noise(plane * numpy.array([1.6, 0.0, 1.6]) + 7.3, 23, 5)
    cloud = smoothstep(0.50, 0.68, cover) * smoothstep(0.0, 0.12, height)
    to_sun = angle_to(direction, SUN_AZIMUTH, SUN_ELEVATION)
    cloud *= smoothstep(0.12, 0.35, to_sun)  # nothing in front of the sun
    shade = 1.0 - 0.55 * smoothstep(0.58, 0.80, cover)
    white = (0.80 + 0.9 * numpy.exp(-to_sun / 0.5)) * shade
    sky = blue * (1.0 - cloud)[..., None] + (cloud * white)[..., None] * numpy.array(
        [0.96, 0.98, 1.04])

    # The sun: a yellow disc of 1.6 degrees with an aureole.
    yellow = numpy.array([1.0, 0.80, 0.36])
    disc = smoothstep(numpy.radians(2.0), numpy.radians(1.2), to_sun)
    aureole = 1.6 * numpy.exp(-to_sun / 0.10) + 0.25 * numpy.exp(-to_sun / 0.45)
    sky = sky + (3200.0 * disc + aureole)[..., None] * yellow

    # Ground: grey-brown, in the sun.
    soil = fractal_noise(direction / numpy.maximum(-numpy.sin(elevation), 0.08)[..., None], 41, 4)
    ground = (0.14 + 0.14 * soil)[..., None] * numpy.array([1.06, 0.98, 0.86])
    return numpy.where((elevation > 0.0)[..., None], sky, ground)


def dusk():
    """A sky whose sun has set: smooth, and yet brighter and warmer on one side, behind on the right
    of the camera; for scenes that have lamps of their own."""
    azimuth, elevation = grid()
    direction = directions(azimuth, elevation)
    height = numpy.maximum(numpy.sin(elevation), 0.0)
    pale, deep = numpy.array([0.55, 0.60, 0.74]), numpy.array([0.20, 0.32, 0.66])
    sky = (pale - deep) * ((1.0 - height) ** 3)[..., None] + deep
    glow = 2.4 * numpy.exp(-(angle_to(direction, 55.0, 14.0) / 0.62) ** 2)
    sky = sky + glow[..., None] * numpy.array([1.0, 0.62, 0.32])
    ground = 0.12 * numpy.array([1.06, 0.98, 0.86])
    # The horizon is hazy, not an edge.
    share = smoothstep(-0.05, 0.05, elevation)[..., None]
    return sky * share + ground * (1.0 - share)


def save(path, image):
    half = image.astype(numpy.float16)
    if not (numpy.isfinite(half).all() and (half >= 0).all()):
        raise ValueError(f"{path}: negative or not finite")
    path.write_bytes(exr.encode(WIDTH, HEIGHT, half.astype(float).tolist()))
    return half.astype(float)


def describe(name, image):
    """Prints what FORMAT.md states of a probe."""
    luminance = image @ LUMINANCE
    edges = numpy.pi * (0.5 - numpy.arange(HEIGHT + 1) / HEIGHT)
    solid_angle = 2 * numpy.pi / WIDTH * (numpy.sin(edges[:-1]) - numpy.sin(edges[1:]))
    sphere_mean = (luminance.mean(axis=1) * solid_angle).sum() * WIDTH / (4 * numpy.pi)
    azimuth, elevation = grid()
    direction = directions(azimuth, elevation)
    print(f"{name}: luminance max {luminance.max():.1f} min {luminance.min():.4f} "
          f"pixel mean {luminance.mean():.4f} mean over the sphere {sphere_mean:.4f}")
    for side, normal in (("up", (0, 1, 0)), ("right", (1, 0, 0)), ("left", (-1, 0, 0)),
                         ("to the camera", (0, 0, 1)), ("ahead", (0, 0, -1)), ("down", (0, -1, 0))):
        cosine = numpy.maximum(direction @ numpy.array(normal, float), 0.0)
        irradiance = (image * (cosine * solid_angle[:, None])[..., None]).sum(axis=(0, 1))
        print(f"  E/pi facing {side}: " + " ".join(f"{x:.3f}" for x in irradiance / numpy.pi))


def main():
    arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    folder = pathlib.Path(arguments[0]) if arguments else HERE
    hdr = cathedral()
    # As a camera of low dynamic range has it: what is brighter than 1 is 1.
    ldr = numpy.minimum(hdr, 1.0)
    for name, image in (("cathedral", hdr), ("cathedral_ldr", ldr), ("sky_sun", sky_sun()),
                        ("dusk", dusk())):
        describe(name, save(folder / f"{name}.exr", image))


main()
