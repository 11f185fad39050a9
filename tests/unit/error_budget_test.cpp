// The error budget's arithmetic: what shares a budget cell, that parts add up to the total, and
// what the tables make of it. The images are made up; the passes have tests of their own.

#include "harness/error_budget.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "harness/budget_tables.h"
#include "renderers/methods/failure_classes.h"

namespace occlab {
namespace {

PlannedCell cell_of(const std::string& method, const NamedValues& values, int group = 0,
                    Role role = Role::test) {
  PlannedCell cell{role, method, ParameterSet(find_method(method).parameters), group};
  for (const auto& [name, value] : values) cell.parameters.set(name, value);
  return cell;
}

TEST(PlanBudget, SamplesSeedsAndFilterShareACell) {
  const std::vector<BudgetCell> budget = plan_budget(
      {cell_of("rtdo", {}, 0, Role::reference), cell_of("ssao", {{"samples", 8L}}),
       cell_of("ssao", {{"samples", 32L}, {"seed", 3L}}), cell_of("s3ho", {{"filter", "none"}}),
       cell_of("s3ho", {{"filter_power", 5.0}})});
  ASSERT_EQ(budget.size(), 1u);
  ASSERT_EQ(budget[0].variants.size(), 2u);
  EXPECT_EQ(budget[0].variants[0].name, "ssao");
  EXPECT_EQ(budget[0].variants[1].name, "s3ho");
}

TEST(PlanBudget, AnotherMarchIsAnotherCellAnotherLightingAnotherVariant) {
  const std::vector<BudgetCell> budget =
      plan_budget({cell_of("ssbn", {}), cell_of("ssbn", {{"cone_angle", "exact"}}),
                   cell_of("ssbn", {{"steps", 4L}}), cell_of("ssao", {{"d_max_world", 0.25}})});
  ASSERT_EQ(budget.size(), 3u);
  ASSERT_EQ(budget[0].variants.size(), 2u);
  EXPECT_EQ(budget[0].variants[1].name, "ssbn_2");
  EXPECT_EQ(budget[1].variants.size(), 1u);
  EXPECT_EQ(budget[2].variants.size(), 1u);
}

TEST(PlanBudget, OnlyOfTestsThatMarch) {
  EXPECT_TRUE(plan_budget({cell_of("rtdo", {}, 0, Role::reference), cell_of("rtdo", {}),
                           cell_of("ssao", {{"visibility", "traced"}}),
                           cell_of("ssao", {}, 0, Role::reference)})
                  .empty());
}

TEST(PlanBudget, FindsTheVariantOfACell) {
  const BudgetCell budget =
      plan_budget({cell_of("ssao", {}), cell_of("ssbn", {{"cone_angle", "exact"}})})[0];
  EXPECT_EQ(find_variant(budget, cell_of("ssao", {{"samples", 4L}, {"seed", 2L}})),
            &budget.variants[0]);
  EXPECT_EQ(find_variant(budget, cell_of("ssbn", {{"cone_angle", "exact"}})), &budget.variants[1]);
  EXPECT_EQ(find_variant(budget, cell_of("ssbn", {})), nullptr);
  EXPECT_EQ(find_variant(budget, cell_of("ssao", {{"steps", 5L}})), nullptr);
  EXPECT_EQ(find_variant(budget, cell_of("ssao", {{"visibility", "traced"}})), nullptr);
  EXPECT_EQ(find_variant(budget, cell_of("rtdo", {})), nullptr);
}

/// A plan of a reference and two seeds of SSAO over random images, whose last row is background.
class MeasureBudgetTest : public testing::Test {
 protected:
  static constexpr int width = 7, height = 5;

  MeasureBudgetTest() {
    reference_.add("radiance", random_image(3));
    reference_.add("mask", mask());
    reference_.add("radiance_variance", Image(width, height, 3, 1e-4f));
    budget_.layers.add("ssao_traced", random_image(3));
    budget_.layers.add("ssao_depth", random_image(3));
    for (const std::string_view name : failure_class_names) {
      budget_.layers.add(std::string(name) + "_occlusion", random_image(1));
      budget_.layers.add(std::string(name) + "_radiance", random_image(3));
    }
    for (Layers& seed : seeds_) {
      seed.add("radiance", random_image(3));
      seed.add("radiance_unfiltered", random_image(3));
    }
    budget_.facts = {{"ssao_traced_standard_error", "0.03"},
                     {"ssao_depth_standard_error", "0.04"},
                     {"classes_standard_error", "0.002"}};
    measured_ = measure_budget(budget_, {{plan_[0], "r"}, {plan_[1], "a"}, {plan_[2], "b"}}, {},
                               [&](const MeasuredCell& cell) {
                                 if (cell.id == "r") return reference_;
                                 return seeds_[cell.id == "a" ? 0 : 1];
                               });
  }

  Image random_image(int channels) {
    Image image(width, height, channels);
    for (float& value : image.values()) value = std::uniform_real_distribution(0.0f, 1.0f)(random_);
    return image;
  }
  static Image mask() {
    Image mask(width, height, 1, 1.0f);
    for (int x = 0; x < width; ++x) mask.at(x, height - 1) = 0.0f;
    return mask;
  }

  double value(const std::string& stage, const std::string& metric) const {
    for (const Measurement& m : measured_) {
      if (m.stage == stage && m.metric == metric) return m.value.value();
    }
    ADD_FAILURE() << "no " << metric << ", " << stage;
    return NAN;
  }

  /// Over the surface, in the reference's mean luminances.
  double rms_difference(const Image& a, const Image& b) const {
    double squares = 0.0, luminance = 0.0;
    const Image& r = reference_.at("radiance");
    for (int y = 0; y + 1 < height; ++y) {
      for (int x = 0; x < width; ++x) {
        for (int c = 0; c < 3; ++c) {
          squares += std::pow(double(a.at(x, y, c)) - double(b.at(x, y, c)), 2);
        }
        luminance += 0.2126 * double(r.at(x, y, 0)) + 0.7152 * double(r.at(x, y, 1)) +
                     0.0722 * double(r.at(x, y, 2));
      }
    }
    const double pixels = width * (height - 1);
    return std::sqrt(squares / (3 * pixels)) / (luminance / pixels);
  }

  std::mt19937 random_{5};
  std::vector<PlannedCell> plan_ = {cell_of("rtdo", {}, 0, Role::reference), cell_of("ssao", {}, 1),
                                    cell_of("ssao", {{"seed", 1L}}, 1)};
  BudgetCell cell_ = plan_budget(plan_)[0];
  StoredBudget budget_{cell_, "budget", {}, {}};
  Layers reference_;
  std::array<Layers, 2> seeds_;
  std::vector<Measurement> measured_;
};

TEST_F(MeasureBudgetTest, PartsAddUpToTheTotal) {
  for (const std::string stage : {"unfiltered", "filtered"}) {
    double mean = 0.0, share = 0.0;
    for (const std::string part : {"representation", "visibility", "sampling", "filter"}) {
      if (stage == "unfiltered" && part == "filter") continue;
      mean += value(stage, "budget_mean." + part);
      share += value(stage, "budget_share." + part);
    }
    EXPECT_NEAR(mean, value(stage, "budget_mean.total"), 1e-12);
    EXPECT_NEAR(share, 1.0, 1e-12);
    EXPECT_NEAR(value(stage, "budget_share.total"), 1.0, 1e-12);
  }
}

TEST_F(MeasureBudgetTest, EachPartIsTheDifferenceItSays) {
  const Image& reference = reference_.at("radiance");
  const Image& traced = budget_.layers.at("ssao_traced");
  const Image& depth = budget_.layers.at("ssao_depth");
  EXPECT_NEAR(value("filtered", "budget_rms.representation"), rms_difference(traced, reference),
              1e-12);
  EXPECT_NEAR(value("filtered", "budget_rms.visibility"), rms_difference(depth, traced), 1e-12);
  const auto over_seeds = [&](const auto& difference) {
    return std::sqrt(0.5 *
                     (std::pow(difference(seeds_[0]), 2) + std::pow(difference(seeds_[1]), 2)));
  };
  EXPECT_NEAR(value("filtered", "budget_rms.sampling"), over_seeds([&](const Layers& seed) {
                return rms_difference(seed.at("radiance_unfiltered"), depth);
              }),
              1e-12);
  EXPECT_NEAR(value("filtered", "budget_rms.filter"), over_seeds([&](const Layers& seed) {
                return rms_difference(seed.at("radiance"), seed.at("radiance_unfiltered"));
              }),
              1e-12);
  EXPECT_NEAR(value("filtered", "budget_rms.total"), over_seeds([&](const Layers& seed) {
                return rms_difference(seed.at("radiance"), reference);
              }),
              1e-12);
}

TEST_F(MeasureBudgetTest, TheFloorIsTheNoiseOfAllThreeConvergedImages) {
  // The reference's variance is 1e-4 everywhere: .01 in radiance, so much in mean luminances.
  double luminance = 0.0;
  const Image& r = reference_.at("radiance");
  for (std::size_t i = 0; i < std::size_t(width) * std::size_t(height - 1); ++i) {
    const auto rgb = r.values().subspan(3 * i, 3);
    luminance += 0.2126 * double(rgb[0]) + 0.7152 * double(rgb[1]) + 0.0722 * double(rgb[2]);
  }
  const double reference = 0.01 / (luminance / (width * (height - 1)));
  EXPECT_NEAR(value("filtered", "budget_floor"),
              std::sqrt(0.03 * 0.03 + 0.04 * 0.04 + reference * reference), 1e-7);
}

TEST_F(MeasureBudgetTest, SharesOfTheClassesAddUpToOne) {
  double share = 0.0;
  for (const std::string_view name : failure_class_names) {
    share += value("", "failure_share." + std::string(name));
  }
  EXPECT_NEAR(share, 1.0, 1e-12);
  EXPECT_EQ(value("", "failure_floor"), 0.002);
}

TEST_F(MeasureBudgetTest, TablesHaveARowAMethodAndARowAClass) {
  const Table budget = budget_table(measured_, "filtered");
  ASSERT_EQ(budget.rows.size(), 1u);
  EXPECT_EQ(std::get<std::string>(budget.rows[0][0]), "ssao");
  EXPECT_EQ(budget.rows[0].size(), budget.columns.size());
  const Table classes = failure_table(measured_);
  ASSERT_EQ(classes.rows.size(), failure_class_names.size());
  EXPECT_EQ(std::get<std::string>(classes.rows[2][0]), "thin");
  EXPECT_TRUE(budget_table({}, "filtered").rows.empty());
  EXPECT_TRUE(failure_table({}).rows.empty());
}

TEST_F(MeasureBudgetTest, ABlackReferenceIsAReasonNotANumber) {
  Layers black;
  black.add("radiance", Image(width, height, 3));
  black.add("mask", mask());
  const std::vector<Measurement> measured =
      measure_budget(budget_, {{plan_[0], "r"}, {plan_[1], "a"}}, {},
                     [&](const MeasuredCell& cell) { return cell.id == "r" ? black : seeds_[0]; });
  for (const Measurement& m : measured) {
    if (m.metric == "budget_rms.total") {
      EXPECT_FALSE(m.value);
      EXPECT_FALSE(m.reason.empty());
    }
  }
}

}  // namespace
}  // namespace occlab
