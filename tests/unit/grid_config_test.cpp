// Figures over several scenes and views, grids and regions, and every way to get them wrong.

#include "tests/unit/config_fixture.h"

namespace occlab {
namespace {

// Line numbers matter below: line 1 is `format`.
const std::string views = R"(format = 1
[experiment]
name = "views"
title = "Views"
[scene]
source = "gallery"
view = ["left", "right"]
resolution = [640, 360]
[reference]
method = "rtdo"
[[run]]
methods = ["ssao", "ssbn"]
samples = [16, 8]
[[region]]
label = "floor"
rectangle = [0.5, 0.5, 0.25, 0.25]
scene.view = "left"
[[region]]
label = "floor"
rectangle = [10, 20, 30, 40]
scene.view = "right"
[[region]]
label = "spot"
pixel = [0.5, 0.5]
scene.view = "right"
[[figure]]
name = "frames"
kind = "grid"
samples = 16
columns = [{label = "first", scene.view = "left"},
           {label = "second", scene.view = "right"}]
rows = [{label = "SSAO", method = "ssao"},
        {label = "part", method = "ssbn", rectangle = [0, 0, 64, 36]},
        {label = "truth", method = "rtdo"}]
[[figure]]
name = "errors"
kind = "error_map"
methods = ["ssao"]
samples = 8
scene.view = "right"
scale = 0.5
)";

std::string with(const std::string& from, const std::string& to) {
  std::string text = views;
  const std::size_t place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return text.replace(place, from.size(), to);
}

TEST_F(ConfigTest, GridsSelectAPanelForEveryColumnAndRow) {
  const Experiment e = load(views);
  ASSERT_EQ(e.figures.size(), 2u);
  const FigureSettings& grid = e.figures[0];
  EXPECT_EQ(grid.methods, (std::vector<std::string>{"ssao", "ssbn", "rtdo"}));
  ASSERT_EQ(grid.panels.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(grid.panels[i].method, grid.methods[i / 2]) << i;
    EXPECT_EQ(grid.panels[i].bench, i % 2) << i;
    ASSERT_EQ(grid.panels[i].select.size(), 1u);
    EXPECT_EQ(grid.panels[i].select[0].first, "samples");
  }
  EXPECT_FALSE(grid.grid_rows[0].rectangle);
  EXPECT_EQ(grid.grid_rows[1].rectangle->width, 64);
  EXPECT_EQ(e.figures[1].bench, 1u);
}

TEST_F(ConfigTest, MethodsMayBeTheColumns) {
  const Experiment e =
      load(with(R"(columns = [{label = "first", scene.view = "left"},
           {label = "second", scene.view = "right"}]
rows = [{label = "SSAO", method = "ssao"},
        {label = "part", method = "ssbn", rectangle = [0, 0, 64, 36]},
        {label = "truth", method = "rtdo"}])",
                R"(columns = [{label = "a", method = "ssao"}, {label = "b", method = "rtdo"}]
rows = [{label = "whole", scene.view = "right"}])"));
  ASSERT_EQ(e.figures[0].panels.size(), 2u);
  EXPECT_EQ(e.figures[0].panels[1].method, "rtdo");
  EXPECT_EQ(e.figures[0].panels[1].bench, 1u);
  EXPECT_EQ(e.figures[0].bench, 1u);
}

TEST_F(ConfigTest, RegionsAreOfTheirBench) {
  const Experiment e = load(views);
  const std::vector<Region>& left = e.benches[0].regions;
  ASSERT_EQ(left.size(), 2u);
  EXPECT_EQ(left[0], (Region{"floor", {320, 180, 160, 90}, false}));
  EXPECT_EQ(left[1], (Region{"part", {0, 0, 64, 36}, false})) << "the grid's row";
  const std::vector<Region>& right = e.benches[1].regions;
  ASSERT_EQ(right.size(), 3u);
  EXPECT_EQ(right[0], (Region{"floor", {10, 20, 30, 40}, false}));
  EXPECT_EQ(right[1], (Region{"spot", {320, 180, 1, 1}, true}));
  const Experiment one = at_bench(e, e.benches[1]);
  EXPECT_EQ(one.benches.front().regions.size(), 3u);
  ASSERT_EQ(one.figures.size(), 1u) << "its own, without the grid";
  EXPECT_EQ(one.figures[0].name, "errors");
  EXPECT_EQ(one.figures[0].bench, 0u);
  EXPECT_TRUE(at_bench(e, e.benches[0]).figures.empty());
}

TEST_F(ConfigTest, FiguresOfNoOneBenchAreRefused) {
  const std::string which =
      "2 of the scenes, views, resolutions and probes fit; accepted is a choice of one, such as by "
      "scene.view: scene.view is 'left', 'right'";
  EXPECT_ERROR(with("scene.view = \"right\"\nscale", "scale"), at(36, "figure[1].name") + which);
  EXPECT_ERROR(with("\"left\"},", "\"middle\"},"),
               at(32, "figure[0].rows[0].label") + "none of the scenes, views");
  EXPECT_ERROR(with("{label = \"first\", scene.view = \"left\"}", "{label = \"first\"}"),
               at(32, "figure[0].rows[0].label") + which);
  EXPECT_ERROR(with("scene.view = \"left\"\n[[region]]", "[[region]]"),
               at(15, "region[0].label") + which);
  EXPECT_ERROR(changed("kind = \"comparison\"", "kind = \"comparison\"\nscene.view = \"other\""),
               at(30, "figure[0].name") + "[scene] and [probe] do not have these values");
}

TEST_F(ConfigTest, BadGridsAndRegions) {
  EXPECT_ERROR(
      with(", method = \"ssao\"},", "},"),
      at(33, "figure[0].rows[1].method") + "accepted is a method in all of them or in none");
  EXPECT_ERROR(with("label = \"first\"", "label = \"first\", method = \"ssao\""),
               at(31, "figure[0].columns[1].method") + "accepted is a method in all of them");
  EXPECT_ERROR(with("method = \"rtdo\"}", "method = \"rtod\"}"), file().string() + ":");
  EXPECT_ERROR(with("samples = 16\ncolumns", "columns"),
               at(31, "figure[0].rows[0].label") + "column 'first': 2 groups of cells of 'ssao'");
  EXPECT_ERROR(with("label = \"first\"", "label = \"first\", samples = 16"),
               at(32, "figure[0].rows[0].samples") + "it is also given elsewhere in the figure");
  EXPECT_ERROR(with("[0, 0, 64, 36]", "[0, 0, 641, 36]"),
               at(33, "figure[0].rows[1].rectangle") + "x 0, y 0, width 641");
  EXPECT_ERROR(with("pixel = [0.5, 0.5]", "pixel = [0.5, 0.5]\nrectangle = [0, 0, 1, 1]"),
               at(23, "region[2].label") + "accepted is a rectangle or a pixel, one of both");
  EXPECT_ERROR(with("label = \"part\"", "label = \"floor\""),
               at(32, "figure[0].rows") + "two different parts of the frame are called 'floor'");
  EXPECT_ERROR(with("resolution = [640, 360]\n[ref",
                    "resolution = [\"640x360\", \"64x36\"]\n[sweep]\nzip = [[\"scene.view\", "
                    "\"scene.resolution\"]]\n[ref"),
               file().string());
}

}  // namespace
}  // namespace occlab
