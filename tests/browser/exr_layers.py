"""Layers of the EXR files that occlab writes, read without occlab or its libraries."""

import pathlib
import struct
import sys
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scenes"))
import exr  # noqa: E402

FLOAT = 2
ROWS = {0: 1, 3: 16}  # of a block, by compression: none, ZIP


def _attributes(data):
    found, at = {}, 8
    while data[at]:
        end = data.index(b"\0", at)
        name = data[at:end].decode()
        at = data.index(b"\0", end + 1) + 1
        size = struct.unpack_from("<i", data, at)[0]
        found[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    return found, at + 1


def _channels(packed):
    names, at = [], 0
    while packed[at]:
        end = packed.index(b"\0", at)
        names.append(packed[at:end].decode())
        if struct.unpack_from("<i", packed, end + 1)[0] != FLOAT:
            raise ValueError(f"channel {names[-1]} is not float")
        at = end + 17
    return names


def read(path):
    """{channel name: rows of floats, top row first} of a scan-line file, plain or ZIP."""
    data = pathlib.Path(path).read_bytes()
    attributes, at = _attributes(data)
    names = _channels(attributes["channels"])
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    planes = {name: [] for name in names}
    block = ROWS[attributes["compression"][0]]
    for offset in struct.unpack_from(f"<{(height + block - 1) // block}Q", data, at):
        first, size = struct.unpack_from("<ii", data, offset)
        count = min(block, height - (first - top))
        packed = data[offset + 8:offset + 8 + size]
        whole = count * width * 4 * len(names)
        raw = packed if size == whole else exr._unpredict(zlib.decompress(packed))
        for line in range(count):
            for index, name in enumerate(names):
                start = (line * len(names) + index) * 4 * width
                planes[name].append(struct.unpack_from(f"<{width}f", raw, start))
    return planes


def half(value):
    """The half nearest to a float."""
    return struct.unpack("<e", struct.pack("<e", value))[0]
