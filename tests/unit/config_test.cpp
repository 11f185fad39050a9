#include <set>

#include "renderers/scene/data_root.h"
#include "tests/unit/config_fixture.h"

namespace occlab {
namespace {

namespace fs = std::filesystem;

TEST_F(ConfigTest, ReadsEverything) {
  const Experiment e = load(base);
  EXPECT_EQ(e.name, "test");
  EXPECT_EQ(e.title, "A test");
  EXPECT_EQ(e.scene.source, "gallery");
  EXPECT_EQ(e.scene.view, "main");
  EXPECT_EQ(e.scene.width, 640);
  EXPECT_EQ(e.scene.height, 360);
  ASSERT_TRUE(e.probe);
  EXPECT_EQ(e.probe->source, "sky_sun");
  EXPECT_FLOAT_EQ(e.probe->prefilter_degrees, 3.0f);
  EXPECT_FLOAT_EQ(e.probe->exposure_stops, 0.0f);
  ASSERT_EQ(e.runs.size(), 1u);
  EXPECT_EQ(e.runs[0].seeds, (std::vector<long>{0, 1, 2}));
  ASSERT_EQ(e.runs[0].grid.axes.size(), 2u);
  EXPECT_EQ(e.runs[0].grid.axes[0].parameter, "steps") << "file order, not the alphabet's";
  EXPECT_EQ(e.runs[0].grid.axes[1].parameter, "samples");
  ASSERT_TRUE(e.timing);
  EXPECT_EQ(e.timing->baseline, "ssao");
  EXPECT_EQ(e.timing->repetitions, 5);
  EXPECT_EQ(e.timing->published, "s3ho_table1");
  ASSERT_EQ(e.figures.size(), 3u);
  EXPECT_EQ(e.figures[0].stage, "filtered");
  EXPECT_EQ(e.figures[1].stage, "unfiltered");
  ASSERT_EQ(e.figures[1].rows.size(), 2u);
  const Rectangle& pixels = e.figures[1].rows[0].rectangle;
  EXPECT_EQ((std::vector{pixels.x, pixels.y, pixels.width, pixels.height}),
            (std::vector{600, 300, 40, 60}));
  const Rectangle& fractions = e.figures[1].rows[1].rectangle;
  EXPECT_EQ((std::vector{fractions.x, fractions.y, fractions.width, fractions.height}),
            (std::vector{320, 180, 160, 180}));
  EXPECT_DOUBLE_EQ(e.figures[2].scale, 0.5);
}

TEST_F(ConfigTest, PlansTheReferenceThenRunsAxesSeeds) {
  const Experiment e = load(base);
  const std::vector<PlannedCell> cells = plan(e, fake_methods());
  ASSERT_EQ(cells.size(), 1u + 2 * 2 * 2 * 3);
  EXPECT_EQ(cells[0].role, Role::reference);
  EXPECT_EQ(cells[0].method, "rtdo");
  EXPECT_EQ(cells[0].parameters.to_string(), "rays_per_pixel=64 seed=0 d_max_world=0.5");
  EXPECT_EQ(cells[1].parameters.to_string(),
            "samples=16 steps=4 seed=0 d_max_world=0.5 weight=binary gbuffer_bits=32");
  EXPECT_EQ(cells[2].parameters.integer("seed"), 1);
  EXPECT_EQ(cells[4].parameters.integer("samples"), 8);
  EXPECT_EQ(cells[7].parameters.integer("steps"), 2);
  EXPECT_EQ(cells[13].method, "ssbn");
  std::set<std::string> different;
  for (std::size_t i = 1; i < cells.size(); ++i) {
    EXPECT_EQ(cells[i].role, Role::test);
    EXPECT_EQ(cells[i].group, int(1 + (i - 1) / 3));
    different.insert(cells[i].method + cells[i].parameters.to_string());
  }
  EXPECT_EQ(different.size(), 24u);
}

TEST_F(ConfigTest, PlansTheTimingsPointByPoint) {
  const std::vector<TimedCell> timed = plan_timing(load(base), fake_methods());
  ASSERT_EQ(timed.size(), 4u);
  EXPECT_EQ(timed[0].cell.method, "ssao");
  EXPECT_EQ(timed[1].cell.method, "ssbn");
  EXPECT_EQ(timed[1].cell.group, timed[0].cell.group);
  EXPECT_NE(timed[2].cell.group, timed[0].cell.group);
  EXPECT_EQ(timed[2].cell.parameters.integer("samples"), 8);
  EXPECT_DOUBLE_EQ(timed[2].cell.parameters.real("d_max_world"), 0.5);
  EXPECT_EQ(timed[2].resolution, (Resolution{640, 360}));
  EXPECT_EQ(timed[2].triangles, 0);
  EXPECT_EQ(timed[2].threads, 0);
}

TEST_F(ConfigTest, SelectsOneGroup) {
  const std::vector<PlannedCell> cells = plan(load(base), fake_methods());
  EXPECT_EQ(select_group(cells, "rtdo", {{"samples", 16L}}), 0);
  const int group = select_group(cells, "ssbn", {{"samples", 8L}, {"steps", 2L}});
  for (const PlannedCell& cell : cells) {
    EXPECT_EQ(cell.group == group, cell.method == "ssbn" &&
                                       cell.parameters.integer("samples") == 8 &&
                                       cell.parameters.integer("steps") == 2);
  }
  EXPECT_THROW(select_group(cells, "ssbn", {{"samples", 8L}}), SelectionError);
  EXPECT_THROW(select_group(cells, "ssbn", {{"samples", 7L}}), SelectionError);
}

TEST_F(ConfigTest, DefaultsWhereKeysAreAbsent) {
  const Experiment e = load(R"(format = 1
[experiment]
name = "few"
title = "Few keys"
[scene]
source = "gallery"
[[run]]
methods = ["fixed"]
)");
  EXPECT_FALSE(e.probe);
  EXPECT_FALSE(e.reference);
  EXPECT_FALSE(e.timing);
  EXPECT_EQ(e.scene.width, 1280);
  EXPECT_EQ(e.scene.height, 720);
  const auto cells = plan(e, fake_methods());
  ASSERT_EQ(cells.size(), 1u);
  EXPECT_EQ(cells[0].parameters.to_string(), "samples=32");
  EXPECT_TRUE(plan_timing(e, fake_methods()).empty());
}

TEST_F(ConfigTest, PathsStartAtTheFile) {
  EXPECT_EQ(load(changed("\"gallery\"", "\"models/room.glb\"")).scene.source,
            (folder_ / "models/room.glb").string());
  EXPECT_EQ(load(base, {"scene.source=models/room.glb"}).scene.source,
            (fs::current_path() / "models/room.glb").string());
  for (const char* outside : {"\"/models/room.glb\"", "\"../room.glb\""}) {
    EXPECT_ERROR(changed("\"gallery\"", outside), file().string() + ":6: '");
    EXPECT_NE(error_of(changed("\"gallery\"", outside)).find("lies outside the folder"),
              std::string::npos);
  }
}

TEST_F(ConfigTest, WordsThatLookLikeNumbers) {
  const auto cells = plan(load(changed("seeds = 3", "gbuffer_bits = 16")), fake_methods());
  EXPECT_EQ(cells[1].parameters.choice("gbuffer_bits"), "16");
}

TEST_F(ConfigTest, Overrides) {
  const Experiment e = load(
      base, {"scene.resolution=[1280, 720]", "run[0].seeds=2", "parameters.d_max_world=1",
             "probe.source=cathedral", "probe.exposure_stops=-1.5", "reference.rays_per_pixel=128",
             "figure[1].rows[0].rectangle=[0.0,0.0,1.0,1.0]", "run[0].samples[0]=32",
             "figure[1].rows[1].samples=8", "figure[0].samples=32", "figure[2].samples=32"});
  EXPECT_EQ(e.scene.width, 1280);
  EXPECT_EQ(e.runs[0].seeds.size(), 2u);
  EXPECT_EQ(e.runs[0].grid.axes[0].parameter, "steps") << "an override does not reorder the axes";
  EXPECT_EQ(e.probe->source, "cathedral");
  EXPECT_FLOAT_EQ(e.probe->exposure_stops, -1.5f);
  EXPECT_EQ(e.figures[1].rows[0].rectangle.width, 1280);
  const auto cells = plan(e, fake_methods());
  EXPECT_EQ(cells[0].parameters.to_string(), "rays_per_pixel=128 seed=0 d_max_world=1");
  EXPECT_EQ(cells[1].parameters.integer("samples"), 32);
  EXPECT_NE(e.resolved.find("rays_per_pixel = 128"), std::string::npos);
  // What run.json keeps is an experiment file by itself.
  const Experiment again = load(e.resolved);
  EXPECT_EQ(plan(again, fake_methods()).size(), cells.size());
}

TEST(Experiments, ThoseOfTheRepositoryAreValid) {
  for (const char* name :
       {"smoke.toml", "papers/s3ho.toml", "papers/ssdo_table1.toml", "scaling.toml"}) {
    const Experiment e =
        load_experiment(fs::path(OCCLAB_SOURCE_DIR) / "configs" / name, {}, methods());
    EXPECT_EQ(plan(e, methods()).empty(), e.runs.empty());
    EXPECT_FALSE(plan_timing(e, methods()).empty());
    EXPECT_NO_THROW(scene_path(e.scene.source));
  }
  const Experiment paper = load_experiment(fs::path(OCCLAB_SOURCE_DIR) / "configs/papers/s3ho.toml",
                                           {"scene.resolution=[640, 360]"}, methods());
  EXPECT_EQ(plan_timing(paper, methods()).size(), 12u);
  EXPECT_EQ(plan(paper, methods()).size(), 1u + 4 * 3 * 8);
}

}  // namespace
}  // namespace occlab
