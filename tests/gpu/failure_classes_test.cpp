// Why the march and the rays disagree: scenes in which one class alone can happen, and the sum of
// all; what a converged run says of its own error.

#include "renderers/methods/failure_classes.h"

#include <gtest/gtest.h>

#include "tests/gpu/gpu_frame.h"

namespace occlab::test {
namespace {

constexpr std::size_t class_count = failure_class_names.size();

/// Of SSAO's defaults with d_max and S.
PassConstants constants_of(double d_max, long steps) {
  ParameterSet parameters(find_method("ssao").parameters);
  parameters.set("d_max_world", d_max);
  parameters.set("steps", steps);
  return pass_constants(parameters);
}

constexpr Convergence one_round = {
    .tolerance = 1.0, .budget_seconds = 0.0, .first_round = 64, .seed = 7};

Failures classify(const TestFrame& test, const PassConstants& constants,
                  const HiddenImages* hidden = nullptr) {
  const Frame& frame = test.frame();
  return classify_failures(test.surface(), frame.view, frame.traced(), frame.lighting, constants,
                           one_round, hidden);
}

const HiddenImages& hidden_of(const TestFrame& test, HiddenKind kind, int count) {
  return test.frame().hidden_images({.kind = kind, .count = count, .complete = true});
}

/// Each class's sum of k_A over the pixels, of either sign apart.
struct ClassTotals {
  std::array<double, class_count> leak{};
  std::array<double, class_count> loss{};

  explicit ClassTotals(const Failures& failures) {
    for (std::size_t c = 0; c < class_count; ++c) {
      for (const float value : failures.classes[c].occlusion.values()) {
        (value > 0.0f ? leak : loss)[c] += std::abs(double(value));
      }
    }
  }
  double all() const {
    double sum = 0.0;
    for (std::size_t c = 0; c < class_count; ++c) sum += leak[c] + loss[c];
    return sum;
  }
  double leak_share(FailureClass c) const { return leak[std::size_t(c)] / all(); }
  double loss_share(FailureClass c) const { return loss[std::size_t(c)] / all(); }
};

Mesh floor_quad(float size) { return quad({-size, 0, -size}, {0, 0, 2 * size}, {2 * size, 0, 0}); }

TEST(FailureClasses, ABlockerOffTheScreen) {
  const TestFrame frame(floor_and_tall_wall(), look_at({1.2f, 1.5f, 0}, {1.0f, 0, 0}, 0.4f, 48, 32),
                        constant_environment(glm::vec3(1.0f)));
  const ClassTotals totals(classify(frame, constants_of(5.0, 64)));
  EXPECT_GT(totals.all(), 10.0);
  EXPECT_EQ(totals.leak_share(FailureClass::off_screen), 1.0);
}

TEST(FailureClasses, StepsThatMissAWallInFullView) {
  const TestFrame frame(floor_and_tall_wall(), look_at({8, 3.2f, 0}, {0, 1.0f, 0}, 0.6f, 96, 64),
                        constant_environment(glm::vec3(1.0f)));
  const ClassTotals few(classify(frame, constants_of(0.7, 1)));
  EXPECT_GT(few.leak_share(FailureClass::thin), 0.75);
  const ClassTotals many(classify(frame, constants_of(0.7, 64)));
  const auto thin = std::size_t(FailureClass::thin);
  EXPECT_LT(many.leak[thin], 0.15 * few.leak[thin]);
}

/// A plate between the camera and the air above the floor, far below d_max away from the floor's
/// points, whose rays up pass behind it.
SceneBuilder plate_before_floor() {
  SceneBuilder scene;
  scene.add(floor_quad(4.0f));
  scene.add(quad({-1.0f, 0.6f, 1.0f}, {2.0f, 0, 0}, {0, 1.0f, 0}));
  return scene;
}

View along_the_floor() { return look_at({0, 0.6f, 6.0f}, {0, 0.5f, 0}, 0.5f, 64, 64); }
View from_above() { return look_at({0, 3.0f, 6.0f}, {0, 0.2f, 0}, 0.5f, 96, 96); }

TEST(FailureClasses, FreeRaysBehindAPlate) {
  const TestFrame frame(plate_before_floor().build(), from_above(),
                        constant_environment(glm::vec3(1.0f)));
  const ClassTotals totals(classify(frame, constants_of(3.0, 32)));
  EXPECT_GT(totals.all(), 1.0);
  EXPECT_GT(totals.loss_share(FailureClass::behind_surface), 0.7);
  EXPECT_LT(totals.loss_share(FailureClass::beyond_radius), 0.02) << "the floor's far end";
}

TEST(FailureClasses, WhatTheRayMeetsIsBeyondTheRadius) {
  SceneBuilder scene = plate_before_floor();
  // A sky of surface, farther than d_max from everything that is seen.
  scene.add(sphere_part({0, 0, 0}, 60.0, 0.0, pi_d, 24));
  const TestFrame frame(scene.build(), from_above(), constant_environment(glm::vec3(1.0f)));
  const ClassTotals totals(classify(frame, constants_of(3.0, 32)));
  EXPECT_GT(totals.loss_share(FailureClass::beyond_radius), 0.5);
  EXPECT_EQ(totals.loss_share(FailureClass::behind_surface), 0.0);
}

TEST(FailureClasses, ABlockerHiddenBehindAFartherPlate) {
  // The roof over the floor is hidden by a plate near the camera, which is farther than d_max.
  SceneBuilder scene;
  scene.add(floor_quad(4.0f));
  scene.add(quad({-3.0f, 0.8f, -3.0f}, {0, 0, 4.0f}, {6.0f, 0, 0}));
  scene.add(quad({-1.0f, 0.58f, 5.0f}, {2.0f, 0, 0}, {0, 1.0f, 0}));
  const TestFrame frame(scene.build(), along_the_floor(), constant_environment(glm::vec3(1.0f)));
  const ClassTotals totals(classify(frame, constants_of(1.5, 32)));
  EXPECT_GT(totals.all(), 1.0);
  EXPECT_GT(totals.leak_share(FailureClass::hidden_blocker), 0.5);
}

/// Through the first surfaces, and the hidden ones if they are asked for.
void expect_sum(const std::optional<HiddenSettings>& settings) {
  const TestFrame frame(plate_before_floor().build(), along_the_floor(),
                        probe_of(32, [](glm::vec3 d) { return glm::vec3(1.0f + d.y, 1, 2); }));
  const PassConstants constants = constants_of(2.0, 2);
  const HiddenImages* const hidden = settings ? &frame.frame().hidden_images(*settings) : nullptr;
  const Failures failures = classify(frame, constants, hidden);
  const CpuLighting lighting(frame.frame().lighting, constants);
  const Representation& representation = *find_method("ssdo").representation;
  const auto lit = [&](const VisibilitySource& visibility) {
    const DirectionPass pass{frame.surface(), lighting, constants, visibility};
    Image sums(frame.width(), frame.height(), 3);
    const std::array<const Representation*, 1> one = {&representation};
    for (const std::uint64_t seed : {one_round.seed, one_round.seed + 1}) {
      add_directions(pass, make_sample_set(one_round.first_round, seed), TurnPattern::tiles, one,
                     std::span(&sums, 1));
    }
    return light_on_cpu(representation,
                        representation_of(representation, sums, 2 * one_round.first_round),
                        frame.surface(), lighting);
  };
  const Image depth = lit(depth_visibility(frame.surface(), frame.frame().view, constants, hidden));
  const Image traced =
      lit(traced_visibility(frame.frame().traced(), frame.frame().view, constants));
  double largest = 0.0;
  for (std::size_t i = 0; i < depth.values().size(); ++i) {
    float sum = 0.0f;
    for (const FailureMaps& maps : failures.classes) sum += maps.radiance.values()[i];
    const float difference = depth.values()[i] - traced.values()[i];
    EXPECT_NEAR(sum, difference, 2e-6f);
    largest = std::max(largest, double(std::abs(difference)));
  }
  EXPECT_GT(largest, 0.1);
}

TEST(FailureClasses, AddUpToTheMarchLessTheRays) {
  expect_sum(std::nullopt);
  expect_sum(HiddenSettings{.kind = HiddenKind::layers, .count = 3, .complete = true});
  expect_sum(HiddenSettings{.kind = HiddenKind::cameras, .count = 2, .complete = true});
}

TEST(FailureClasses, LayersTakeAwayWhatIsLostBehindASlab) {
  SceneBuilder scene;
  scene.add_box({-4, -1, -4}, {4, 0, 4}).add_box({-1, 0.6f, 0.95f}, {1, 1.6f, 1.05f});
  const TestFrame frame(scene.build(), from_above(), constant_environment(glm::vec3(1.0f)));
  const PassConstants constants = constants_of(3.0, 64);
  const auto behind = std::size_t(FailureClass::behind_surface);
  const ClassTotals one(classify(frame, constants));
  const ClassTotals two(classify(frame, constants, &hidden_of(frame, HiddenKind::layers, 1)));
  EXPECT_GT(one.loss[behind], 10.0);
  EXPECT_LT(two.loss[behind], 0.02 * one.loss[behind]);
  EXPECT_LT(two.all(), 0.5 * one.all());
}

TEST(FailureClasses, LayersShowABlockerThatIsHidden) {
  // As above, of solids: the roof is the second one of its pixels.
  SceneBuilder scene;
  scene.add_box({-4, -1, -4}, {4, 0, 4}).add_box({-3, 0.8f, -3}, {3, 0.9f, 1});
  scene.add_box({-1, 0.58f, 5.0f}, {1, 1.58f, 5.05f});
  const TestFrame frame(scene.build(), along_the_floor(), constant_environment(glm::vec3(1.0f)));
  const PassConstants constants = constants_of(1.5, 32);
  const auto hidden = std::size_t(FailureClass::hidden_blocker);
  const ClassTotals one(classify(frame, constants));
  const ClassTotals four(classify(frame, constants, &hidden_of(frame, HiddenKind::layers, 3)));
  EXPECT_GT(one.leak[hidden], 10.0);
  EXPECT_LT(four.leak[hidden], 0.1 * one.leak[hidden]);
}

TEST(Converged, SaysHowFarItIsFromItsLimit) {
  // Over independent runs, the mean square of the stated error is the variance of the radiance.
  const TestFrame frame(floor_and_tall_wall(), look_at({4, 3, 0}, {0, 0.5f, 0}, 0.6f, 48, 32),
                        probe_of(64, [](glm::vec3 d) { return glm::vec3(d.y > 0.7f ? 4 : 1); }));
  std::vector<ConvergedMethod> methods;
  for (const MethodInfo& info : occlab::methods()) {
    if (info.representation) methods.push_back({info.representation, constants_of(1.0, 2)});
  }
  constexpr int runs = 24;
  std::vector<std::vector<Converged>> results;
  for (int run = 0; run < runs; ++run) {
    Convergence convergence = one_round;
    convergence.seed = 100 + std::uint64_t(run) * 10;
    results.push_back(
        converge(frame.surface(), frame.frame().lighting,
                 depth_visibility(frame.surface(), frame.frame().view, methods.front().constants),
                 methods, convergence));
  }
  for (std::size_t m = 0; m < methods.size(); ++m) {
    double stated = 0.0, variance = 0.0, luminance = 0.0;
    std::size_t values = 0;
    for (std::size_t i = 0; i < results[0][m].radiance.values().size(); ++i) {
      if (frame.surface().mask.values()[i / 3] < 0.5f) continue;
      double sum = 0.0, squares = 0.0;
      for (const auto& run : results) {
        const double value = double(run[m].radiance.values()[i]);
        sum += value;
        squares += value * value;
      }
      variance += (squares - sum * sum / runs) / (runs - 1);
      luminance += sum / runs;
      ++values;
    }
    for (const auto& run : results) stated += run[m].standard_error * run[m].standard_error / runs;
    const double mean = luminance / double(values);
    // 24 runs of 1536 correlated pixels: the ratio scatters by some 5%; 30% is six of those.
    EXPECT_NEAR(stated / (variance / double(values) / (mean * mean)), 1.0, 0.3) << m;
    EXPECT_EQ(results[0][m].directions, 2 * one_round.first_round);
    EXPECT_TRUE(results[0][m].reached);
  }
}

TEST(Converged, SaysWhenTheBudgetEnded) {
  const TestFrame frame(floor_and_tall_wall(), look_at({4, 3, 0}, {0, 0.5f, 0}, 0.6f, 16, 16),
                        constant_environment(glm::vec3(1.0f)));
  const PassConstants constants = constants_of(1.0, 2);
  const std::vector<Converged> result = converge(
      frame.surface(), frame.frame().lighting,
      depth_visibility(frame.surface(), frame.frame().view, constants),
      {{find_method("ssdo").representation, constants}}, {.tolerance = 1e-9, .budget_seconds = 0});
  EXPECT_FALSE(result.front().reached);
  EXPECT_GT(result.front().standard_error, 1e-9);
}

}  // namespace
}  // namespace occlab::test
