"""Small scenes of few shapes as .glb files that carry their expected values (../FORMAT.md).
Standard library only."""

import array
import json
import math
import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import glb  # noqa: E402

FLOAT, UNSIGNED_INT = 5126, 5125


def add(*vectors):
    return tuple(map(sum, zip(*vectors)))


def scale(factor, v):
    return tuple(factor * x for x in v)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def length(v):
    return math.sqrt(dot(v, v))


def unit(v):
    return scale(1.0 / length(v), v)


def quad(corner, u, v):
    """A parallelogram whose normal is u x v: (positions, normals, indices)."""
    positions = [corner, add(corner, u), add(corner, u, v), add(corner, v)]
    return positions, [unit(cross(u, v))] * 4, [0, 1, 2, 0, 2, 3]


def revolution(profile, rings, segments, normal, closed_ends=False):
    """A surface of revolution about +Z through profile(t) = (radius, height), t in [0, 1].

    normal(t, radius, height) = (outward, upward) part of the unit normal there.
    """
    positions, normals, indices = [], [], []
    for i in range(rings + 1):
        radius, height = profile(i / rings)
        out, up = normal(i / rings, radius, height)
        for j in range(segments):
            phi = 2.0 * math.pi * j / segments
            positions.append((radius * math.cos(phi), radius * math.sin(phi), height))
            normals.append((out * math.cos(phi), out * math.sin(phi), up))
    for i in range(rings):
        for j in range(segments):
            a, b = i * segments + j, i * segments + (j + 1) % segments
            corners = [a, b, b + segments, a, b + segments, a + segments]
            for t in (corners[:3], corners[3:]):
                # A ring of radius 0 is one point: no triangle without area.
                if len({positions[k] for k in t}) == 3:
                    indices += t
    return positions, normals, indices


RINGS = 48


def facet_share():
    """Facets of sphere_part(radius 1) lie between this and 1 from the centre."""
    return math.cos(0.5 * math.pi / RINGS) ** 2


def sphere_part(centre, radius, first=0.0, last=math.pi, inward=False):
    """The part of a sphere between two polar angles from +Z. Its facets lie on both sides of the
    sphere, within (1 - facet_share())/2 of the radius."""
    sign = -1.0 if inward else 1.0
    r = radius * 2.0 / (1.0 + facet_share())

    def angle(t):
        return first + t * (last - first)

    rings = max(2, round(RINGS * (last - first) / math.pi))
    positions, normals, indices = revolution(
        lambda t: (abs(r * math.sin(angle(t))) if 0.0 < angle(t) < math.pi else 0.0,
                   r * math.cos(angle(t))),
        rings, 2 * RINGS,
        lambda t, *_: (sign * math.sin(angle(t)), sign * math.cos(angle(t))))
    return [add(p, centre) for p in positions], normals, indices


def looking(eye, forward, up):
    """world_from_camera, column by column, of a camera that looks along `forward`."""
    z = scale(-1.0, unit(forward))
    x = unit(cross(up, z))
    y = cross(z, x)
    return [*x, 0.0, *y, 0.0, *z, 0.0, *eye, 1.0]


def camera_at(eye, target, up=(0.0, 0.0, 1.0)):
    return looking(eye, add(target, scale(-1.0, eye)), up)


class SceneFile:
    """Meshes, cameras, lights and cases, written as one .glb."""

    def __init__(self):
        self.meshes, self.cameras, self.lights, self.cases = [], [], [], []

    def mesh(self, mesh):
        self.meshes.append(mesh)
        return self

    def camera(self, name, matrix, yfov, znear=0.05, zfar=200.0):
        self.cameras.append((name, matrix, yfov, znear, zfar))

    def sun(self, name, matrix, colour):
        self.lights.append((name, matrix, colour))

    def lift(self):
        """How far above a surface rays start: 1e-4 of half the bounding box's diagonal."""
        points = [p for positions, _, _ in self.meshes for p in positions]
        low = [min(p[k] for p in points) for k in range(3)]
        high = [max(p[k] for p in points) for k in range(3)]
        return 0.5e-4 * math.dist(low, high)

    def case(self, name, source, methods, quantity, expected=None, bound=0.0, why="", **keys):
        """`expected` may be a number; `keys` are a case's further keys, `set` as `settings`."""
        case = {"name": name, "source": source, "methods": list(methods), "quantity": quantity}
        if "settings" in keys:
            case["set"] = keys.pop("settings")
        case["sky"] = keys.pop("sky", {"constant": [1, 1, 1]})
        case.update(keys)
        if expected is not None:
            case["expected"] = list(expected) if hasattr(expected, "__len__") else [expected]
        case["bound"] = bound
        if bound:
            case["bound_source"] = why
        self.cases.append(case)

    def write(self, path):
        document = {
            "asset": {"version": "2.0", "generator": "scenes/analytic/build.py"},
            "materials": [{"name": "white", "pbrMetallicRoughness": {
                "baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0}}],
            "meshes": [], "accessors": [], "bufferViews": [], "nodes": [], "cameras": []}
        parts = []

        def accessor(values, component, kind, **more):
            data = array.array(glb.COMPONENTS[component], values).tobytes()
            document["bufferViews"].append({"buffer": 0, "byteOffset": sum(map(len, parts)),
                                            "byteLength": len(data)})
            parts.append(data)
            document["accessors"].append({
                "bufferView": len(document["bufferViews"]) - 1, "componentType": component,
                "count": len(values) // glb.WIDTHS[kind], "type": kind, **more})
            return len(document["accessors"]) - 1

        for positions, normals, indices in self.meshes:
            flat = array.array("f", [x for p in positions for x in p])
            document["meshes"].append({"primitives": [{
                "material": 0,
                "attributes": {
                    "POSITION": accessor(flat, FLOAT, "VEC3",
                                         min=[min(flat[k::3]) for k in range(3)],
                                         max=[max(flat[k::3]) for k in range(3)]),
                    "NORMAL": accessor([x for n in normals for x in n], FLOAT, "VEC3")},
                "indices": accessor(indices, UNSIGNED_INT, "SCALAR")}]})
            document["nodes"].append({"mesh": len(document["meshes"]) - 1})
        for name, matrix, yfov, znear, zfar in self.cameras:
            document["cameras"].append({"type": "perspective", "perspective": {
                "yfov": yfov, "znear": znear, "zfar": zfar}})
            document["nodes"].append({"name": name, "camera": len(document["cameras"]) - 1,
                                      "matrix": matrix})
        for index, (name, matrix, colour) in enumerate(self.lights):
            document.setdefault("extensionsUsed", ["KHR_lights_punctual"])
            document.setdefault("extensions", {"KHR_lights_punctual": {"lights": []}})[
                "KHR_lights_punctual"]["lights"].append(
                    {"type": "directional", "color": colour, "intensity": 1.0})
            document["nodes"].append({"name": name, "matrix": matrix, "extensions": {
                "KHR_lights_punctual": {"light": index}}})
        document["buffers"] = [{"byteLength": sum(map(len, parts))}]
        document["scenes"] = [{"nodes": list(range(len(document["nodes"]))), "extras": {
            "occlab_verify": {"format": 1, "cases": self.cases}}}]
        document["scene"] = 0
        path.write_bytes(glb.unparse(document, b"".join(parts)))
        print(f"{path.name}: {len(self.cases)} cases, {path.stat().st_size} bytes",
              json.dumps(sorted({m for case in self.cases for m in case['methods']})))
