#include "harness/metrics/noise_bias.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

Image scalars(const std::vector<float>& values) {
  Image image(static_cast<int>(values.size()), 1, 1);
  for (std::size_t i = 0; i < values.size(); ++i) image.values()[i] = values[i];
  return image;
}

RunStatistics gathered(const Image& mask, const std::vector<Image>& runs) {
  RunStatistics statistics(mask);
  for (const Image& run : runs) statistics.add(run);
  return statistics;
}

TEST(NoiseBias, ByHand) {
  // Two foreground pixels, references 1 and 3 of mean 2; the third lies outside the mask.
  const Image mask = scalars({1, 1, 0});
  const Image reference = scalars({1, 3, std::nanf("")});
  const RunStatistics runs = gathered(mask, {scalars({2, 3, 7}), scalars({4, 3, std::nanf("")})});
  // Pixel one: mean 3, s^2 = 2, (mean - r)^2 - s^2/2 = 3, mean of (x - r)^2 = 5. Pixel two:
  // nothing.
  const NoiseBias result = noise_and_bias(runs, reference);
  EXPECT_EQ(result.runs, 2);
  EXPECT_EQ(result.pixels, 2u);
  EXPECT_DOUBLE_EQ(result.mean_luminance, 2.0);
  EXPECT_DOUBLE_EQ(result.noise_squared.value.value(), 2.0 / 2 / 4);
  EXPECT_DOUBLE_EQ(result.noise.value.value(), 0.5);
  EXPECT_DOUBLE_EQ(result.bias_squared.value.value(), 3.0 / 2 / 4);
  EXPECT_DOUBLE_EQ(result.bias.value.value(), std::sqrt(0.375));
  EXPECT_DOUBLE_EQ(result.mse.value.value(), 5.0 / 2 / 4);
  EXPECT_FALSE(result.noise.interval.has_value());  // two runs leave none

  const Image variance = scalars({1, 0.5f, -1});
  const NoiseBias corrected = noise_and_bias(runs, reference, &variance);
  EXPECT_DOUBLE_EQ(corrected.bias_squared.value.value(), (3.0 - 1.5) / 2 / 4);
  EXPECT_DOUBLE_EQ(corrected.mse.value.value(), (5.0 - 1.5) / 2 / 4);
  EXPECT_DOUBLE_EQ(corrected.noise.value.value(), 0.5);
}

TEST(NoiseBias, UnresolvedBiasKeepsItsSignedSquare) {
  const NoiseBias result = noise_and_bias(
      gathered(scalars({1}), {scalars({1}), scalars({3}), scalars({2})}), scalars({2}));
  EXPECT_NEAR(result.bias_squared.value.value(), -1.0 / 3 / 4, 1e-15);
  EXPECT_FALSE(result.bias.value.has_value());
  EXPECT_NE(result.bias.reason.find("do not resolve"), std::string::npos);
  ASSERT_TRUE(result.bias.interval.has_value());
  EXPECT_EQ(result.bias.interval->low, 0.0);
  EXPECT_GT(result.bias.interval->high, 0.0);
}

TEST(NoiseBias, RunsThatDoNotDifferHaveNoNoise) {
  const Image mask = scalars({1, 1});
  const Image image = scalars({0.1f, 0.7f});
  const NoiseBias result =
      noise_and_bias(gathered(mask, {image, image, image, image}), scalars({0.3f, 0.3f}));
  EXPECT_EQ(result.noise.value.value(), 0.0);
  EXPECT_EQ(result.noise.interval->low, 0.0);
  EXPECT_EQ(result.noise.interval->high, 0.0);
  EXPECT_NEAR(result.bias_squared.value.value(), (0.04 + 0.16) / 2 / 0.09, 1e-6);
  const Estimate ratio = noise_ratio(result, result);
  EXPECT_FALSE(ratio.value.has_value());
  EXPECT_FALSE(ratio.reason.empty());
}

std::vector<Image> random_runs(int count, int width, int height, int channels, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<float> value(0.0f, 2.0f);
  std::vector<Image> runs(static_cast<std::size_t>(count), Image(width, height, channels));
  for (Image& run : runs) {
    for (float& v : run.values()) v = value(engine);
  }
  return runs;
}

TEST(NoiseBias, MeanSquareErrorIsBiasAndPopulationVariance) {
  const int count = 5;
  const std::vector<Image> runs = random_runs(count + 1, 9, 7, 3, 3);
  const Image& reference = runs.back();
  const Image mask(9, 7, 1, 1.0f);
  const RunStatistics statistics = gathered(mask, std::vector<Image>(runs.begin(), runs.end() - 1));
  const Image mean = statistics.mean();
  const Image variance = statistics.variance();
  double direct = 0.0;
  double bias = 0.0;
  double population = 0.0;
  const auto values = static_cast<double>(mean.values().size());
  for (std::size_t v = 0; v < mean.values().size(); ++v) {
    const double r = reference.values()[v];
    for (int k = 0; k < count; ++k) {
      const double e = runs[static_cast<std::size_t>(k)].values()[v] - r;
      direct += e * e / (count * values);
    }
    bias += (mean.values()[v] - r) * (mean.values()[v] - r) / values;
    population += variance.values()[v] * (count - 1.0) / count / values;
  }
  EXPECT_NEAR(direct, bias + population, 1e-6);

  const NoiseBias result = noise_and_bias(statistics, reference);
  const double unit = result.mean_luminance * result.mean_luminance;
  EXPECT_NEAR(*result.mse.value * unit, direct, 1e-12);
  EXPECT_NEAR(*result.noise_squared.value * unit, population * count / (count - 1.0), 1e-6);
  EXPECT_NEAR(*result.bias_squared.value * unit, bias - population / (count - 1.0), 1e-6);
}

TEST(NoiseBias, LeavingARunOutIsMeasuringTheOthers) {
  const std::vector<Image> runs = random_runs(6, 4, 4, 3, 5);
  const Image mask(4, 4, 1, 1.0f);
  const Image reference(4, 4, 3, 1.0f);
  const NoiseBias all = noise_and_bias(gathered(mask, runs), reference);
  ASSERT_EQ(all.noise_squared_without.size(), 6u);
  for (std::size_t left_out = 0; left_out < 6; ++left_out) {
    std::vector<Image> others = runs;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(left_out));
    const NoiseBias without = noise_and_bias(gathered(mask, others), reference);
    EXPECT_NEAR(all.noise_squared_without[left_out], *without.noise_squared.value, 1e-14);
    EXPECT_NEAR(all.bias_squared_without[left_out], *without.bias_squared.value, 1e-14);
  }
}

TEST(NoiseBias, StatisticsOfMaskedPixelsAreZero) {
  const RunStatistics runs = gathered(scalars({0, 1, 0}), {scalars({5, 2, 5}), scalars({9, 6, 9})});
  EXPECT_EQ(runs.mean(), scalars({0, 4, 0}));
  EXPECT_EQ(runs.variance(), scalars({0, 8, 0}));
}

TEST(NoiseBias, FailuresAreEmptyWithAReason) {
  const Image mask = scalars({1, 1});
  const Image good = scalars({1, 2});
  const Image bad = scalars({1, std::numeric_limits<float>::infinity()});
  const NoiseBias failed = noise_and_bias(gathered(mask, {good, bad, good}), good);
  const NoiseBias black = noise_and_bias(gathered(mask, {good, good}), scalars({0, 0}));
  for (const Estimate* e :
       {&failed.noise, &failed.noise_squared, &failed.bias, &failed.bias_squared, &failed.mse}) {
    EXPECT_FALSE(e->value.has_value());
    EXPECT_FALSE(e->interval.has_value());
    EXPECT_EQ(e->reason, "1 non-finite values in 3 runs");
  }
  EXPECT_FALSE(black.noise.value.has_value());
  EXPECT_NE(black.noise.reason.find("mean luminance"), std::string::npos);
  const NoiseBias measured = noise_and_bias(gathered(mask, {good, good, good}), good);
  EXPECT_EQ(noise_ratio(failed, measured).reason, failed.noise.reason);
  EXPECT_EQ(noise_ratio(measured, failed).reason, failed.noise.reason);
  EXPECT_EQ(bias_squared_difference(measured, failed).reason, failed.noise.reason);
}

TEST(NoiseBias, RefusesBadInput) {
  const Image mask = scalars({1, 1});
  const Image good = scalars({1, 2});
  const Image bad = scalars({1, std::nanf("")});
  const Image negative = scalars({1, -1});
  EXPECT_THROW(RunStatistics(scalars({0, 0})), InputError);
  EXPECT_THROW(RunStatistics(Image(2, 1, 3, 1.0f)), InputError);
  RunStatistics runs(mask);
  EXPECT_THROW(runs.mean(), InputError);
  EXPECT_THROW(runs.add(scalars({1})), InputError);
  EXPECT_THROW(runs.add(Image(2, 1, 2)), InputError);
  runs.add(good);
  EXPECT_THROW(runs.variance(), InputError);
  EXPECT_THROW(runs.add(Image(2, 1, 3)), InputError);
  EXPECT_THROW(noise_and_bias(runs, good), InputError);
  runs.add(good);
  EXPECT_EQ(runs.runs(), 2);
  EXPECT_NO_THROW(noise_and_bias(runs, good));
  EXPECT_THROW(noise_and_bias(runs, bad), InputError);
  EXPECT_THROW(noise_and_bias(runs, scalars({1, 2, 3})), InputError);
  EXPECT_THROW(noise_and_bias(runs, Image(2, 1, 3, 1.0f)), InputError);
  EXPECT_THROW(noise_and_bias(runs, good, &bad), InputError);
  EXPECT_THROW(noise_and_bias(runs, good, &negative), InputError);
  const NoiseBias two = noise_and_bias(runs, good);
  const NoiseBias three = noise_and_bias(gathered(mask, {good, good, good}), good);
  EXPECT_THROW(noise_ratio(two, three), InputError);
}

// Two methods with known noise and bias, rendered with the same seeds: in run k
//   x_a = truth + bias + shared u_k pattern + own e,   x_b = truth + bias + ratio (the same, other
//   e)
// where u_k is one number a run, as from a sample set that all pixels share.
struct Model {
  int runs = 8;
  int pixels = 12;
  double bias = 0.3;
  double own_noise = 0.5;
  double shared_noise = 0.0;
  double ratio = 0.5;
  double reference_noise = 0.2;

  double truth(int pixel) const { return 1.0 + 0.5 * std::sin(pixel); }
  double pattern(int pixel) const { return 1.0 + 0.3 * std::cos(3.0 * pixel); }
  double noise_squared() const {  // of x_a
    double sum = 0.0;
    for (int p = 0; p < pixels; ++p) sum += pattern(p) * pattern(p);
    return own_noise * own_noise + shared_noise * shared_noise * sum / pixels;
  }
};

struct Trial {
  Image reference;
  NoiseBias a;
  NoiseBias b;
};

class Simulation {
 public:
  Simulation(const Model& model, unsigned seed) : model_(model), engine_(seed) {}

  Trial next() {
    const Image mask(model_.pixels, 1, 1, 1.0f);
    const Image variance(model_.pixels, 1, 1,
                         float(model_.reference_noise * model_.reference_noise));
    Image reference(model_.pixels, 1, 1);
    for (int p = 0; p < model_.pixels; ++p) {
      reference.at(p, 0) = float(model_.truth(p) + model_.reference_noise * normal_(engine_));
    }
    RunStatistics a(mask);
    RunStatistics b(mask);
    for (int k = 0; k < model_.runs; ++k) {
      const double u = model_.shared_noise * normal_(engine_);
      a.add(run(u, 1.0));
      b.add(run(u, model_.ratio));
    }
    return {reference, noise_and_bias(a, reference, &variance),
            noise_and_bias(b, reference, &variance)};
  }

 private:
  Image run(double u, double scale) {
    Image image(model_.pixels, 1, 1);
    for (int p = 0; p < model_.pixels; ++p) {
      // Exponential: skewed, as errors under a probe with a small sun are.
      const double own = model_.own_noise * (exponential_(engine_) - 1.0);
      image.at(p, 0) = float(model_.truth(p) + model_.bias + scale * (model_.pattern(p) * u + own));
    }
    return image;
  }

  Model model_;
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
  std::exponential_distribution<double> exponential_;
};

TEST(NoiseBiasSimulation, EstimatesAreUnbiased) {
  constexpr int trials = 20000;
  constexpr double false_alarms = 1e-6;  // of the four tests together
  const Model model{.shared_noise = 0.2};
  Simulation simulation(model, 17);
  std::vector<double> noise;
  std::vector<double> bias;
  std::vector<double> mse;
  std::vector<double> difference;
  for (int t = 0; t < trials; ++t) {
    const Trial trial = simulation.next();
    // The divisor is noisy too; with it taken back the estimates are unbiased.
    const double unit = trial.a.mean_luminance * trial.a.mean_luminance;
    noise.push_back(*trial.a.noise_squared.value * unit);
    bias.push_back(*trial.a.bias_squared.value * unit);
    mse.push_back(*trial.a.mse.value * unit);
    difference.push_back(*bias_squared_difference(trial.a, trial.b).value * unit);
  }
  const auto unbiased = [&](const std::vector<double>& estimates, double expected) {
    const double error = std::sqrt(variance(estimates) / trials);
    const ZTest test = z_test(mean(estimates), expected, error, false_alarms, 4);
    return (test.passes ? testing::AssertionSuccess() : testing::AssertionFailure())
           << mean(estimates) << " for " << expected << ", z = " << test.z;
  };
  EXPECT_TRUE(unbiased(noise, model.noise_squared()));
  EXPECT_TRUE(unbiased(bias, model.bias * model.bias));
  EXPECT_TRUE(unbiased(mse, model.noise_squared() + model.bias * model.bias));
  EXPECT_TRUE(unbiased(difference, 0.0));
}

// How often the nominal 95% intervals hold the truth.
struct Coverage {
  double noise = 0.0;
  double bias_squared = 0.0;
  double ratio = 0.0;
  double difference = 0.0;
};

Coverage coverage_of(const Model& model, unsigned seed) {
  constexpr int trials = 4000;
  Simulation simulation(model, seed);
  Coverage hits;
  for (int t = 0; t < trials; ++t) {
    const Trial trial = simulation.next();
    const double unit = trial.a.mean_luminance;
    const auto hit = [](const std::optional<Interval>& interval, double truth) {
      return interval.value().contains(truth) ? 1.0 / trials : 0.0;
    };
    hits.noise += hit(trial.a.noise.interval, std::sqrt(model.noise_squared()) / unit);
    hits.bias_squared +=
        hit(trial.a.bias_squared.interval, model.bias * model.bias / (unit * unit));
    hits.ratio += hit(noise_ratio(trial.b, trial.a).interval, model.ratio);
    hits.difference += hit(bias_squared_difference(trial.a, trial.b).interval, 0.0);
  }
  testing::Test::RecordProperty("noise", std::to_string(hits.noise));
  testing::Test::RecordProperty("bias_squared", std::to_string(hits.bias_squared));
  testing::Test::RecordProperty("ratio", std::to_string(hits.ratio));
  testing::Test::RecordProperty("difference", std::to_string(hits.difference));
  return hits;
}

// The bounds are what the header promises, give or take 4000 trials: a standard error of 0.4%.
TEST(NoiseBiasCoverage, IndependentPixels) {
  for (const double bias : {0.0, 0.3}) {
    const Coverage c = coverage_of({.pixels = 64, .bias = bias}, 21);
    EXPECT_GE(c.noise, 0.925);
    EXPECT_LE(c.noise, 0.965);
    EXPECT_GE(c.ratio, 0.925);
    EXPECT_LE(c.ratio, 0.965);
    // On the safe side, as the reference's noise is counted in full.
    EXPECT_GE(c.bias_squared, 0.94);
    EXPECT_GE(c.difference, 0.94);
  }
}

TEST(NoiseBiasCoverage, PixelsThatShareTheirNoise) {
  // The hardest case: a run's error is almost one number, about as large as the bias. Pixels taken
  // for independent would promise an interval of the noise several times too short.
  const Coverage c = coverage_of({.pixels = 16, .own_noise = 0.1, .shared_noise = 0.5}, 22);
  EXPECT_GE(c.noise, 0.91);
  EXPECT_LE(c.noise, 0.965);
  EXPECT_GE(c.ratio, 0.91);
  EXPECT_LE(c.ratio, 0.965);
  EXPECT_GE(c.bias_squared, 0.83);
  EXPECT_GE(c.difference, 0.94);
}

}  // namespace
}  // namespace occlab
