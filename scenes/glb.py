"""Reading and writing binary glTF containers, for export.py and the tests. Standard library only.

glTF 2.0, 4.4 (GLB file format) and 3.6 (binary data):
https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
"""

import array
import hashlib
import json
import struct

COMPONENTS = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", 5126: "f"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


def parse(data):
    """(document, blob) of a .glb's bytes."""
    magic, version, length = struct.unpack_from("<4sII", data)
    if magic != b"glTF" or version != 2 or length != len(data):
        raise ValueError("not a complete binary glTF 2.0 file")
    document, blob, at = None, b"", 12
    while at < length:
        size, kind = struct.unpack_from("<I4s", data, at)
        chunk = data[at + 8:at + 8 + size]
        if kind == b"JSON":
            document = json.loads(chunk)
        elif kind == b"BIN\0":
            blob = chunk
        at += 8 + size
    return document, blob


def unparse(document, blob):
    """The bytes of a .glb."""
    text = json.dumps(document, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    blob += b"\0" * (-len(blob) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    if blob:
        chunks += struct.pack("<I4s", len(blob), b"BIN\0") + blob
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def accessor_bytes(document, blob, index):
    """An accessor's elements, tightly packed (Blender neither interleaves nor stores sparsely)."""
    accessor = document["accessors"][index]
    view = document["bufferViews"][accessor["bufferView"]]
    if "byteStride" in view or "sparse" in accessor:
        raise ValueError("interleaved or sparse accessor")
    size = (struct.calcsize(COMPONENTS[accessor["componentType"]]) * WIDTHS[accessor["type"]]
            * accessor["count"])
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    return blob[start:start + size]


def view_bytes(document, blob, index):
    """The bytes of a buffer view, such as an image's."""
    view = document["bufferViews"][index]
    start = view.get("byteOffset", 0)
    return blob[start:start + view["byteLength"]]


def accessor_values(document, blob, index):
    """An accessor as one flat array."""
    values = array.array(COMPONENTS[document["accessors"][index]["componentType"]])
    values.frombytes(accessor_bytes(document, blob, index))
    return values


def multiply(a, b):
    """Product of 4x4 matrices, each a list of rows."""
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def local_matrix(node):
    if "matrix" in node:
        return [[node["matrix"][4 * j + i] for j in range(4)] for i in range(4)]
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    sx, sy, sz = node.get("scale", (1, 1, 1))
    tx, ty, tz = node.get("translation", (0, 0, 0))
    return [
        [(1 - 2 * (y * y + z * z)) * sx, 2 * (x * y - z * w) * sy, 2 * (x * z + y * w) * sz, tx],
        [2 * (x * y + z * w) * sx, (1 - 2 * (x * x + z * z)) * sy, 2 * (y * z - x * w) * sz, ty],
        [2 * (x * z - y * w) * sx, 2 * (y * z + x * w) * sy, (1 - 2 * (x * x + y * y)) * sz, tz],
        [0, 0, 0, 1]]


def placed_nodes(document):
    """(node, world_from_node) of every node of the default scene, parents first."""
    identity = [[float(i == j) for j in range(4)] for i in range(4)]
    scene = document["scenes"][document.get("scene", 0)]
    waiting = [(index, identity) for index in reversed(scene.get("nodes", []))]
    while waiting:
        index, parent = waiting.pop()
        node = document["nodes"][index]
        matrix = multiply(parent, local_matrix(node))
        yield node, matrix
        waiting += [(child, matrix) for child in reversed(node.get("children", []))]


def mesh_triangles(document, mesh_index):
    return sum(document["accessors"][primitive["indices"]]["count"] // 3
               for primitive in document["meshes"][mesh_index]["primitives"])


def triangle_count(document):
    """Triangles in the default scene, instances counted."""
    return sum(mesh_triangles(document, node["mesh"])
               for node, _ in placed_nodes(document) if "mesh" in node)


def _fingerprint(document, blob, mesh):
    """Equal for meshes with equal vertices, indices and materials, whatever their names."""
    digest = hashlib.sha256()
    for primitive in mesh["primitives"]:
        stripped = {key: value for key, value in primitive.items()
                    if key not in ("attributes", "indices")}
        digest.update(json.dumps(stripped, sort_keys=True).encode())
        for name, index in [*sorted(primitive["attributes"].items()),
                            ("indices", primitive["indices"])]:
            accessor = document["accessors"][index]
            data = accessor_bytes(document, blob, index)
            digest.update(f"{name} {accessor['componentType']} {accessor['type']} "
                          f"{len(data)}:".encode())
            digest.update(data)
    return digest.digest()


def share_equal_meshes(document, blob):
    """Stores equal meshes once, and drops the data that nothing uses any more.

    Blender writes a copy of the mesh for every object that has modifiers. Changes `document`;
    returns the new blob.
    """
    first, kept, meshes = {}, {}, []
    for index, mesh in enumerate(document.get("meshes", [])):
        same = first.setdefault(_fingerprint(document, blob, mesh), len(meshes))
        if same == len(meshes):
            meshes.append(mesh)
        kept[index] = same
    for node in document.get("nodes", []):
        if "mesh" in node:
            node["mesh"] = kept[node["mesh"]]
    if meshes:
        document["meshes"] = meshes

    accessors, views, parts = [], [], []

    def keep_view(index):
        view = dict(document["bufferViews"][index])
        start = view.get("byteOffset", 0)
        view["byteOffset"] = sum(map(len, parts))
        data = blob[start:start + view["byteLength"]]
        parts.append(data + b"\0" * (-len(data) % 4))
        views.append(view)
        return len(views) - 1

    moved = {}

    def keep_accessor(index):
        if index not in moved:
            accessor = dict(document["accessors"][index])
            accessor["bufferView"] = keep_view(accessor["bufferView"])
            moved[index] = len(accessors)
            accessors.append(accessor)
        return moved[index]

    for mesh in meshes:
        for primitive in mesh["primitives"]:
            primitive["attributes"] = {name: keep_accessor(index)
                                       for name, index in primitive["attributes"].items()}
            primitive["indices"] = keep_accessor(primitive["indices"])
    for image in document.get("images", []):
        if "bufferView" in image:
            image["bufferView"] = keep_view(image["bufferView"])
    document["accessors"], document["bufferViews"] = accessors, views
    result = b"".join(parts)
    document["buffers"] = [{"byteLength": len(result)}]
    return result
