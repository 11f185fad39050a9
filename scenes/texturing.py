"""Textures for the scenes' build.py scripts: small images made of numbers, and where they go.

Images are arrays of rows from the bottom to the top, RGB or RGBA, as displays have them (sRGB, 0 to
1). Texture coordinates are in images: u = 1 is one image to the right.
"""

import math

import bpy
import numpy


def image(name, values):
    """A packed image of an array (height, width, 3 or 4)."""
    height, width, channels = values.shape
    made = bpy.data.images.new(name, width, height, alpha=channels == 4)
    pixels = numpy.ones((height, width, 4), numpy.float32)
    pixels[:, :, :channels] = numpy.clip(values, 0.0, 1.0)
    made.pixels.foreach_set(pixels.ravel())
    made.update()
    made.pack()
    return made


def textured(name, picture, masked=False):
    """A Lambertian surface with `picture` as its albedo; `masked`: none where alpha is below 1/2."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = picture
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    if not masked:
        shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
        tree.links.new(texture.outputs["Color"], shader.inputs["Color"])
    else:
        shader = tree.nodes.new("ShaderNodeBsdfPrincipled")
        shader.inputs["Roughness"].default_value = 1.0
        tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])
        tree.links.new(texture.outputs["Alpha"], shader.inputs["Alpha"])
        material.blend_method, material.alpha_threshold = "CLIP", 0.5
    tree.links.new(shader.outputs["BSDF"], output.inputs["Surface"])
    return material


def _set_uvs(mesh, of_loop):
    """Calls of_loop(polygon, position) for every corner."""
    layer = mesh.uv_layers.new(name="UVMap")
    for polygon in mesh.polygons:
        for loop in polygon.loop_indices:
            position = mesh.vertices[mesh.loops[loop].vertex_index].co
            layer.data[loop].uv = of_loop(polygon, position)
    return mesh


def box_uvs(mesh, metres):
    """Each face seen along the axis it faces most; walls upright, `metres` across an image."""
    def of_loop(polygon, p):
        x, y, z = (abs(component) for component in polygon.normal)
        if z >= x and z >= y:
            return p.x / metres, p.y / metres
        return (p.y if x > y else p.x) / metres, p.z / metres
    return _set_uvs(mesh, of_loop)


def round_uvs(mesh, times_round, metres):
    """For what was revolved about Z: the image `times_round` times round, upright."""
    def of_loop(polygon, p):
        middle = math.atan2(polygon.center.y, polygon.center.x)
        angle = math.atan2(p.y, p.x)
        # The corner's angle on the polygon's side of the seam.
        angle += 2 * math.pi * round((middle - angle) / (2 * math.pi))
        return times_round * angle / (2 * math.pi), p.z / metres
    return _set_uvs(mesh, of_loop)


def noise(dice, size, cells):
    """Smooth noise in [0, 1], (size, size), that repeats; `cells` bumps across."""
    knots = dice.random_sample((cells, cells))
    at = numpy.arange(size) * cells / size
    low = at.astype(int)
    share = at - low
    share = share * share * (3.0 - 2.0 * share)
    high = (low + 1) % cells
    columns = knots[:, low] * (1.0 - share) + knots[:, high] * share
    return columns[low] * (1.0 - share)[:, None] + columns[high] * share[:, None]


def mixed(a, b, share):
    """Colours between a and b, one for each value of `share`."""
    return numpy.asarray(a) * (1.0 - share[..., None]) + numpy.asarray(b) * share[..., None]
