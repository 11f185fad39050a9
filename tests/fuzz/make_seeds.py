#!/usr/bin/env python3
"""Writes the fuzzers' seeds: small files of every kind that occlab reads. python3 make_seeds.py

OpenImageIO's oiiotool (Debian: openimageio-tools), which makes the images, is needed here only.
Files named regression-* are inputs that once failed; they are kept by hand.
"""

import base64
import contextlib
import json
import pathlib
import re
import sqlite3
import struct
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SEEDS = HERE / "seeds"
sys.path.insert(0, str(ROOT / "scenes"))
import glb  # noqa: E402


def write(kind, name, data):
    folder = SEEDS / kind
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(data if isinstance(data, bytes) else data.encode())


def oiiotool(suffix, *arguments):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / f"image{suffix}"
        subprocess.run(["oiiotool", "--nosoftwareattrib", *arguments, "-o", str(path)], check=True)
        return path.read_bytes()


def pattern(width, height, channels=3):
    return ["--pattern", "checker:color1=0.1,0.2,0.3:color2=2,1,0.5", f"{width}x{height}",
            str(channels)]


def textured(image, mime, as_uri):
    """A triangle with a texture, as JSON, NUL, binary chunk."""
    positions = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    uvs = struct.pack("<6f", 0, 0, 1, 0, 0, 1)
    indices = struct.pack("<3H", 0, 1, 2) + b"\0\0"
    blob = positions + uvs + indices + (b"" if as_uri else image)
    views = [{"buffer": 0, "byteOffset": 0, "byteLength": 36},
             {"buffer": 0, "byteOffset": 36, "byteLength": 24},
             {"buffer": 0, "byteOffset": 60, "byteLength": 6}]
    if as_uri:
        source = {"uri": f"data:{mime};base64," + base64.b64encode(image).decode()}
    else:
        views.append({"buffer": 0, "byteOffset": 68, "byteLength": len(image)})
        source = {"bufferView": 3, "mimeType": mime}
    document = {
        "asset": {"version": "2.0"}, "scene": 0,
        "extensionsUsed": ["KHR_texture_transform", "KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "spot", "color": [1, 0.5, 0], "intensity": 3, "range": 9,
             "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}},
            {"type": "point", "name": "lamp"}]}},
        "scenes": [{"nodes": [0, 1, 2], "extras": {"occlab": {
            "format": 1, "resolution": [64, 36], "lights": {"lamp": {"radius": 0.1}},
            "warnings": ["one"],
            "world": {"probe": "sky_sun", "rotation_degrees": 30, "strength": 2}}}}],
        "nodes": [{"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]},
                  {"camera": 0, "name": "eye", "translation": [0, 0, 3]},
                  {"children": [3], "rotation": [0, 0, 0, 1], "scale": [1, 2, 3]},
                  {"extensions": {"KHR_lights_punctual": {"light": 0}}, "name": "bulb"}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}],
        "meshes": [{"name": "m", "primitives": [
            {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {
            "baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0, "baseColorTexture": {
                "index": 0, "extensions": {"KHR_texture_transform": {
                    "offset": [0, 1], "rotation": 0.5, "scale": [0.5, 0.5]}}}}}],
        "textures": [{"source": 0, "sampler": 0}], "samplers": [{"wrapS": 10497}],
        "images": [source],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3, "sparse": {
                "count": 1, "indices": {"bufferView": 2, "componentType": 5123},
                "values": {"bufferView": 0}}},
            {"bufferView": 1, "componentType": 5126, "type": "VEC2", "count": 3},
            {"bufferView": 2, "componentType": 5123, "type": "SCALAR", "count": 3}],
        "bufferViews": views, "buffers": [{"byteLength": len(blob)}]}
    return json.dumps(document, separators=(",", ":")).encode() + b"\0" + blob


def scenes():
    for name in ("three_boxes/three_boxes", "analytic/sun", "analytic/lambda_wall"):
        data = (ROOT / f"scenes/{name}.glb").read_bytes()
        document, blob = glb.parse(data)
        for mesh in document.get("meshes", []):  # KHR_mesh_quantization's kinds are in the code too
            mesh.pop("extras", None)
        text = json.dumps(document, separators=(",", ":")).encode()
        write("gltf", pathlib.Path(name).name, text + b"\0" + bytes(blob))
    write("gltf", "container", (ROOT / "scenes/analytic/sun.glb").read_bytes())
    png = oiiotool(".png", *pattern(8, 4), "-d", "uint8")
    grey = oiiotool(".png", *pattern(8, 4, 2), "-d", "uint16")
    jpeg = oiiotool(".jpg", *pattern(8, 4))
    write("gltf", "png", textured(png, "image/png", False))
    write("gltf", "png_uri", textured(png, "image/png", True))
    write("gltf", "grey_png", textured(grey, "image/png", False))
    write("gltf", "jpeg", textured(jpeg, "image/jpeg", False))


def probes():
    for compression in ("none", "rle", "zip", "zips", "piz", "pxr24", "b44", "dwaa"):
        write("probe", f"{compression}.exr",
              oiiotool(".exr", *pattern(16, 8), "-d", "half", "--compression", compression))
    write("probe", "tiled.exr",
          oiiotool(".exr", *pattern(32, 16), "-d", "float", "--compression", "zip", "--tile", "16",
                   "16"))
    write("probe", "grey.exr", oiiotool(".exr", *pattern(16, 8, 1), "-d", "float"))
    write("probe", "run_length.hdr", oiiotool(".hdr", *pattern(16, 8)))
    write("probe", "flat.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n-Y 2 +X 4\n" +
          bytes(range(100, 132)))


def cells():
    facts = [["method", "ssao"], ["samples", "4"]]
    description = {"format": 1, "key": "0", "facts": facts,
                   "layers.exr": {"bytes": "$BYTES", "sha256": "$SHA256"},
                   "metadata": {"occlab:method": "ssao"}, "extra": {"ms": 1.5, "warnings": []}}
    text = json.dumps(description, indent=2).replace('"$BYTES"', "$BYTES")
    image = oiiotool(".exr", *pattern(4, 4), "-d", "float", "--compression", "none",
                     "--chnames", "radiance.R,radiance.G,radiance.B", "--attrib", "occlab:method",
                     "ssao")
    write("cell", "good", text.encode() + b"\0" + image)
    write("cell", "wrong_checksum", text.replace("$SHA256", "00").encode() + b"\0" + image)
    write("cell", "other_facts", text.replace("ssao", "s3ho").encode() + b"\0" + image)
    write("cell", "no_pixels", text.encode())


def texts():
    head = ("experiment,scene,view,resolution,probe,method,parameter.samples,seed,stage,metric,unit,"
            "value,lower,upper,n,device,clock,cells,reference_cell,reason\r\n")
    write("measurements", "two", head +
          "e,s,main,64x36,sky,ssao,4,0,filtered,rmse,k,0.25,0.125,0.5,3,llvmpipe,,aa;bb,cc,\r\n"
          'e,s,main,64x36,"a, ""b""",ssao,,all,,time_ms.frame,ms,,,,0,llvmpipe,wall,,,none\r\n')
    write("measurements", "infinite", head +
          "e,s,main,64x36,sky,ssao,4,0,,psnr,dB,inf,-inf,inf,1,,,,,\r\n")
    for config in sorted((ROOT / "configs").rglob("*.toml")):
        # The names of the fuzzer's methods.
        text = config.read_text(encoding="utf-8").replace("ssdo", "fixed").replace("ssbn", "s3ho")
        write("experiment", config.stem, text)
    write("experiment", "override", "format = 1\n[experiment]\nname = \"a\"\ntitle = \"b\"\n"
          "[scene]\nsource = \"gallery\"\n[[run]]\nmethods = [\"ssao\"]\n\0run[0].samples=[1,2]")


def histories():
    steps = re.findall(r'R"sql\((.*?)\)sql"', (ROOT / "harness/history/schema.cpp").read_text(), re.S)
    for version in (1, 3):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "h.sqlite"
            with contextlib.closing(sqlite3.connect(path)) as database:
                database.executescript("PRAGMA page_size = 512; PRAGMA application_id = 0x6f63636c;"
                                       f"PRAGMA user_version = {version};")
                for step in steps[:version]:
                    database.executescript(step)
                database.execute("INSERT INTO runs VALUES (1, 'c', 'abcd1234', 's', '', "
                                 "'2026-01-01T00:00:00Z', 'e', 'd', '{\"schema\": 1}')")
                database.execute("INSERT INTO series VALUES (1, '0123456789abcdef', 'e', 's', 'main', "
                                 "'64x36', 'sky', 'ssao', '[[\"samples\", \"4\"]]', 'filtered', "
                                 "'rmse', '1', 'd')")
                database.execute("INSERT INTO over_seeds VALUES (1, 1, 0.25, 0.125, 0.5, 2, '')")
                database.execute("INSERT INTO per_seed VALUES (1, 1, 0, 0.25), (1, 1, 1, NULL)")
                if version == 3:
                    database.execute("INSERT INTO baselines VALUES (1, 'main', 'e', 1, 'me', "
                                     "'2026-01-01T00:00:00Z', 'first', '[]')")
                    database.execute("INSERT INTO intended VALUES ('0123456789abcdef', 'abcd1234', "
                                     "'me', '2026-01-01T00:00:00Z', 'wanted')")
                database.commit()
                database.execute("VACUUM")
            write("history", f"version-{version}", path.read_bytes())


if __name__ == "__main__":
    histories()
    scenes()
    probes()
    cells()
    texts()
