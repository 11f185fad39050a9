// Axes, ranges, zips and exclusions of experiment files, and every way to get them wrong.

#include "tests/unit/config_fixture.h"

namespace occlab {
namespace {

// Line numbers matter below: line 1 is `format`.
const std::string sweep = R"(format = 1
[experiment]
name = "sweep"
title = "A sweep"
[scene]
source = ["gallery", "three_boxes"]
view = "main"
resolution = ["640x360", "320x180"]
[probe]
source = "sky_sun"
prefilter_degrees = [0, 3]
rotation_degrees = {from = 0, to = 270, step = 90}
[sweep]
zip = [["scene.source", "scene.resolution"]]
exclude = [{scene.source = "gallery", probe.rotation_degrees = [90, 270]}]
[[run]]
methods = ["ssao", "ssbn"]
samples = {from = 4, to = 32, factor = 2}
steps = [1, 2, 3, 4]
d_max_world = {from = 0.1, to = 0.3, step = 0.1}
zip = [["samples", "steps"]]
exclude = [{method = "ssbn", samples = [4, 8]}, {d_max_world = 0.3, steps = 4}]
seeds = [0, 7]
)";

std::string with(const std::string& from, const std::string& to) {
  std::string text = sweep;
  const std::size_t place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return text.replace(place, from.size(), to);
}

TEST_F(ConfigTest, BenchesAreEveryPointThatIsNotExcluded) {
  const Experiment e = load(sweep);
  // 2 zipped scenes x 2 filters x 4 rotations, less 2 x 2 of gallery.
  ASSERT_EQ(e.benches.size(), 12u);
  EXPECT_EQ(e.benches[0].scene.source, "gallery");
  EXPECT_EQ(e.benches[0].scene.width, 640);
  EXPECT_EQ(e.benches[0].probe->rotation_degrees, 0.0f);
  EXPECT_EQ(e.benches[1].probe->rotation_degrees, 180.0f) << "the last axis varies fastest";
  EXPECT_EQ(e.benches[2].probe->prefilter_degrees, 3.0f);
  EXPECT_EQ(e.benches[4].scene.source, "three_boxes");
  EXPECT_EQ(e.benches[4].scene.height, 180);
  EXPECT_EQ(e.benches[11].probe->rotation_degrees, 270.0f);
  EXPECT_EQ(e.scene.source, "gallery");
  const Experiment one = at_bench(e, e.benches[5]);
  EXPECT_EQ(one.scene.source, "three_boxes");
  EXPECT_EQ(one.probe->rotation_degrees, 90.0f);
  EXPECT_EQ(one.benches.size(), 1u);
}

TEST_F(ConfigTest, RunsZipAndExclude) {
  const std::vector<PlannedCell> cells = plan(load(sweep), fake_methods());
  // ssao: 4 zipped x 3 radii, less one; ssbn: 2 x 3, less one; two seeds each.
  ASSERT_EQ(cells.size(), 2u * (11 + 5));
  for (const PlannedCell& cell : cells) {
    const long samples = cell.parameters.integer("samples");
    const long steps = cell.parameters.integer("steps");
    EXPECT_EQ(samples, 2L << steps);
    EXPECT_FALSE(cell.method == "ssbn" && samples <= 8);
    EXPECT_FALSE(steps == 4 && cell.parameters.real("d_max_world") == 0.3);
  }
  EXPECT_EQ(cells[1].parameters.integer("seed"), 7);
  EXPECT_EQ(to_string(cells[4].parameters.value("d_max_world")), "0.3")
      << "not 0.30000000000000004";
}

TEST_F(ConfigTest, RangesAreExact) {
  const auto values = [&](const std::string& range) {
    std::vector<std::string> texts;
    std::string text = with("{from = 0.1, to = 0.3, step = 0.1}", range);
    text.replace(text.find(", {d_max_world = 0.3, steps = 4}"), 32, "");
    const std::vector<Axis> axes = load(text).runs[0].grid.axes;
    for (const ParameterValue& value : axes[2].values) texts.push_back(to_string(value));
    return texts;
  };
  using Texts = std::vector<std::string>;
  EXPECT_EQ(values("{from = 1, to = 9, step = 4}"), (Texts{"1", "5", "9"}));
  EXPECT_EQ(values("{from = 1, to = 8, step = 4}"), (Texts{"1", "5"}));
  EXPECT_EQ(values("{from = 9, to = 1, step = -4}"), (Texts{"9", "5", "1"}));
  EXPECT_EQ(values("{from = 1, to = 1, step = 1}"), (Texts{"1"}));
  EXPECT_EQ(values("{from = 0.1, to = 0.7, step = 0.2}"), (Texts{"0.1", "0.3", "0.5", "0.7"}));
  EXPECT_EQ(values("{from = 1, to = 81, factor = 3}"), (Texts{"1", "3", "9", "27", "81"}));
  EXPECT_EQ(values("{from = 8, to = 2, factor = 0.5}"), (Texts{"8", "4", "2"}));
  EXPECT_EQ(values("{from = 0.001, to = 1.0, factor = 10}"), (Texts{"0.001", "0.01", "0.1", "1"}));
}

TEST_F(ConfigTest, OneBenchIsAsItWas) {
  const Experiment e = load(base);
  ASSERT_EQ(e.benches.size(), 1u);
  EXPECT_EQ(e.benches[0].scene.source, e.scene.source);
  EXPECT_EQ(e.benches[0].scene.width, 640);
  EXPECT_EQ(e.runs[0].seeds, (std::vector<long>{0, 1, 2}));
}

TEST_F(ConfigTest, BadRanges) {
  const auto range = [](const std::string& text) {
    return with("{from = 4, to = 32, factor = 2}", text);
  };
  const auto place = [&](const std::string& key) { return at(18, "run[0].samples" + key); };
  EXPECT_ERROR(range("{from = 4, to = 32}"), place(".step") + "missing; a value is required");
  EXPECT_ERROR(range("{from = 4, to = 32, step = 0}"), place(".step") + "found 0; accepted is any");
  EXPECT_ERROR(range("{from = 4, to = 32, factor = 1}"), place(".factor") + "found 1; accepted is");
  EXPECT_ERROR(range("{from = 4, to = 32, factor = -2}"), place(".factor") + "found -2");
  EXPECT_ERROR(range("{from = 0, to = 32, factor = 2}"), place(".from") + "found 0 to 32; powers");
  EXPECT_ERROR(range("{from = 4, to = 32, factor = 2, step = 1}"), place(".step") + "accepted is");
  EXPECT_ERROR(range("{from = 4, to = 1, step = 1}"),
               place(".to") + "no value lies between 4 and 1");
  EXPECT_ERROR(range("{from = 4, to = 1, factor = 2}"), place(".to") + "no value lies between 4");
  EXPECT_ERROR(range("{from = 4, to = inf, step = 1}"),
               place(".to") + "found 'inf'; accepted is a");
  EXPECT_ERROR(range("{from = \"a\", to = 2, step = 1}"),
               place(".from") + "found 'a'; accepted is");
  EXPECT_ERROR(range("{from = 4, to = 32, fcator = 2}"),
               place(".fcator") + "unknown; did you mean 'factor'?");
  EXPECT_ERROR(range("{from = 1, to = 1000000000, step = 1}"),
               place(".step") + "the range has 1000000000 values; accepted are at most 100000");
  EXPECT_ERROR(range("{from = 1, to = 100, factor = 1.5}"),
               place(".factor") + "1.5 is not an integer; write reals");
  EXPECT_ERROR(range("{from = 1.0, to = 4.0, step = 1.0}"), place("") + "samples = 1");
  EXPECT_ERROR(range("{from = 100, to = 400, step = 100}"),
               place("") + "samples = 300: accepted is an integer in [1, 256]");
}

TEST_F(ConfigTest, BadZips) {
  EXPECT_ERROR(with("steps = [1, 2, 3, 4]", "steps = [1, 2]"),
               at(21, "run[0].zip") +
                   "'samples' has 4 values and 'steps' 2; accepted are axes with equally many");
  EXPECT_ERROR(with("[[\"samples\", \"steps\"]]", "[[\"samples\", \"stpes\"]]"),
               at(21, "run[0].zip") + "'stpes' is no axis here; did you mean 'steps'?");
  EXPECT_ERROR(with("[[\"samples\", \"steps\"]]", "[\"samples\", \"steps\"]"),
               at(21, "run[0].zip") + "found [ 'samples', 'steps' ]; accepted is a list of lists");
  EXPECT_ERROR(with("[[\"samples\", \"steps\"]]", "[[\"samples\"]]"),
               at(21, "run[0].zip") + "found");
  EXPECT_ERROR(with("[[\"samples\", \"steps\"]]", "[[\"samples\", \"samples\"]]"),
               at(21, "run[0].zip") + "'samples' is there twice");
  EXPECT_ERROR(with("\"scene.resolution\"]]", "\"resolution\"]]"),
               at(14, "sweep.zip") + "'resolution' is no axis here");
  EXPECT_ERROR(with("resolution = [\"640x360\", \"320x180\"]", "resolution = [640, 360]"),
               at(14, "sweep.zip") + "'scene.source' has 2 values and 'scene.resolution' 1");
  EXPECT_ERROR(
      with("resolution = [\"640x360\", \"320x180\"]", "resolution = [\"640x360\", \"640x360\"]")
          .replace(sweep.find("\"three_boxes\""), 13, "\"gallery\""),
      at(14, "sweep.zip") + "two points of [scene] and [probe] are the same");
}

TEST_F(ConfigTest, BadExclusions) {
  EXPECT_ERROR(
      with("samples = [4, 8]}", "samples = [4, 7]}"),
      at(22, "run[0].exclude[0].samples") + "'samples' is never 7; accepted: 4, 8, 16, 32");
  EXPECT_ERROR(with("{method = \"ssbn\"", "{method = \"s3ho\""),
               at(22, "run[0].exclude[0].method") + "'method' is never s3ho; accepted: ssao, ssbn");
  EXPECT_ERROR(with("{d_max_world = 0.3, steps = 4}", "{samples = 4, steps = 4}"),
               at(22, "run[0].exclude[1].") + "excludes nothing");
  EXPECT_ERROR(with("{d_max_world = 0.3, steps = 4}", "{}"),
               at(22, "run[0].exclude[1].") + "names");
  EXPECT_ERROR(with("{d_max_world = 0.3, steps = 4}", "{weight = \"binary\"}"),
               at(22, "run[0].exclude[1].weight") + "'weight' is no axis here; accepted: samples");
  EXPECT_ERROR(with("{d_max_world = 0.3, steps = 4}", "{steps = [1, 2, 3, 4]}"),
               at(22, "run[0].exclude[1].") + "with this exclusion nothing is left");
  EXPECT_ERROR(with("probe.rotation_degrees = [90, 270]", "probe.rotation_degrees = 45"),
               at(15, "sweep.exclude[0].probe") +
                   "'probe.rotation_degrees' is never 45; accepted: "
                   "0, 90, 180, 270");
  EXPECT_ERROR(with("{scene.source = \"gallery\", probe", "{samples = 4, probe"),
               at(15, "sweep.exclude[0].samples") + "unknown; accepted: scene, probe");
}

TEST_F(ConfigTest, BadBenches) {
  EXPECT_ERROR(with("\"320x180\"", "\"320x8\""), at(8, "scene.resolution") + "found '320x8'");
  EXPECT_ERROR(with("\"main\"", "[\"main\", 1]"), at(7, "scene.view") + "found 1; accepted are");
  EXPECT_ERROR(with("\"main\"", "[\"main\", \"main\"]"),
               at(7, "scene.view") + "main is listed twice");
  EXPECT_ERROR(with("[\"gallery\", \"three_boxes\"]", "[\"gallery\", \"\"]"),
               at(6, "scene.source"));
  EXPECT_ERROR(with("[0, 3]", "[0, 91]"),
               at(11, "probe.prefilter_degrees") + "found 91; accepted are numbers in [0, 90]");
  EXPECT_ERROR(with("zip = [[\"scene.source\"", "zips = [[\"scene.source\""),
               at(14, "sweep.zips") + "unknown; did you mean 'zip'?");
  EXPECT_ERROR(sweep + "[timing]\nmethods = [\"ssao\"]\nbaseline = \"ssao\"\n",
               at(24, "timing") +
                   "accepted with one scene, view, resolution and probe; [scene] and "
                   "[probe] make 12");
  EXPECT_ERROR(with("seeds = [0, 7]", "seeds = [0, -7]"), at(23, "run[0].seeds") + "found -7");
  EXPECT_ERROR(with("seeds = [0, 7]", "seeds = {from = 0, to = 9999, step = 1}"),
               at(23, "run[0].seeds") + "found 10000 of them; accepted are at most 4096");
}

TEST_F(ConfigTest, TooManyCells) {
  const std::string many = with("seeds = [0, 7]", "seeds = 4096");
  EXPECT_ERROR(many, file().string() +
                         ":5: key 'scene': 12 scenes, views, resolutions and probes "
                         "of 65536 cells each make 786432 cells; accepted are at most "
                         "100000");
}

}  // namespace
}  // namespace occlab
