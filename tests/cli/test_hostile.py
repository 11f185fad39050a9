"""Hostile files by the command line: refused with exit code 2, and names that stay names in shells,
shaders and pages."""

import json
import os
import re
import struct
import zlib

from support import SMALL_EXPERIMENT, THREE_BOXES, CliTest, occlab, probe_with, scene_with

HOSTILE = "a</script><script>alert(1)</script>'\"; touch pwned; $(touch pwned) `touch pwned` \\input{x}"


def png(width, height):
    """A PNG whose header claims a size that its few pixels do not have."""
    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data
                + struct.pack(">I", zlib.crc32(kind + data)))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(bytes(100))) + chunk(b"IEND", b""))


def render(case, scene, *arguments, **settings):
    return occlab("render", "--scene", scene, "--method", "ssao", "--resolution", "16", "16", "-o",
                  case.folder / "out.exr", *arguments, **settings)


class Limits(CliTest):
    def test_the_environment_sets_them(self):
        finished = render(self, THREE_BOXES, env={"OCCLAB_LIMITS": "triangles=37"})
        self.assertEqual(finished.returncode, 2)
        self.assertIn("accepted: up to 37 (limit triangles", finished.stderr)
        self.assertEqual(len(finished.stderr.splitlines()), 1)
        finished = render(self, THREE_BOXES, env={"OCCLAB_LIMITS": "triangels=37"})
        self.assertEqual(finished.returncode, 2)
        self.assertIn("did you mean 'triangles'", finished.stderr)

    def test_a_huge_texture(self):
        def change(document, blob):
            image = png(10000, 10000)
            view = {"buffer": 0, "byteOffset": len(blob), "byteLength": len(image)}
            blob.extend(image + bytes(-len(image) % 4))
            document["buffers"][0]["byteLength"] = len(blob)
            document["bufferViews"].append(view)
            document["images"] = [{"bufferView": len(document["bufferViews"]) - 1}]
            document["textures"] = [{"source": 0}]
            material = document["materials"][0].setdefault("pbrMetallicRoughness", {})
            material["baseColorTexture"] = {"index": 0}
        finished = render(self, scene_with(self.folder / "huge.glb", change))
        self.assertEqual(finished.returncode, 2)
        self.assertIn("10000x10000", finished.stderr)


class Paths(CliTest):
    def test_an_experiment_file_names_what_is_beside_it(self):
        inner = self.folder / "inner"
        inner.mkdir()
        probe_with(self.folder / "probe.exr", 1.0)
        probe_with(inner / "probe.exr", 1.0)
        experiment = inner / "small.toml"
        text = SMALL_EXPERIMENT.replace('"sky_sun"', '"%s"')
        for source, good in (("probe.exr", True), ("../inner/probe.exr", True),
                             ("../probe.exr", False), (str(self.folder / "probe.exr"), False)):
            with self.subTest(source):
                experiment.write_text(text % source, encoding="utf-8")
                arguments = ("run", experiment, "--out", self.folder / "results")
                if good:
                    self.good(*arguments)
                    continue
                self.refused_run(2, ["small.toml:9", "lies outside the folder"], experiment)
                self.good(*arguments, env={"OCCLAB_ALLOW_OUTSIDE": str(self.folder)})
        # What the user types is the user's choice.
        self.good("run", experiment, "--out", self.folder / "results", "--set",
                  f"probe.source={self.folder / 'probe.exr'}")

    def test_a_scene_names_the_probe_beside_it(self):
        inner = self.folder / "inner"
        inner.mkdir()
        probe_with(self.folder / "probe.exr", 1.0)

        def change(document, _):
            document["scenes"][0].setdefault("extras", {})["occlab"] = {
                "format": 1, "world": {"probe": "../probe.exr"}}
        scene = scene_with(inner / "scene.glb", change)
        finished = render(self, scene)
        self.assertEqual(finished.returncode, 2)
        self.assertIn("lies outside the folder", finished.stderr)
        finished = render(self, scene, env={"OCCLAB_ALLOW_OUTSIDE": str(self.folder)})
        self.assertEqual(finished.returncode, 0, finished.stderr)


class Names(CliTest):
    def scene(self):
        def change(document, _):
            for part in ("nodes", "meshes", "materials", "cameras"):
                for i, entry in enumerate(document.get(part, [])):
                    entry["name"] = f"{HOSTILE} {i}"
        return scene_with(self.folder / "names.glb", change)

    def test_a_run_and_its_report(self):
        experiment = self.write("names.toml", SMALL_EXPERIMENT.replace(
            'title = "Small"', "title = '''" + HOSTILE + "'''"))
        results = self.folder / "results"
        self.good("run", experiment, "--out", results, "--set", f"scene.source={self.scene()}",
                  cwd=self.folder)
        self.good("report", results, cwd=self.folder)
        page = (results / "report/index.html").read_text(encoding="utf-8")
        self.assertNotIn("<script>alert", page)
        data = re.search(r'id="occlab-data"[^>]*>(.*?)</script>', page, re.DOTALL).group(1)
        self.assertNotIn("<", data)
        title = json.loads(data)["run"]["configuration"]  # TOML, which escapes its quotes
        self.assertIn("</script><script>alert(1)</script>", title)
        for table in results.glob("tables/*.tex"):
            self.assertNotIn("\\input{x}", table.read_text(encoding="utf-8"))
        self.assertFalse(list(self.folder.rglob("pwned")))

    def test_a_shader_gets_declared_words_only(self):
        for setting in ("weight=binary\n#error", "weight=0);discard;(", "samples=4\n#error",
                        "lambda_per_world=1;}"):
            finished = render(self, THREE_BOXES, "--set", setting)
            self.assertEqual(finished.returncode, 2, setting)
            self.assertIn("accepted is", finished.stderr)

    def test_blender_gets_paths_as_arguments(self):
        blender = self.write("blender", '#!/bin/sh\nfor a; do echo "$a"; done >"%s"\nexit 2\n'
                             % (self.folder / "arguments"))
        os.chmod(blender, 0o755)
        name = "a; touch pwned; $(touch pwned) `touch pwned`.blend"
        self.write(name, "")
        finished = occlab("export", name, "-o", "b; touch pwned.glb", "--blender", blender,
                          cwd=self.folder)
        self.assertEqual(finished.returncode, 2, finished.stderr)
        self.assertIn("not exported", finished.stderr)
        arguments = (self.folder / "arguments").read_text(encoding="utf-8").splitlines()
        self.assertIn(str(self.folder / name), arguments)
        self.assertIn(str(self.folder / "b; touch pwned.glb"), arguments)
        self.assertFalse(list(self.folder.rglob("pwned")))


class Terminal(CliTest):
    def test_no_name_moves_the_cursor(self):
        def change(document, _):
            document["nodes"][0]["name"] = "\x1b[2J"
            document["meshes"][0]["name"] = "\x1b[2J"
        finished = render(self, scene_with(self.folder / "escape.glb", change))
        self.assertEqual(finished.returncode, 2)
        self.assertIn("control character", finished.stderr)
        self.assertNotIn("\x1b", finished.stderr)
