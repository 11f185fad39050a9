#include "harness/certification.h"

#include <gtest/gtest.h>

#include <cmath>

#include "harness/reference_chain.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

Measurement row(std::string method, std::string metric, std::optional<double> value) {
  Measurement m;
  m.experiment = "e";
  m.view = "main";
  m.method = std::move(method);
  m.metric = std::move(metric);
  m.seed = m.metric == "rmse" ? "all" : "0";
  m.value = value;
  return m;
}

Measurement rmse(std::string method, std::string samples, std::string stage,
                 std::optional<double> value) {
  Measurement m = row(std::move(method), "rmse", value);
  m.parameters = {{"samples", std::move(samples)}, {"steps", "2"}};
  m.stage = std::move(stage);
  return m;
}

/// A reference of 512 of 4096 rays, and methods that are wrong by 0.5 to 0.05.
std::vector<Measurement> study(std::optional<double> half_width, double tolerance = 0.1) {
  return {rmse("ssao", "8", "filtered", 0.5),
          rmse("s3ho", "8", "unfiltered", 0.2),
          rmse("s3ho", "32", "filtered", 0.05),
          row("rtdo", "reference_interval", half_width),
          row("rtdo", "reference_tolerance", tolerance),
          row("rtdo", "reference_rays_per_pixel", 512),
          row("rtdo", "reference_max_rays_per_pixel", 4096)};
}

TEST(Certification, ComparesWithTheSmallestErrorOfAll) {
  const Certification good = *certify(study(0.004));
  EXPECT_TRUE(good.certified());
  EXPECT_FALSE(good.open());
  EXPECT_DOUBLE_EQ(*good.share(), 0.08);
  EXPECT_EQ(good.verdict(),
            "certified: the reference's 95% half-width is 8% of the smallest error (s3ho, samples "
            "32, filtered, rmse 0.05); 512 rays a pixel");
  EXPECT_TRUE(certify(study(0.005))->certified()) << "at most the tolerance";
  EXPECT_FALSE(certify(study(0.005001))->certified());
  EXPECT_TRUE(certify(study(0.01, 0.2))->certified());
}

TEST(Certification, WithoutAReferenceThereIsNothingToCertify) {
  EXPECT_FALSE(certify({rmse("ssao", "8", "filtered", 0.5)}));
  EXPECT_TRUE(reference_table({rmse("ssao", "8", "filtered", 0.5)}).rows.empty());
}

TEST(Certification, RegionsAndSingleSeedsAreNotJudged) {
  std::vector<Measurement> rows = study(0.004);
  rows.push_back(rmse("ssdo", "32", "filtered", 0.001));
  rows.back().view = view_of_region("main", "corner");
  rows.push_back(rmse("ssdo", "32", "filtered", 0.001));
  rows.back().seed = "3";
  EXPECT_EQ(*certify(rows)->smallest_error, 0.05);
}

TEST(Certification, AnErrorWithinTheReferencesNoiseIsNotKnown) {
  std::vector<Measurement> rows = study(0.004);
  rows.push_back(rmse("ssdo", "32", "filtered", std::nullopt));
  rows.back().reason = "the difference is within the reference's own noise (mean square 1, ...)";
  const Certification unknown = *certify(rows);
  EXPECT_FALSE(unknown.share());
  EXPECT_FALSE(unknown.certified());
  EXPECT_TRUE(unknown.open()) << "more rays may tell";
  EXPECT_EQ(more_rays(unknown, 512), 512) << "as many again";
  EXPECT_TRUE(unknown.verdict().starts_with(
      "NOT certified: ssdo, samples 32, filtered: the difference is within"))
      << unknown.verdict();
  // A test image that is not finite is no reason for more rays.
  rows.back().reason = "3 non-finite pixels in the test image";
  EXPECT_TRUE(certify(rows)->certified());
}

TEST(Certification, AReferenceWithoutVarianceIsNotCertified) {
  std::vector<Measurement> rows = study(std::nullopt);
  rows[3].reason = "method 'ssao' states no variance";
  const Certification unknown = *certify(rows);
  EXPECT_FALSE(unknown.certified());
  EXPECT_FALSE(unknown.open());
  EXPECT_EQ(more_rays(unknown, 512), 0);
  EXPECT_NE(unknown.verdict().find("NOT certified: method 'ssao' states no variance"),
            std::string::npos);
  const Table table = reference_table(rows);
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(std::get<std::string>(table.rows[0].back()), "no");
}

TEST(Certification, AnEndedBudgetIsSaid) {
  std::vector<Measurement> rows = study(0.0085);
  rows[5].value = 4096;
  const Certification ended = *certify(rows);
  EXPECT_FALSE(ended.open());
  EXPECT_EQ(more_rays(ended, 512), 0);
  EXPECT_EQ(ended.verdict(),
            "NOT certified: the reference's 95% half-width is 17% of the smallest error (s3ho, "
            "samples 32, filtered, rmse 0.05); 4096 rays a pixel, more than 10%; the budget of "
            "4096 rays a pixel ended");
  EXPECT_EQ(reference_table(rows).notes.front(), ended.verdict());
  EXPECT_EQ(to_json(ended)["certified"], false);
  EXPECT_EQ(to_json(ended)["verdict"], ended.verdict());
}

TEST(Certification, MoreRaysAsTheIntervalNeedsThem) {
  EXPECT_EQ(more_rays(*certify(study(0.004)), 512), 0) << "certified";
  // 11% instead of 10%: 1.05 1.21 of 512 rays, in steps.
  EXPECT_EQ(more_rays(*certify(study(0.0055)), 64), 192);
  EXPECT_EQ(more_rays(*certify(study(0.0055)), 512), 512);
  EXPECT_EQ(more_rays(*certify(study(0.05)), 512), 1536) << "three times as many at most";
  std::vector<Measurement> rows = study(0.05);
  rows[6].value = 600;
  EXPECT_EQ(more_rays(*certify(rows), 512), 88) << "what the budget leaves";
}

Layers reference_of(float radiance, float variance, float occlusion) {
  Layers layers;
  layers.add("radiance", Image(4, 2, 3, radiance));
  layers.add("radiance_variance", Image(4, 2, 3, variance));
  layers.add("ambient_occlusion", Image(4, 2, 1, occlusion));
  Image mask(4, 2, 1, 1.0f);
  mask.at(0, 0) = 0.0f;
  layers.add("mask", std::move(mask));
  return layers;
}

class OfReference : public testing::Test {
 protected:
  PlannedCell planned() const {
    ParameterSet parameters(method_.parameters);
    parameters.set("rays_per_pixel", 512L);
    return {Role::reference, "rtdo", parameters, 0};
  }
  std::vector<Measurement> rows(const Layers& layers, const ReferenceSettings& settings) const {
    const PlannedCell cell = planned();
    return reference_rows({cell, "id"}, layers, settings, {});
  }

  const MethodInfo& method_ = find_method("rtdo");
};

TEST_F(OfReference, IntervalIsOfTheSurfacesMeanVariance) {
  Layers layers = reference_of(2.0f, 0.01f, 1.0f);
  const std::vector<Measurement> found = rows(
      layers, {.method = "rtdo", .parameters = {}, .tolerance = 0.1, .max_rays_per_pixel = 900});
  EXPECT_EQ(found[0].metric, "reference_interval");
  EXPECT_NEAR(*found[0].value, 1.96 * 0.1 / 2.0, 1e-5);
  EXPECT_EQ(found[0].n, 7);
  EXPECT_EQ(*found[1].value, 0.1);
  EXPECT_EQ(*found[2].value, 512);
  EXPECT_EQ(*found[3].value, 900);
  EXPECT_EQ(
      *rows(layers,
            {.method = "rtdo", .parameters = {}, .tolerance = 0.1, .max_rays_per_pixel = {}})[3]
           .value,
      512)
      << "without a budget the rays are fixed";
}

TEST_F(OfReference, ThatIsNotFiniteIsRefused) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const Layers& layers : {reference_of(nan, 0.01f, 1.0f), reference_of(2.0f, nan, 1.0f),
                               reference_of(2.0f, -1.0f, 1.0f), reference_of(0.0f, 0.01f, 1.0f)}) {
    EXPECT_THROW(
        rows(layers,
             {.method = "rtdo", .parameters = {}, .tolerance = 0.1, .max_rays_per_pixel = {}}),
        InputError);
  }
}

TEST(MergedReferences, WeighByTheirRays) {
  // 512 rays and 1536: the variances are those of the same pixel, so that of the mean is a quarter
  // of the first.
  const Layers merged = merge_references(reference_of(1.0f, 0.04f, 0.2f), 512,
                                         reference_of(2.0f, 0.04f / 3, 0.6f), 1536);
  EXPECT_FLOAT_EQ(merged.at("radiance").at(1, 1, 2), 1.75f);
  EXPECT_FLOAT_EQ(merged.at("radiance_variance").at(1, 1, 0), 0.01f);
  EXPECT_FLOAT_EQ(merged.at("ambient_occlusion").at(1, 1), 0.5f);
  EXPECT_EQ(merged.at("mask").at(0, 0), 0.0f);
  EXPECT_EQ(merged.at("mask").at(1, 0), 1.0f);
}

}  // namespace
}  // namespace occlab
