#!/usr/bin/env python3
"""Values of the image metrics that owe nothing to the C++ which is tested with them.

    python3 make_golden.py          writes metrics.json
    python3 make_golden.py --check  exits with 1 where metrics.json differs from what would be written

Everything is written out from the papers in double precision: every convolution is the sum over the
two-dimensional kernel, and every image is encoded and decoded wherever the papers say so. Images are
made of integers, divided by a power of two, so that all precisions hold the same values. Needs NumPy.

    FLIP       Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom, Fairchild 2020, "FLIP: A
               Difference Evaluator for Alternating Images"
    HDR-FLIP   Andersson, Nilsson, Shirley, Akenine-Moeller 2021, "Visualizing Errors in Rendered High
               Dynamic Range Images"
    CIEDE2000  Sharma, Wu, Dalal 2005, "The CIEDE2000 color-difference formula: implementation notes"
    SSIM       Wang, Bovik, Sheikh, Simoncelli 2004, "Image quality assessment"

The authors of FLIP publish means of their own for their test images, 0.159691 (LDR) and 0.283478
(HDR). The images are not ours to ship, so these two are no part of the file. The file does hold FLIP
for the finer matrix from RGB to XYZ of the authors' program ("..._fine_matrix"), beside that of IEC
61966-2-1 which the metrics use: what the choice is worth.
"""

import json
import math
import sys
from pathlib import Path

import numpy as np

IEC_MATRIX = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
FINE_MATRIX = np.array([[10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794],
                        [2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897],
                        [1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382]])
PIXELS_PER_DEGREE = 0.7 * 3840 / 0.7 * math.pi / 180
DIVISOR = 256


# ---- colour -------------------------------------------------------------------------------------


def encode(linear):
    return np.where(linear <= 0.0031308, 12.92 * linear,
                    1.055 * np.maximum(linear, 0.0031308)**(1 / 2.4) - 0.055)


def decode(srgb):
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055)**2.4)


def luminance(rgb):
    return rgb @ np.array([0.2126, 0.7152, 0.0722])


def lab(rgb, matrix):
    """CIELAB of linear RGB, relative to the matrix's own white."""
    t = (rgb @ matrix.T) / matrix.sum(axis=1)
    f = np.where(t > (6 / 29)**3, np.cbrt(t), t * (29 / 6)**2 / 3 + 4 / 29)
    return np.stack([116 * f[..., 1] - 16, 500 * (f[..., 0] - f[..., 1]),
                     200 * (f[..., 1] - f[..., 2])], axis=-1)


def ciede2000(first, second):
    """Two colours L*, a*, b*."""
    (l1, a1, b1), (l2, a2, b2) = first, second
    mean_chroma = (math.hypot(a1, b1) + math.hypot(a2, b2)) / 2
    g = 0.5 * (1 - math.sqrt(mean_chroma**7 / (mean_chroma**7 + 25.0**7)))
    a1, a2 = (1 + g) * a1, (1 + g) * a2
    c1, c2 = math.hypot(a1, b1), math.hypot(a2, b2)
    h1 = math.degrees(math.atan2(b1, a1)) % 360 if c1 > 0 else 0.0
    h2 = math.degrees(math.atan2(b2, a2)) % 360 if c2 > 0 else 0.0
    if c1 * c2 == 0:
        dh, h = 0.0, h1 + h2
    else:
        dh = (h2 - h1 + 180) % 360 - 180 if abs(h2 - h1) != 180 else h2 - h1
        if abs(h1 - h2) <= 180:
            h = (h1 + h2) / 2
        else:
            h = (h1 + h2 + 360) / 2 if h1 + h2 < 360 else (h1 + h2 - 360) / 2
    dhue = 2 * math.sqrt(c1 * c2) * math.sin(math.radians(dh) / 2)
    l, c = (l1 + l2) / 2, (c1 + c2) / 2
    t = (1 - 0.17 * math.cos(math.radians(h - 30)) + 0.24 * math.cos(math.radians(2 * h)) +
         0.32 * math.cos(math.radians(3 * h + 6)) - 0.20 * math.cos(math.radians(4 * h - 63)))
    s_l = 1 + 0.015 * (l - 50)**2 / math.sqrt(20 + (l - 50)**2)
    s_c = 1 + 0.045 * c
    s_h = 1 + 0.015 * c * t
    r_c = 2 * math.sqrt(c**7 / (c**7 + 25.0**7))
    r_t = -math.sin(math.radians(60 * math.exp(-((h - 275) / 25)**2))) * r_c
    dl, dc, dhue = (l2 - l1) / s_l, (c2 - c1) / s_c, dhue / s_h
    return math.sqrt(dl * dl + dc * dc + dhue * dhue + r_t * dc * dhue)


# ---- FLIP ---------------------------------------------------------------------------------------


def convolve(plane, kernel):
    """Sum over the whole kernel; the image's border goes on outside of it."""
    radius = kernel.shape[0] // 2
    height, width = plane.shape
    padded = np.pad(plane, radius, mode="edge")
    total = np.zeros_like(plane)
    for dy in range(-radius, radius + 1):
        for dx in range(-radius, radius + 1):
            total += kernel[radius - dy, radius - dx] * padded[radius + dy:radius + dy + height,
                                                               radius + dx:radius + dx + width]
    return total


def sensitivity_kernel(terms):
    """terms: (a, b) of a sqrt(pi / b) exp(-pi^2 z^2 / b), z in degrees."""
    radius = math.ceil(3 * math.sqrt(0.04 / (2 * math.pi**2)) * PIXELS_PER_DEGREE)
    y, x = np.mgrid[-radius:radius + 1, -radius:radius + 1] / PIXELS_PER_DEGREE
    kernel = sum(a * math.sqrt(math.pi / b) * np.exp(-math.pi**2 * (x * x + y * y) / b)
                 for a, b in terms)
    return kernel / kernel.sum()


def feature_kernels():
    """Edge and point detector along x."""
    sigma = 0.5 * 0.082 * PIXELS_PER_DEGREE
    radius = math.ceil(3 * sigma)
    y, x = np.mgrid[-radius:radius + 1, -radius:radius + 1].astype(float)
    g = np.exp(-(x * x + y * y) / (2 * sigma * sigma))
    kernels = []
    for kernel in (-x * g, (x * x / (sigma * sigma) - 1) * g):
        positive = kernel[kernel > 0].sum()
        negative = -kernel[kernel < 0].sum()
        kernels.append(np.where(kernel > 0, kernel / positive, kernel / negative))
    return kernels


def hunt(colours):
    l = colours[..., :1]
    return np.concatenate([l, 0.01 * l * colours[..., 1:]], axis=-1)


def hyab(first, second):
    d = first - second
    return np.abs(d[..., 0]) + np.hypot(d[..., 1], d[..., 2])


def flip(reference_srgb, test_srgb, matrix):
    """Map of FLIP of two images of sRGB values."""
    white = matrix.sum(axis=1)
    csf = [sensitivity_kernel([(1, 0.0047)]), sensitivity_kernel([(1, 0.0053)]),
           sensitivity_kernel([(34.1, 0.04), (13.5, 0.025)])]

    def seen(srgb):
        x, y, z = np.moveaxis((decode(srgb) @ matrix.T) / white, -1, 0)
        opponent = [116 * y - 16, 500 * (x - y), 200 * (y - z)]
        features = []
        for kernel in feature_kernels():
            grey = (opponent[0] + 16) / 116
            features.append(np.hypot(convolve(grey, kernel), convolve(grey, kernel.T)))
        y, cx, cz = [convolve(plane, kernel) for plane, kernel in zip(opponent, csf)]
        y = (y + 16) / 116
        xyz = np.stack([y + cx / 500, y, y - cz / 200], axis=-1) * white
        rgb = np.clip(xyz @ np.linalg.inv(matrix).T, 0, 1)
        return hunt(lab(rgb, matrix)), features

    colours_r, features_r = seen(reference_srgb)
    colours_t, features_t = seen(test_srgb)
    q_c, p_c, p_t, q_f = 0.7, 0.4, 0.95, 0.5
    extremes = hunt(lab(np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), matrix))
    c_max = hyab(extremes[0], extremes[1])**q_c
    colour = hyab(colours_r, colours_t)**q_c
    knee = p_c * c_max
    colour = np.where(colour < knee, p_t / knee * colour,
                      p_t + (colour - knee) / (c_max - knee) * (1 - p_t))
    feature = np.maximum(*[np.abs(r - t) for r, t in zip(features_r, features_t)])
    return colour**(1 - (feature / math.sqrt(2))**q_f)


def aces(x):
    x = 0.6 * np.maximum(x, 0)
    return np.clip((2.51 * x * x + 0.03 * x) / (2.43 * x * x + 0.59 * x + 0.14), 0, 1)


def hdr_exposures(reference, inside):
    """Stops, from the shortest exposure to the longest."""
    # aces(x) = 0.85 for u = 0.6 x: (2.51 - 0.85 * 2.43) u^2 + (0.03 - 0.85 * 0.59) u - 0.85 * 0.14 = 0
    x_max = max(np.roots([2.51 - 0.85 * 2.43, 0.03 - 0.85 * 0.59, -0.85 * 0.14])) / 0.6
    y = luminance(reference)[inside]
    start, stop = math.log2(x_max / y.max()), math.log2(x_max / np.median(y))
    return np.linspace(start, stop, max(2, math.ceil(stop - start)))


# ---- the metrics --------------------------------------------------------------------------------


def on_grey(linear, inside):
    """sRGB values of a displayed image; outside the mask half of the encoded range."""
    return np.where(inside[..., None], encode(linear), 0.5)


def ssim(x, r, inside):
    window = np.exp(-(np.arange(-5, 6)[:, None]**2 + np.arange(-5, 6)**2) / (2 * 1.5**2))
    window /= window.sum()
    values = []
    for top in range(x.shape[0] - 10):
        for left in range(x.shape[1] - 10):
            at = np.s_[top:top + 11, left:left + 11]
            if not inside[at].all():
                continue
            mx, mr = (window * x[at]).sum(), (window * r[at]).sum()
            vx = (window * (x[at] - mx)**2).sum()
            vr = (window * (r[at] - mr)**2).sum()
            vxr = (window * (x[at] - mx) * (r[at] - mr)).sum()
            values.append((2 * mx * mr + 0.01**2) * (2 * vxr + 0.03**2) /
                          ((mx * mx + mr * mr + 0.01**2) * (vx + vr + 0.03**2)))
    return float(np.mean(values)) if values else None


def measure(reference, test, inside):
    r, x = reference, test
    mean = luminance(r)[inside].mean()
    r, x = r / mean, x / mean
    white = np.quantile(luminance(r)[inside], 0.99)
    shown_r, shown_x = np.clip(r / white, 0, 1), np.clip(x / white, 0, 1)
    mse = ((encode(shown_x) - encode(shown_r))[inside]**2).mean()
    luma_x, luma_r = luminance(encode(shown_x)), luminance(encode(shown_r))
    labs = [lab(shown[inside], IEC_MATRIX) for shown in (shown_r, shown_x)]
    values = {
        "rmse": math.sqrt(((x - r)[inside]**2).mean()),
        "relmse": ((x - r)**2 / (r**2 + 0.01))[inside].mean(),
        "smape": (np.abs(x - r) / (np.abs(x) + np.abs(r) + 0.01))[inside].mean(),
        "psnr": -10 * math.log10(mse),
        "ssim": ssim(luma_x, luma_r, inside),
        "ciede2000": np.mean([ciede2000(a, b) for a, b in zip(*labs)]),
    }
    exposures = hdr_exposures(r, inside)
    for suffix, matrix in (("", IEC_MATRIX), ("_fine_matrix", FINE_MATRIX)):
        ldr = flip(on_grey(shown_r, inside), on_grey(shown_x, inside), matrix)
        hdr = np.max([flip(on_grey(aces(r * 2.0**e), inside), on_grey(aces(x * 2.0**e), inside),
                           matrix) for e in exposures], axis=0)
        values["flip_ldr" + suffix] = ldr[inside].mean()
        values["flip_hdr" + suffix] = hdr[inside].mean()
    return {k: v if v is None else float(v) for k, v in values.items()}, len(exposures)


# ---- the images ---------------------------------------------------------------------------------


def scrambled(x, y, c, seed):
    """An integer in [0, 65536) that looks random."""
    v = (x * 7919 + y * 104729 + c * 1299709 + seed * 15485863) % 4294967296
    for factor in (2654435761, 2246822519):
        v = (v ^ (v >> 15)) * factor % 4294967296
    return v >> 16


def grid(width, height, value, channels=3):
    return np.array([[[value(x, y, c) for c in range(channels)] for x in range(width)]
                     for y in range(height)], dtype=np.int64)


def everywhere(width, height):
    return grid(width, height, lambda x, y, c: 1, 1)


def cases():
    """name, what for, reference, test, mask: integers, radiance is a 256th of them."""
    w, h = 30, 24
    yield ("noise", "independent colours in both images",
           grid(w, h, lambda x, y, c: 13 + scrambled(x, y, c, 1) % 500),
           grid(w, h, lambda x, y, c: 13 + scrambled(x, y, c, 2) % 500), everywhere(w, h))

    w, h = 36, 28

    def ramp(x, y, c):
        box = 3 if 8 <= x < 15 and 6 <= y < 20 else 1
        return ((x + 2)**5 // 2000 + 5 * y * (c + 1)) * (4 + (c == y % 3)) // (4 * box)

    yield ("ramp", "four stops from the median to the maximum, an edge displaced by two pixels and "
           "a tint; the mask has holes and a border that is not straight",
           grid(w, h, ramp), grid(w, h, lambda x, y, c: ramp(max(x - 2, 0), y, c) * (9 - c) // 8),
           grid(w, h, lambda x, y, c: int((7 * x + 5 * y) % 211 > 1 and x > 1 + y % 3), 1))

    w, h = 27, 33

    def lines(x, y, c):
        return 300 + 40 * c if x % 9 == 4 or (x + 2 * y) % 17 == 0 else 60 - 10 * c

    yield ("lines", "lines and dots, half of which the test image has lost",
           grid(w, h, lines), grid(w, h, lambda x, y, c: lines(x, y, c) if y > 16 else 70 - 10 * c),
           everywhere(w, h))

    w, h = 26, 22
    yield ("negative", "black pixels in the reference, negative ones in the test image",
           grid(w, h, lambda x, y, c: 0 if x < 6 else 40 + scrambled(x // 4, y // 4, c, 3) % 300),
           grid(w, h, lambda x, y, c: scrambled(x // 4, y // 4, c, 3) % 300 - 25 + (x * y) % 5),
           everywhere(w, h))

    yield ("constant", "two constant images: a reference without range, a difference without features",
           grid(14, 12, lambda x, y, c: (128, 64, 32)[c]),
           grid(14, 12, lambda x, y, c: (64, 128, 33)[c]), everywhere(14, 12))

    yield ("small", "smaller than every filter: no window of SSIM",
           grid(5, 4, lambda x, y, c: 20 + scrambled(x, y, c, 5) % 400),
           grid(5, 4, lambda x, y, c: 20 + scrambled(x, y, c, 6) % 400), everywhere(5, 4))

    yield ("pixel", "one pixel", grid(1, 1, lambda x, y, c: (200, 180, 190)[c]),
           grid(1, 1, lambda x, y, c: (150, 160, 170)[c]), everywhere(1, 1))


def golden():
    result = {
        "origin": "tests/golden/make_golden.py, NumPy, double precision, from the papers it names",
        "divisor": DIVISOR,
        "cases": [],
    }
    for name, purpose, reference, test, mask in cases():
        inside = mask[..., 0] > 0
        values, exposures = measure(reference / DIVISOR, test / DIVISOR, inside)
        result["cases"].append({
            "name": name, "purpose": purpose,
            "width": reference.shape[1], "height": reference.shape[0],
            "reference": reference.ravel().tolist(), "test": test.ravel().tolist(),
            "mask": mask.ravel().tolist(), "hdr_exposures": exposures, "expected": values,
        })
    return result


def as_text(result):
    """JSON with one line for each image."""
    head = {k: v for k, v in result.items() if k != "cases"}
    lines = [json.dumps(head)[:-1] + ', "cases": [']
    for i, case in enumerate(result["cases"]):
        fields = [f"  {json.dumps(k)}: {json.dumps(v)}" for k, v in case.items()]
        lines.append(" {\n" + ",\n".join(fields) + "\n }" + ("," if i + 1 < len(result["cases"]) else ""))
    return "\n".join(lines) + "\n]}\n"


def differences(stored, made, where=""):
    """Where the two differ by more than what another NumPy or processor may round otherwise."""
    if isinstance(made, dict):
        if not isinstance(stored, dict) or stored.keys() != made.keys():
            return [f"{where}: other keys"]
        return [d for k in made for d in differences(stored[k], made[k], f"{where}/{k}")]
    if isinstance(made, float):
        same = isinstance(stored, float) and abs(stored - made) <= 1e-12 * max(1, abs(made))
        return [] if same else [f"{where}: {stored} stored, {made} made"]
    if isinstance(made, list) and isinstance(stored, list) and len(made) == len(stored):
        pairs = enumerate(zip(stored, made))
        return [d for i, (s, m) in pairs for d in differences(s, m, f"{where}/{i}")]
    return [] if stored == made else [f"{where}: {stored} stored, {made} made"]


def main():
    path = Path(__file__).with_name("metrics.json")
    made = golden()
    if sys.argv[1:] == ["--check"]:
        found = differences(json.loads(path.read_text()), made)
        print("\n".join(found) or f"{path.name} is what this script makes")
        return 1 if found else 0
    if sys.argv[1:]:
        print(__doc__, file=sys.stderr)
        return 2
    path.write_text(as_text(made))
    return 0


if __name__ == "__main__":
    sys.exit(main())
