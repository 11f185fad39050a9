"""Compares the exported geometry with what Blender would render."""

import math

import bpy
import numpy

import glb
import surfaces
from carried import Refusal


def measure(triangle_sets):
    """Count, area and area-weighted centroid (glTF axes) of (local triangles, world matrix) pairs.

    Three numbers that a lost object, a sheared matrix or a misplaced instance would change.
    """
    count, area, moment = 0, 0.0, numpy.zeros(3)
    for triangles, matrix in triangle_sets:
        world = triangles @ matrix[:3, :3].T + matrix[:3, 3]
        areas = 0.5 * numpy.linalg.norm(
            numpy.cross(world[:, 1] - world[:, 0], world[:, 2] - world[:, 0]), axis=1)
        count += len(world)
        area += areas.sum()
        moment += (areas[:, None] * world.mean(axis=1)).sum(axis=0)
    return count, area, moment / area if area > 0 else moment


def blender_triangles():
    """What Blender would render, as `measure` takes it."""
    to_gltf = numpy.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], float)
    cache = {}
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        thing = instance.object
        if thing.type not in surfaces.KINDS or not instance.show_self:
            continue
        key = thing.original.name_full
        if key not in cache:
            mesh = thing.to_mesh()
            mesh.calc_loop_triangles()
            points = numpy.empty(3 * len(mesh.vertices), numpy.float32)
            corners = numpy.empty(3 * len(mesh.loop_triangles), numpy.int32)
            mesh.vertices.foreach_get("co", points)
            mesh.loop_triangles.foreach_get("vertices", corners)
            cache[key] = points.reshape(-1, 3).astype(float)[corners.reshape(-1, 3)]
            thing.to_mesh_clear()
        yield cache[key], to_gltf @ numpy.array(instance.matrix_world, float)


def gltf_triangles(document, blob):
    for node, matrix in glb.placed_nodes(document):
        if "mesh" not in node:
            continue
        for primitive in document["meshes"][node["mesh"]]["primitives"]:
            points = numpy.array(glb.accessor_values(document, blob,
                                                     primitive["attributes"]["POSITION"]))
            corners = numpy.array(glb.accessor_values(document, blob, primitive["indices"]))
            yield (points.reshape(-1, 3).astype(float)[corners.reshape(-1, 3)],
                   numpy.array(matrix, float))


def check_nothing_lost(expected, document, blob):
    found = measure(gltf_triangles(document, blob))
    size = math.sqrt(expected[1]) + numpy.abs(expected[2]).max()
    if found[0] != expected[0] or abs(found[1] - expected[1]) > 1e-4 * expected[1] or (
            numpy.abs(found[2] - expected[2]).max() > 1e-4 * size):
        raise Refusal(
            f"the exported geometry is not the rendered one: {found[0]} triangles of area "
            f"{found[1]:.6g}, where Blender renders {expected[0]} of area {expected[1]:.6g}. "
            "Usual causes: an object sheared by its parent's unequal scale (apply the scale), or "
            "an object hidden inside an instanced collection")
