"""`occlab export` of a file that Blender made a moment ago."""

import os
import pathlib
import shutil
import subprocess
import sys

from support import CliTest, glb, occlab

BLENDER = shutil.which("blender")
MODEL = """
import bpy
if {camera} is False:
    bpy.data.objects.remove(bpy.data.objects["Camera"])
bpy.ops.wm.save_as_mainfile(filepath={path!r})
"""


class Export(CliTest):
    def setUp(self):
        super().setUp()
        if BLENDER:
            return
        if os.environ.get("OCCLAB_REQUIRE_BLENDER") == "1":
            self.fail("OCCLAB_REQUIRE_BLENDER=1 and blender is not on the PATH")
        self.skipTest("blender is not on the PATH")

    def blend(self, name, camera=True):
        """Blender's start-up scene: a cube, a point light, a camera."""
        path = self.folder / name
        subprocess.run([BLENDER, "--background", "--factory-startup", "--python-exit-code", "3",
                        "--python-expr", MODEL.format(camera=camera, path=str(path))],
                       check=True, capture_output=True, timeout=120)
        return path

    def fails(self, code, words, *arguments, **settings):
        before = {path.name for path in self.folder.iterdir()}
        finished = self.run_export(*arguments, **settings)
        self.assertEqual(finished.returncode, code, finished.stderr)
        last = finished.stderr.splitlines()[-1]
        self.assertTrue(last.startswith("occlab: "), finished.stderr)
        for word in words:
            self.assertIn(str(word), finished.stderr)
        self.assertEqual({path.name for path in self.folder.iterdir()}, before)
        return last

    @staticmethod
    def run_export(*arguments, **settings):
        return occlab("export", *arguments, **settings)

    def test_it_can_be_rendered(self):
        scene = self.folder / "cube.glb"
        printed = self.good("export", self.blend("cube.blend"), "-o", scene).stdout
        self.assertIn(f"{scene}: 1 views, 12 triangles, 1 lights", printed)
        document, _ = glb.parse(scene.read_bytes())
        self.assertEqual([camera["name"] for camera in document["cameras"]], ["Camera"])
        self.good("render", "--scene", scene, "--method", "ssao", "--resolution", "32", "18", "-o",
                  self.folder / "cube.exr")

    def test_a_python_without_numpy_first_on_the_path_does_not_matter(self):
        """As a virtual environment: Blender would look for its modules beside that Python."""
        venv = self.folder / "venv"
        subprocess.run([sys.executable, "-m", "venv", "--without-pip", venv], check=True)
        path = os.pathsep.join((str(venv / "bin"), os.environ["PATH"]))
        self.good("export", self.blend("cube.blend"), "-o", self.folder / "cube.glb",
                  env={"PATH": path})

    def test_what_blender_cannot_open(self):
        text = self.write("text.blend", "no scene")
        last = self.fails(2, [], text, "-o", self.folder / "text.glb")
        self.assertIn(f"{text}: Blender cannot open it", last)

    def test_what_the_exporter_refuses(self):
        blend = self.blend("blind.blend", camera=False)
        last = self.fails(2, ["occlab export: error: ", "camera"], blend, "-o",
                          self.folder / "blind.glb")
        self.assertIn("scenes/FORMAT.md", last)

    def test_a_script_that_fails(self):
        blender = self.write("broken-blender", "#!/bin/sh\nexit 3\n")
        blender.chmod(0o755)
        blend = self.write("any.blend", "")
        last = self.fails(3, ["exit code 3"], blend, "-o", self.folder / "any.glb", "--blender",
                          blender)
        self.assertIn("any.blend: not exported", last)


class Usage(CliTest):
    def test_needs_no_blender(self):
        blend = self.write("any.blend", "")
        glb_path = self.folder / "any.glb"
        self.refused(2, ["none.blend", "no such file"], "export", self.folder / "none.blend", "-o",
                     glb_path)
        self.refused(2, ["-o", ".glb"], "export", blend, "-o", self.folder / "any.gltf")
        self.refused(2, ["--blender", "no-such-blender", "package blender"], "export", blend, "-o",
                     glb_path, "--blender", "no-such-blender")
        self.refused(2, ["--blender", "no such program"], "export", blend, "-o", glb_path,
                     "--blender", pathlib.Path("/nonexistent/blender"))
