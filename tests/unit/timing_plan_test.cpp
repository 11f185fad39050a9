// The axes of [timing], and what a file says of them that cannot be.

#include <map>

#include "renderers/scene/parallel.h"
#include "tests/unit/config_fixture.h"

namespace occlab {
namespace {

const std::string times_alone = R"(format = 1
[experiment]
name = "times"
title = "Times"
[scene]
source = "gallery"
resolution = [640, 360]
[parameters]
samples = 8
steps = 2
[timing]
methods = ["ssao", "ssbn"]
baseline = "ssao"
note = "A note"
)";

using TimingPlanTest = ConfigTest;

TEST_F(TimingPlanTest, AFileMayHaveTimesAlone) {
  const Experiment e = load(times_alone);
  EXPECT_TRUE(plan(e, fake_methods()).empty());
  EXPECT_EQ(plan_timing(e, fake_methods()).size(), 2u);
  EXPECT_EQ(e.timing->note, "A note");
  EXPECT_NE(error_of("format = 1\n[experiment]\nname = \"a\"\ntitle = \"A\"\n[scene]\nsource = "
                     "\"gallery\"\n")
                .find("key 'run': missing"),
            std::string::npos);
}

TEST_F(TimingPlanTest, CrossedAxes) {
  const Experiment e = load(times_alone +
                            "resolution = [\"1024x768\", \"1600x1200\"]\ntriangles = [10, 20]\n"
                            "samples = [4, 8, 16]\n");
  const std::vector<TimedCell> cells = plan_timing(e, fake_methods());
  ASSERT_EQ(cells.size(), 2u * 2 * 3 * 2);
  EXPECT_EQ(cells[0].triangles, 10);
  EXPECT_EQ(cells[0].resolution, (Resolution{1024, 768}));
  EXPECT_EQ(cells[2].cell.parameters.integer("samples"), 8) << "the last axis varies fastest";
  EXPECT_EQ(cells[6].resolution, (Resolution{1600, 1200}));
  EXPECT_EQ(cells[12].triangles, 20);
  for (const TimedCell& cell : cells) EXPECT_TRUE(cell.axes.empty());
  EXPECT_EQ(cells.back().cell.group, 11);
}

TEST_F(TimingPlanTest, RatiosMayBeToAnotherPlaceOnAnAxis) {
  const std::string axis = times_alone + "samples = [4, 8]\n";
  const Experiment e = load(axis + "baseline_at = {samples = 8}\n");
  ASSERT_EQ(e.timing->baseline_at.size(), 1u);
  EXPECT_EQ(e.timing->baseline_at.front(), (std::pair<std::string, ParameterValue>{"samples", 8L}));
  EXPECT_TRUE(load(axis).timing->baseline_at.empty());
  for (const char* bad : {"baseline_at = {samples = 16}\n", "baseline_at = {steps = 2}\n"}) {
    EXPECT_NE(error_of(axis + bad).find("accepted are axes of [timing] and their values"),
              std::string::npos)
        << bad;
  }
  EXPECT_NE(error_of(axis + "axes = \"one_by_one\"\nbaseline_at = {samples = 8}\n")
                .find("accepted with crossed axes only"),
            std::string::npos);
}

TEST_F(TimingPlanTest, OneByOneEqualPointsAreOne) {
  const Experiment e = load(times_alone +
                            "axes = \"one_by_one\"\nsamples = [4, 8, 16]\nsteps = [1, 2, 4]\n"
                            "resolution = [\"320x180\", \"640x360\"]\n");
  const std::vector<TimedCell> cells = plan_timing(e, fake_methods());
  // The base point, 2 other numbers of samples, 2 of steps, 1 resolution; two methods each.
  ASSERT_EQ(cells.size(), 2u * (1 + 2 + 2 + 1));
  std::map<std::string, int> points;
  for (const TimedCell& timed : cells) {
    for (const std::string& axis : timed.axes) ++points[axis];
    const bool base = timed.cell.parameters.integer("samples") == 8 &&
                      timed.cell.parameters.integer("steps") == 2 &&
                      timed.resolution == Resolution{640, 360};
    EXPECT_EQ(timed.axes.size(), base ? 3u : 1u);
  }
  EXPECT_EQ(points, (std::map<std::string, int>{{"samples", 6}, {"steps", 6}, {"resolution", 4}}));
  for (std::size_t i = 0; i < cells.size(); i += 2) {
    EXPECT_EQ(cells[i].cell.method, "ssao");
    EXPECT_EQ(cells[i].cell.group, cells[i + 1].cell.group);
  }
}

TEST_F(TimingPlanTest, ThreadsThatAreNotVariedAreThoseThereAre) {
  set_thread_count(3);
  const std::vector<TimedCell> cells =
      plan_timing(load(times_alone + "axes = \"one_by_one\"\nthreads = [1, 3]\nsteps = [2, 4]\n"),
                  fake_methods());
  set_thread_count(0);
  ASSERT_EQ(cells.size(), 2u * 3);
  EXPECT_EQ(cells[0].threads, 1);
  EXPECT_EQ(cells[2].threads, 3);
  EXPECT_EQ(cells[2].axes.size(), 2u);
  EXPECT_EQ(cells[4].threads, 3);
}

TEST_F(TimingPlanTest, Refusals) {
  const auto refused = [&](const std::string& line, const std::string& key) {
    return error_of(times_alone + line + "\n").substr(at(15, key).size());
  };
  EXPECT_EQ(refused("resolution = [\"640 x 360\"]", "timing.resolution"),
            "found '640 x 360'; accepted is a width and a height from 16 to 16384, such as "
            "'1280x720'");
  for (const char* text : {"8x8", "x", "640x", "640x360x2", "-640x360", "640x99999"}) {
    EXPECT_NE(error_of(times_alone + fmt::format("resolution = [\"{}\"]\n", text))
                  .find(fmt::format("found '{}'", text)),
              std::string::npos)
        << text;
  }
  EXPECT_EQ(refused("resolution = [\"64x64\", \"064x64\"]", "timing.resolution"),
            "064x64 is listed twice");
  EXPECT_EQ(refused("triangles = [0]", "timing.triangles"),
            "found 0; accepted are integers in [1, 67108864]");
  EXPECT_EQ(refused("triangles = [1.5]", "timing.triangles"),
            "found 1.5; accepted are integers in [1, 67108864]");
  EXPECT_EQ(refused("threads = [1, 64]", "timing.threads"),
            "found 64; accepted are integers in [1, 32]");
  EXPECT_EQ(refused("threads = [2, 2]", "timing.threads"), "2 is listed twice");
  EXPECT_EQ(refused("axes = \"both\"", "timing.axes").substr(0, 14), "unknown 'both'");
  EXPECT_EQ(refused("axes = \"one_by_one\"", "timing.axes").substr(0, 29),
            "'one_by_one' needs an axis: r");
  EXPECT_NE(refused("sampels = [4]", "timing.sampels").find("did you mean 'samples'"),
            std::string::npos);
}

}  // namespace
}  // namespace occlab
