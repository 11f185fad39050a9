"""Renders a scene file with Blender's Cycles, to compare with: an independent renderer.

    blender --background --factory-startup --python-exit-code 3 --python scenes/cycles.py -- JOB.json

The scene comes in through Blender's own glTF importer, so that nothing is shared with occlab's
loader, rasteriser or tracer. Surfaces are Diffuse BSDFs of the base colour. Nothing but the probe
lights them, directly; no filter, clamp, denoiser or adaptive sampling. JOB.json:

| key | what |
|---|---|
| `scene` | a .glb |
| `camera` | a camera of it, by name |
| `width`, `height` | pixels |
| `seeds` | one image for each and each kind |
| `output` | a folder that exists |
| `light` | absent, or `probe` (an equirect EXR whose texels are looked up as they are), `rotation_degrees` (FORMAT.md) and `samples` a pixel: `light_SEED.exr`, radiance |
| `ao` | absent, or `distance` (scene units) and `samples`: `ao_SEED.exr`, cosine-weighted ambient occlusion with a hard cut-off |

Images are 32-bit float RGB; where no surface is seen they are 0. `cycles.json` in the output folder
appears last: Blender's version and for each kind the wall times, one an image, as Cycles counts them:
`seconds`, of rendering, and `prepare_seconds`, of what comes before (synchronising, building the BVH
and the probe's table). Exit code 2: the job cannot be rendered rightly; the reason is on stderr.
"""

import json
import math
import pathlib
import sys

import bpy
import numpy
from mathutils import Matrix

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import glb  # noqa: E402
from carried import Refusal, source  # noqa: E402


def import_scene(path):
    """Replaces everything by the meshes and cameras of a .glb; its lights are left out."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if not hasattr(numpy, "bool"):
        numpy.bool = bool  # Blender 3.4's importer uses this alias, which NumPy 1.24 dropped
    bpy.ops.import_scene.gltf(filepath=str(path))
    for thing in list(bpy.data.objects):
        if thing.type == "LIGHT":
            bpy.data.objects.remove(thing)
    for thing in bpy.data.objects:
        if thing.type == "MESH":
            # Cycles moves the start of shadow rays on coarse smooth surfaces: not the truth asked for.
            thing.cycles.shadow_terminator_geometry_offset = 0.0
            thing.cycles.shadow_terminator_offset = 0.0


def use_camera(path, name):
    """The importer fits the field of view to the file's aspect; occlab keeps the vertical one."""
    document, _ = glb.parse(pathlib.Path(path).read_bytes())
    lenses = {camera.get("name"): camera for camera in document.get("cameras", [])}
    placed = [thing for thing in bpy.data.objects if thing.type == "CAMERA"
              and name in (thing.data.name, thing.name)]
    if name not in lenses or len(placed) != 1:
        raise Refusal(f"{path}: {len(placed)} cameras are called '{name}'; the file's: "
                      + ", ".join(map(str, lenses)))
    camera = placed[0].data
    camera.sensor_fit = "VERTICAL"
    camera.angle = lenses[name]["perspective"]["yfov"]
    bpy.context.scene.camera = placed[0]


def turn_scene(degrees):
    """Turns everything about the vertical, counter-clockwise from above.

    A turned scene under the probe as it is, not the other way round: through a Mapping node Cycles'
    table for importance sampling no longer falls onto the texels, and the noise is no longer normal.
    """
    turn = Matrix.Rotation(math.radians(degrees), 4, "Z")
    bpy.context.view_layer.update()
    for thing in bpy.data.objects:
        if thing.parent is None:
            thing.matrix_world = turn @ thing.matrix_world
    bpy.context.view_layer.update()


def configure(width, height):
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    # Blender 3.4 would go on with the first picture's samples and seed.
    render.use_persistent_data = False
    render.use_compositing = render.use_sequencer = render.use_motion_blur = False
    render.film_transparent = False
    render.dither_intensity = 0.0
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_mode = "RGB"
    render.image_settings.color_depth = "32"
    render.image_settings.exr_codec = "ZIP"

    cycles.device = "CPU"
    cycles.use_denoising = cycles.use_adaptive_sampling = cycles.use_fast_gi = False
    cycles.sampling_pattern = "SOBOL"
    cycles.light_sampling_threshold = 0.0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = 0
    cycles.transmission_bounces = cycles.volume_bounces = 0
    cycles.transparent_max_bounces = 64  # holes of alpha masks, one behind the other
    cycles.pixel_filter_type = "BLACKMAN_HARRIS"
    cycles.filter_width = 0.01  # pixel centres, as the G-buffer
    cycles.film_exposure = 1.0
    cycles.use_auto_tile = False


def make_world(light):
    """A world that shows the probe's texels and that the camera does not see."""
    world = bpy.data.worlds.new("probe")
    bpy.context.scene.world = world
    world.use_nodes = True
    world.cycles_visibility.camera = False
    world.cycles.sampling_method = "AUTOMATIC"
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    output, background = nodes.new("ShaderNodeOutputWorld"), nodes.new("ShaderNodeBackground")
    links.new(background.outputs[0], output.inputs["Surface"])
    background.inputs["Strength"].default_value = 1.0 if light else 0.0
    if not light:
        return
    picture = nodes.new("ShaderNodeTexEnvironment")
    picture.image = bpy.data.images.load(str(light["probe"]))
    picture.image.colorspace_settings.name = "Non-Color"
    picture.interpolation = "Closest"
    picture.projection = "EQUIRECTANGULAR"
    links.new(picture.outputs["Color"], background.inputs["Color"])


def used_materials():
    """Every slot's material; a surface without one gets glTF's default, white."""
    for thing in bpy.data.objects:
        if thing.type == "MESH":
            if not thing.data.materials:
                thing.data.materials.append(None)
            for i, material in enumerate(thing.data.materials):
                if material is None:
                    material = bpy.data.materials.new("default")
                    material.use_nodes = True
                    material.node_tree.nodes["Principled BSDF"].inputs[
                        "Base Color"].default_value = (1.0, 1.0, 1.0, 1.0)
                    thing.data.materials[i] = material
    return {material.name: material for thing in bpy.data.objects if thing.type == "MESH"
            for material in thing.data.materials}.values()


def make_diffuse(material):
    """The importer's Principled BSDF as a Diffuse BSDF of its base colour."""
    nodes, links = material.node_tree.nodes, material.node_tree.links
    surface = material.node_tree.get_output_node("CYCLES").inputs["Surface"]
    shader, _ = source(surface)
    if shader is None or shader.type != "BSDF_PRINCIPLED":
        raise Refusal(f"material '{material.name}': its surface is "
                      f"{shader.bl_label if shader else 'nothing'}, not a Principled BSDF")
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    colour = shader.inputs["Base Color"]
    diffuse.inputs["Roughness"].default_value = 0.0
    diffuse.inputs["Color"].default_value = colour.default_value
    _, output = source(colour)
    if output is not None:
        links.new(output, diffuse.inputs["Color"])
    _, alpha = source(shader.inputs["Alpha"])  # 0 or 1: the importer has applied the cutoff
    if material.blend_method == "CLIP" and alpha is not None:
        mix, hole = nodes.new("ShaderNodeMixShader"), nodes.new("ShaderNodeBsdfTransparent")
        links.new(alpha, mix.inputs["Fac"])
        links.new(hole.outputs[0], mix.inputs[1])
        links.new(diffuse.outputs[0], mix.inputs[2])
        diffuse = mix
    links.new(diffuse.outputs[0], surface)


def make_occlusion(material, distance):
    """A surface that shines with its ambient occlusion and lights nothing. To Cycles' node holes of
    an alpha mask are blockers."""
    nodes, links = material.node_tree.nodes, material.node_tree.links
    occlusion, emission = nodes.new("ShaderNodeAmbientOcclusion"), nodes.new("ShaderNodeEmission")
    occlusion.samples = 1  # for each of the pixel's samples
    occlusion.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    occlusion.inputs["Distance"].default_value = distance
    emission.inputs["Strength"].default_value = 1.0
    links.new(occlusion.outputs["Color"], emission.inputs["Color"])
    links.new(emission.outputs[0], material.node_tree.get_output_node("CYCLES").inputs["Surface"])
    material.cycles.sample_as_light = False


def exr_attributes(path):
    """The header of a single-part EXR, as texts."""
    data, at, found = path.read_bytes(), 8, {}
    while data[at]:
        name, kind, rest = data[at:at + 512].split(b"\0", 2)
        start = at + len(name) + len(kind) + 6
        size = int.from_bytes(rest[:4], "little")
        found[name.decode()] = data[start:start + size].decode("latin-1")
        at = start + size
    return found


def seconds(clock):
    """Of [hours:]minutes:seconds.hundredths."""
    total = 0.0
    for part in clock.split(":"):
        total = 60.0 * total + float(part)
    return total


def render_seeds(kind, samples, seeds, folder):
    cycles = bpy.context.scene.cycles
    cycles.samples = samples
    times = {"seconds": [], "prepare_seconds": []}
    for seed in seeds:
        cycles.seed = seed
        path = folder / f"{kind}_{seed}.exr"
        bpy.ops.render.render()
        bpy.data.images["Render Result"].save_render(str(path))
        facts = {key.rsplit(".", 1)[-1]: value for key, value in exr_attributes(path).items()
                 if key.startswith("cycles.")}
        if int(facts["samples"]) != samples:
            raise RuntimeError(f"Cycles took {facts['samples']} samples a pixel, not {samples}")
        times["seconds"].append(seconds(facts["render_time"]))
        times["prepare_seconds"].append(seconds(facts["synchronization_time"]))
    return times


def run(job):
    folder = pathlib.Path(job["output"])
    import_scene(job["scene"])
    use_camera(job["scene"], job["camera"])
    configure(job["width"], job["height"])
    materials = used_materials()
    results = {"version": bpy.app.version_string}
    if job.get("light"):
        turn_scene(-job["light"]["rotation_degrees"])
        make_world(job["light"])
        for material in materials:
            make_diffuse(material)
        results["light"] = render_seeds("light", job["light"]["samples"], job["seeds"], folder)
    if job.get("ao"):
        make_world(None)
        for material in materials:
            make_occlusion(material, job["ao"]["distance"])
        results["ao"] = render_seeds("ao", job["ao"]["samples"], job["seeds"], folder)
    (folder / "cycles.json").write_text(json.dumps(results), encoding="utf-8")


def main():
    """Renders the job whose file is named after `--`."""
    try:
        split = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
        if len(sys.argv) != split + 2:
            raise Refusal("usage: blender ... --python scenes/cycles.py -- JOB.json")
        run(json.loads(pathlib.Path(sys.argv[-1]).read_text(encoding="utf-8")))
    except Refusal as refusal:
        print(f"occlab cycles: error: {refusal}", file=sys.stderr)
        sys.stderr.flush()
        sys.exit(2)


if __name__ == "__main__":
    main()
