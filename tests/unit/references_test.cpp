// Several references in one experiment: which cell is compared with which, and in whose units.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "harness/measure.h"
#include "renderers/methods/method.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

std::string text(const std::string& reference, const std::string& methods) {
  return "format = 1\n[experiment]\nname = \"two\"\ntitle = \"Two truths\"\n[scene]\n"
         "source = \"gallery\"\n[reference]\nmethod = " +
         reference +
         "\nrays_per_pixel = 64\nmax_rays_per_pixel = 256\n[[run]]\nmethods = " + methods +
         "\nseeds = 3\nsamples = 8\n";
}

class References : public testing::Test {
 protected:
  Experiment load(const std::string& content) const {
    std::ofstream(file_) << content;
    Experiment experiment = load_experiment(file_, {}, methods());
    std::filesystem::remove(file_);
    return experiment;
  }
  std::vector<PlannedCell> planned(const std::string& reference, const std::string& runs) const {
    return plan(load(text(reference, runs)), methods());
  }
  std::string error(const std::string& reference, const std::string& runs) const {
    try {
      load(text(reference, runs));
    } catch (const InputError& refused) {
      return refused.what();
    }
    return "no error";
  }
  std::filesystem::path file_ = std::filesystem::temp_directory_path() /
                                ("occlab_references_" + std::to_string(getpid()) + ".toml");
};

const char* const both = R"(["rtgi_unoccluded", "rtgi_shaded"])";

TEST_F(References, ComeFirstAndEveryMethodHasItsOwn) {
  const std::vector<PlannedCell> cells = planned(both, R"(["ssdogi", "s3hogi"])");
  ASSERT_EQ(cells.size(), 2u + 2u * 3u);
  EXPECT_EQ(cells[0].method, "rtgi_unoccluded");
  EXPECT_EQ(cells[0].parameters.integer("rays_per_pixel"), 64);
  EXPECT_EQ(cells[1].method, "rtgi_shaded");
  EXPECT_EQ(cells[1].parameters.integer("rays_per_pixel"), 256);
  for (std::size_t i = 2; i < cells.size(); ++i) {
    EXPECT_EQ(cells[i].role, Role::test);
    EXPECT_EQ(reference_place(cells, cells[i]), cells[i].method == "ssdogi" ? 1u : 0u);
  }
}

TEST_F(References, OneServesAll) {
  const std::vector<PlannedCell> cells = planned(R"("rtdo")", R"(["ssao", "s3hogi"])");
  ASSERT_EQ(cells.size(), 1u + 2u * 3u);
  for (const PlannedCell& cell : cells) EXPECT_EQ(reference_place(cells, cell), 0u);
}

TEST_F(References, OfWhichAMethodHasNoneAreRefused) {
  const std::string message = error(both, R"(["s3hogi", "ssao"])");
  for (const char* word : {":8: key 'reference.method'", "'ssao'", "'rtdo'"}) {
    EXPECT_NE(message.find(word), std::string::npos) << message;
  }
  EXPECT_NE(error(R"(["rtgi_shaded", "rtgi_shaded"])", R"(["ssdogi"])").find("reference.method"),
            std::string::npos);
  EXPECT_NE(error("[]", R"(["ssdogi"])").find("reference.method"), std::string::npos);
}

TEST_F(References, MeasureEachMethodInItsOwnUnits) {
  // S3HOGI's truth is 2 and SSDO's 1 everywhere; S3HOGI is off by 0.2 and SSDO by 0.1, with noise
  // of 0.04 and 0.02.
  const std::vector<PlannedCell> planned_cells =
      planned(both, "[\"s3hogi\", \"ssdogi\"]\nform_factor = \"patch\"");
  std::vector<MeasuredCell> cells;
  for (std::size_t i = 0; i < planned_cells.size(); ++i) {
    cells.push_back({planned_cells[i], "cell" + std::to_string(i)});
  }
  const auto read = [&](const MeasuredCell& cell) {
    const bool of_s3hogi = cell.planned.truth == "rtgi_unoccluded";
    float value = of_s3hogi ? 2.0f : 1.0f;
    if (cell.planned.role == Role::test) {
      const auto seed = float(cell.planned.parameters.integer("seed"));
      value -= of_s3hogi ? 0.2f + 0.04f * (seed - 1.0f) : 0.1f + 0.02f * (seed - 1.0f);
    }
    Layers layers;
    layers.add("radiance", Image(24, 24, 3, value));
    if (cell.planned.role == Role::reference) layers.add("mask", Image(24, 24, 1, 1.0f));
    return layers;
  };
  std::vector<Measurement> rows;
  measure_cells(
      cells, {}, {}, read, [](std::size_t) {},
      [&](std::vector<Measurement> more) { rows.insert(rows.end(), more.begin(), more.end()); });
  const auto row = [&](const std::string& method, const std::string& metric) {
    const auto found = std::ranges::find_if(rows, [&](const Measurement& candidate) {
      return candidate.method == method && candidate.metric == metric && candidate.seed == "all";
    });
    EXPECT_NE(found, rows.end()) << method << " " << metric;
    return found == rows.end() ? Measurement{} : *found;
  };
  EXPECT_EQ(row("s3hogi", "rmse").reference_cell, "cell0");
  EXPECT_EQ(row("ssdogi", "rmse").reference_cell, "cell1");
  EXPECT_NEAR(*row("s3hogi", "bias").value, 0.1, 1e-3);
  EXPECT_NEAR(*row("ssdogi", "bias").value, 0.1, 1e-3);
  EXPECT_NEAR(*row("s3hogi", "noise").value, 0.02, 1e-6);
  EXPECT_NEAR(*row("ssdogi", "noise").value, 0.02, 1e-6);
  // The noise itself is twice as large.
  EXPECT_NEAR(*row("ssdogi", "noise_ratio.ssdogi/s3hogi").value, 0.5, 1e-5);
  const Measurement difference = row("ssdogi", "bias_squared_difference.ssdogi/s3hogi");
  EXPECT_FALSE(difference.value);
  EXPECT_NE(difference.reason.find("references"), std::string::npos);
}

}  // namespace
}  // namespace occlab
