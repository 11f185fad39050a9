// Every kind of bad experiment file, and what the message says.

#include "tests/unit/config_fixture.h"

namespace occlab {
namespace {

TEST_F(ConfigTest, OverrideErrorsNameTheOverride) {
  EXPECT_OVERRIDE_ERROR("scene.sourc=a",
                        "--set scene.sourc=a: key 'scene.sourc': unknown; did you mean 'source'?");
  EXPECT_OVERRIDE_ERROR("run[0].seeds=0",
                        "--set run[0].seeds=0: key 'run[0].seeds': found 0 (an integer); accepted "
                        "is an integer in [1, 4096]");
  EXPECT_OVERRIDE_ERROR("run[1].seeds=1", "--set run[1].seeds=1: 'run' has 1 entries");
  EXPECT_OVERRIDE_ERROR("scene.source.x=1",
                        "--set scene.source.x=1: 'scene.source' is not a table");
  EXPECT_OVERRIDE_ERROR("scene[0]=1", "--set scene[0]=1: 'scene' is not a list");
  EXPECT_OVERRIDE_ERROR("scene.view", "--set scene.view: accepted is KEY=VALUE");
  EXPECT_OVERRIDE_ERROR("=1", "--set =1: accepted is KEY=VALUE");
  EXPECT_OVERRIDE_ERROR("run[x].seeds=1", "--set run[x].seeds=1: accepted is KEY=VALUE");
  EXPECT_OVERRIDE_ERROR("scene.view=", "--set scene.view=: the value is not TOML");
  EXPECT_OVERRIDE_ERROR("scene.resolution=[1", "--set scene.resolution=[1: the value is not TOML");
  EXPECT_OVERRIDE_ERROR("scene.view=1\nformat=2", "--set scene.view=1\nformat=2: the value is not");
  EXPECT_OVERRIDE_ERROR("parameters.samples=900",
                        "--set parameters.samples=900: key 'parameters.samples': samples = 900: "
                        "accepted is an integer in [1, 256]");
  std::string without_probe = changed("[probe]\nsource = \"sky_sun\"\nprefilter_degrees = 3\n", "");
  EXPECT_EQ(error_of(without_probe, {"probe.exposure_stops=1"}),
            "--set probe.exposure_stops=1: key 'probe.source': missing; a text is required");
}

TEST_F(ConfigTest, MissingFileAndSyntax) {
  try {
    load_experiment(folder_ / "none.toml", {}, fake_methods());
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("none.toml"), std::string::npos);
  }
  EXPECT_THROW(load_experiment(folder_, {}, fake_methods()), InputError);
  EXPECT_ERROR(changed("view = \"main\"", "view = \"main"), file().string() + ":7: not TOML: ");
  EXPECT_ERROR(changed("seeds = 3", "seeds = 3\nseeds = 4"), file().string() + ":22: not TOML: ");
  EXPECT_ERROR(std::string("\xff\xfe\0garbage", 10), file().string() + ":1: not TOML: ");
}

TEST_F(ConfigTest, UnknownKeys) {
  EXPECT_ERROR(changed("samples = [16, 8]", "sampels = [16, 8]"),
               at(20, "run[0].sampels") +
                   "unknown; did you mean 'samples'? accepted: methods, seeds, zip, exclude, "
                   "steps, samples, d_max_world, weight, gbuffer_bits, cone_angle");
  EXPECT_ERROR(changed("view =", "camera ="), at(7, "scene.camera") + "unknown; accepted: source");
  EXPECT_ERROR(changed("[timing]", "[timings]"),
               at(22, "timings") + "unknown; did you mean 'timing'");
  EXPECT_ERROR(changed("prefilter_degrees", "prefilter"), at(11, "probe.prefilter") + "unknown");
  EXPECT_ERROR(changed("title =", "titel ="), at(2, "experiment.title") + "missing");
  EXPECT_ERROR(changed("d_max_world", "d_max"),
               at(13, "parameters.d_max") + "unknown; accepted: samples, steps, d_max_world");
  EXPECT_ERROR(changed("rays_per_pixel", "samples"), at(16, "reference.samples") + "unknown");
  EXPECT_ERROR(changed("scale = 0.5", "scale = 0.5\nrows = 1"),
               at(49, "figure[2].rows") + "unknown");
  EXPECT_ERROR(changed("label = \"b\"", "label = \"b\", lable = 1"),
               at(41, "figure[1].rows[1].lable") + "unknown; did you mean 'label'?");
  EXPECT_ERROR(changed("[parameters]", "[parameters]\nrays = 4"),
               at(13, "parameters.rays") + "unknown");
}

TEST_F(ConfigTest, MissingKeys) {
  EXPECT_ERROR(changed("format = 1\n", ""), file().string() + ": key 'format': missing");
  EXPECT_ERROR("format = 1\n",
               file().string() + ": key 'experiment': missing; a table [experiment]");
  EXPECT_ERROR(changed("source = \"gallery\"\n", ""), at(5, "scene.source") + "missing");
  EXPECT_ERROR(changed("methods = [\"ssao\", \"ssbn\"]\nsteps", "steps"),
               at(17, "run[0].methods") + "missing");
  EXPECT_ERROR(changed("baseline = \"ssao\"\n", ""), at(22, "timing.baseline") + "missing");
  EXPECT_ERROR(changed("method = \"rtdo\"\n", ""), at(14, "reference.method") + "missing");
  EXPECT_ERROR(changed("scale = 0.5\n", ""), at(42, "figure[2].scale") + "missing");
  EXPECT_ERROR(changed("label = \"a\", ", ""), at(40, "figure[1].rows[0].label") + "missing");
  EXPECT_ERROR(base.substr(0, base.find("[[run]]")), file().string() + ": key 'run': missing");
}

TEST_F(ConfigTest, WrongTypesAndRanges) {
  EXPECT_ERROR(changed("format = 1", "format = 2"),
               at(1, "format") + "found 2 (an integer); accepted is an integer in [1, 1]");
  EXPECT_ERROR(changed("\"test\"", "\"A Test\""), at(3, "experiment.name") + "found 'A Test'");
  EXPECT_ERROR(changed("\"A test\"", "\"\""), at(4, "experiment.title") + "found '' (a text)");
  EXPECT_ERROR(changed("[640, 360]", "[640, 8]"), at(8, "scene.resolution"));
  EXPECT_ERROR(changed("[640, 360]", "[640.0, 360]"), at(8, "scene.resolution"));
  EXPECT_ERROR(changed("[640, 360]", "[640, 360, 1]"),
               at(8, "scene.resolution") + "found [ 640, 360, 1 ]; accepted is a list of 2");
  EXPECT_ERROR(changed("[640, 360]", "\"640x360\""), at(8, "scene.resolution"));
  EXPECT_ERROR(changed("[640, 360]", "[99999999999, 360]"), at(8, "scene.resolution"));
  EXPECT_ERROR(changed("prefilter_degrees = 3", "prefilter_degrees = nan"),
               at(11, "probe.prefilter_degrees"));
  EXPECT_ERROR(changed("prefilter_degrees = 3", "prefilter_degrees = -1"),
               at(11, "probe.prefilter_degrees"));
  EXPECT_ERROR(changed("prefilter_degrees = 3", "prefilter_degrees = true"),
               at(11, "probe.prefilter_degrees") + "found true (a truth value)");
  EXPECT_ERROR(changed("d_max_world = 0.5", "d_max_world = 0"), at(13, "parameters.d_max_world"));
  EXPECT_ERROR(changed("d_max_world = 0.5", "d_max_world = nan"), at(13, "parameters.d_max_world"));
  EXPECT_ERROR(changed("d_max_world = 0.5", "d_max_world = [1, 2]"),
               at(13, "parameters.d_max_world") + "found [ 1, 2 ]; accepted is one value");
  EXPECT_ERROR(changed("d_max_world = 0.5", "weight = \"lamda\""),
               at(13, "parameters.weight") + "weight = lamda: accepted is one of binary, lambda");
  EXPECT_ERROR(changed("d_max_world = 0.5", "d_max_world = 1979-05-27"),
               at(13, "parameters.d_max_world") + "found 1979-05-27 (a date or time)");
  EXPECT_ERROR(changed("samples = [16, 8]", "samples = [16, 8.5]"), at(20, "run[0].samples"));
  EXPECT_ERROR(changed("samples = [16, 8]", "samples = []"), at(20, "run[0].samples"));
  EXPECT_ERROR(changed("samples = [16, 8]", "samples = [16, 16]"),
               at(20, "run[0].samples") + "16 is listed twice");
  EXPECT_ERROR(changed("samples = [16, 8]", "samples = [16, [8]]"), at(20, "run[0].samples"));
  EXPECT_ERROR(changed("samples = [16, 8]", "samples = {a = 1}"),
               at(20, "run[0].samples.a") + "unknown; accepted: factor, step, from, to");
  EXPECT_ERROR(changed("seeds = 3", "seeds = 0"), at(21, "run[0].seeds"));
  EXPECT_ERROR(changed("repetitions = 5", "repetitions = 2"), at(26, "timing.repetitions"));
  EXPECT_ERROR(changed("budget_seconds = 2", "budget_seconds = 0"),
               at(27, "timing.budget_seconds"));
  EXPECT_ERROR(changed("scale = 0.5", "scale = 0"), at(48, "figure[2].scale"));
  EXPECT_ERROR(changed("[[run]]", "[run]"), at(17, "run") + "found a table; accepted is a list of");
  EXPECT_ERROR(changed("[scene]", "[[scene]]"), at(5, "scene") + "found a list of tables");
}

TEST_F(ConfigTest, MethodsAndTheirParameters) {
  EXPECT_ERROR(changed("[\"ssao\", \"ssbn\"]\nsteps", "[\"ssao\", \"ssbm\"]\nsteps"),
               at(18, "run[0].methods") +
                   "unknown method 'ssbm'; did you mean 'ssbn'? accepted: "
                   "ssao, ssbn, rtdo, fixed");
  EXPECT_ERROR(changed("[\"ssao\", \"ssbn\"]\nsteps", "[]\nsteps"), at(18, "run[0].methods"));
  EXPECT_ERROR(changed("[\"ssao\", \"ssbn\"]\nsteps", "\"ssao\"\nsteps"), at(18, "run[0].methods"));
  EXPECT_ERROR(changed("[\"ssao\", \"ssbn\"]\nsteps", "[\"ssao\", \"ssao\"]\nsteps"),
               at(18, "run[0].methods") + "'ssao' is listed twice");
  EXPECT_ERROR(changed("seeds = 3", "cone_angle = \"exact\""),
               at(21, "run[0].cone_angle") + "method 'ssao' does not declare it");
  EXPECT_ERROR(changed("seeds = 3", "seed = 1"), at(21, "run[0].seed") + "not accepted here");
  EXPECT_ERROR(changed("d_max_world = 0.5", "seed = 1"),
               at(13, "parameters.seed") + "not accepted");
  EXPECT_ERROR(changed("[timing]", "[[run]]\nmethods = [\"fixed\"]\nseeds = 2\n[timing]"),
               at(24, "run[1].seeds") + "method 'fixed' has no seed; accepted is 1");
  EXPECT_ERROR(changed("baseline = \"ssao\"", "baseline = \"rtdo\""),
               at(25, "timing.baseline") + "'rtdo' is not one of timing.methods");
  EXPECT_ERROR(changed("\"s3ho_table1\"", "\"s3ho_table9\""),
               at(28, "timing.published") + "there is no file ");
  EXPECT_ERROR(changed("\"s3ho_table1\"", "\"../x\""), at(28, "timing.published") + "found '../x'");
  EXPECT_ERROR(changed("method = \"rtdo\"", "method = \"none\""), at(15, "reference.method"));
}

TEST_F(ConfigTest, EqualCells) {
  EXPECT_ERROR(
      changed("[timing]", "[[run]]\nmethods = [\"ssao\"]\nsteps = 2\nsamples = 8\n[timing]"),
      at(23, "run[1].methods") +
          "the cell 'ssao samples=8 steps=2 seed=0 d_max_world=0.5 weight=binary "
          "gbuffer_bits=32' is also made by run[0]");
  EXPECT_ERROR(changed("[timing]", "[[run]]\nmethods = [\"rtdo\"]\nrays_per_pixel = 64\n[timing]"),
               at(23, "run[1].methods") +
                   "the cell 'rtdo rays_per_pixel=64 seed=0 d_max_world=0.5' "
                   "is also made by the reference");
}

TEST_F(ConfigTest, Figures) {
  EXPECT_ERROR(changed("\"errors\"", "\"fig7\""),
               at(43, "figure[2].name") + "two figures are called 'fig7'");
  EXPECT_ERROR(changed("\"comparison\"", "\"comparson\""),
               at(31, "figure[0].kind") + "unknown 'comparson'; did you mean 'comparison'?");
  EXPECT_ERROR(changed("\"unfiltered\"", "\"raw\""), at(38, "figure[1].stage") + "unknown 'raw'");
  EXPECT_ERROR(changed("samples = 16\nsteps = 2\n[[figure]]", "samples = 4\n[[figure]]"),
               at(33, "figure[0].samples") +
                   "no cell of 'ssao' has these values; there are samples (16, 8)");
  EXPECT_ERROR(changed("samples = 16\nsteps = 2\n[[figure]]", "samples = 16\n[[figure]]"),
               at(33, "figure[0].samples") +
                   "2 groups of cells of 'ssao' match, which differ in steps (4, 2); say which");
  EXPECT_ERROR(
      changed("methods = [\"rtdo\", \"ssao\"]\nsamples = 16\nsteps = 2",
              "methods = [\"rtdo\", \"fixed\"]\nsamples = 16"),
      at(33, "figure[0].samples") + "no [[run]] and no [reference] makes a cell of 'fixed'");
  EXPECT_ERROR(changed("methods = [\"ssao\"]\nsamples = 16\nsteps = 2", "methods = [\"rtdo\"]"),
               at(45, "figure[2].methods") + "'rtdo' is the reference itself");
  EXPECT_ERROR(changed("[600, 300, 40, 60]", "[601, 300, 40, 60]"),
               at(40, "figure[1].rows[0].rectangle") +
                   "x 601, y 300, width 40, height 60 (pixels) "
                   "is empty or not inside the frame of 640x360");
  EXPECT_ERROR(changed("[600, 300, 40, 60]", "[600, 300, 0, 60]"),
               at(40, "figure[1].rows[0].rectangle"));
  EXPECT_ERROR(changed("[0.5, 0.5, 0.25, 0.5]", "[0.5, 0.5, 0.25, 0.6]"),
               at(41, "figure[1].rows[1].rectangle"));
  EXPECT_ERROR(changed("[0.5, 0.5, 0.25, 0.5]", "[0.5, 0.5, 32, 0.5]"),
               at(41, "figure[1].rows[1].rectangle") + "accepted are four integers (pixels) or");
  EXPECT_ERROR(changed("[reference]\nmethod = \"rtdo\"\nrays_per_pixel = 64\n",
                       "[[run]]\nmethods = [\"rtdo\"]\n"),
               at(43, "figure[2].kind") + "a figure of errors needs a [reference]");
}

}  // namespace
}  // namespace occlab
