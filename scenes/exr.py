"""A deterministic writer, and a reader for what it writes, of small half-float RGB OpenEXR images.

Blender's own writer stamps the file with dates and render facts; a committed probe must not change
when nothing in it does. Needs nothing but the standard library.

OpenEXR file layout, single-part scan lines: https://openexr.com/en/latest/OpenEXRFileLayout.html
"""

import struct
import zlib

MAGIC = 20000630
ZIP_COMPRESSION = 3
ZIP_ROWS = 16  # scan lines of a ZIP block
HALF = 1
CHANNELS = "BGR"  # stored in alphabetical order


def _predict(raw):
    """The ZIP codec's reordering (even bytes, then odd bytes) and its delta predictor."""
    split = raw[0::2] + raw[1::2]
    previous = 128  # so that the first byte is stored as it is
    coded = bytearray(len(split))
    for i, value in enumerate(split):
        coded[i] = (value - previous + 128) & 255
        previous = value
    return bytes(coded)


def _unpredict(coded):
    previous = 128
    split = bytearray(len(coded))
    for i, value in enumerate(coded):
        previous = (value + previous - 128) & 255
        split[i] = previous
    half = (len(split) + 1) // 2
    raw = bytearray(len(split))
    raw[0::2] = split[:half]
    raw[1::2] = split[half:]
    return bytes(raw)


def _attribute(name, kind, value):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value


def encode(width, height, rows):
    """The bytes of an EXR file. `rows`: `height` rows, the top one first, of `width` (r, g, b)."""
    channels = b"".join(
        name.encode() + b"\0" + struct.pack("<iB3xii", HALF, 0, 1, 1) for name in CHANNELS)
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = struct.pack("<ii", MAGIC, 2) + b"".join((
        _attribute("channels", "chlist", channels + b"\0"),
        _attribute("compression", "compression", bytes([ZIP_COMPRESSION])),
        _attribute("dataWindow", "box2i", window),
        _attribute("displayWindow", "box2i", window),
        _attribute("lineOrder", "lineOrder", b"\0"),
        _attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
        _attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0)),
        _attribute("screenWindowWidth", "float", struct.pack("<f", 1.0)),
    )) + b"\0"

    blocks = []
    for top in range(0, height, ZIP_ROWS):
        raw = b"".join(
            struct.pack(f"<{width}e", *(pixel["RGB".index(name)] for pixel in row))
            for row in rows[top:top + ZIP_ROWS] for name in CHANNELS)
        packed = zlib.compress(_predict(raw), 9)
        packed = packed if len(packed) < len(raw) else raw
        blocks.append(struct.pack("<ii", top, len(packed)) + packed)
    offset = len(header) + 8 * len(blocks)
    table = b""
    for block in blocks:
        table += struct.pack("<Q", offset)
        offset += len(block)
    return header + table + b"".join(blocks)


def decode(data):
    """(width, height, rows) of a file made by `encode`; ValueError for any other EXR."""
    if struct.unpack_from("<ii", data) != (MAGIC, 2):
        raise ValueError("not a single-part scan-line OpenEXR file")
    attributes = {}
    at = 8
    while data[at]:
        end = data.index(b"\0", at)
        name = data[at:end].decode()
        at = data.index(b"\0", end + 1) + 1
        size = struct.unpack_from("<i", data, at)[0]
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    if attributes["compression"] != bytes([ZIP_COMPRESSION]) or len(attributes["channels"]) != 55:
        raise ValueError("not a ZIP-compressed half-float RGB image")
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    offsets = struct.unpack_from(f"<{(height + ZIP_ROWS - 1) // ZIP_ROWS}Q", data, at + 1)

    rows = []
    for offset in offsets:
        first, size = struct.unpack_from("<ii", data, offset)
        count = min(ZIP_ROWS, height - first)
        packed = data[offset + 8:offset + 8 + size]
        raw = packed if size == count * width * 6 else _unpredict(zlib.decompress(packed))
        for line in range(count):
            blue, green, red = (
                struct.unpack_from(f"<{width}e", raw, (3 * line + channel) * 2 * width)
                for channel in range(3))
            rows.append(list(zip(red, green, blue)))
    return width, height, rows
