// The power spectrum against closed forms, a sum written out, and simulated noise.
#include "harness/metrics/power_spectrum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <random>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr double tau = 2.0 * std::numbers::pi;

std::vector<float> white_noise(std::mt19937_64& random, int count, float deviation) {
  std::normal_distribution<float> normal(0.0f, deviation);
  std::vector<float> field(std::size_t(count), 0.0f);
  for (float& value : field) value = normal(random);
  return field;
}

double mean_square(const std::vector<float>& field) {
  double sum = 0.0;
  for (const float value : field) sum += double(value) * double(value);
  return sum / double(field.size());
}

double mean_power(const std::vector<SpectrumBin>& spectrum) {
  double sum = 0.0;
  long count = 0;
  for (const SpectrumBin& bin : spectrum) {
    sum += bin.power * double(bin.count);
    count += bin.count;
  }
  return sum / double(count);
}

Image image_of(const std::vector<float>& field, int width, int height) {
  Image image(width, height, 1);
  std::ranges::copy(field, image.values().begin());
  return image;
}

TEST(PowerSpectrum, AddsUpToTheVariance) {
  std::mt19937_64 random(1);
  for (const auto& [width, height] : {std::pair{160, 90}, std::pair{45, 31}, std::pair{1, 7}}) {
    const std::vector<float> field = white_noise(random, width * height, 0.3f);
    const auto spectrum = radial_spectra({{field}}, width, height, width * height).front();
    long count = 0;
    for (const SpectrumBin& bin : spectrum) count += bin.count;
    EXPECT_EQ(count, width * height);
    EXPECT_NEAR(mean_power(spectrum) / mean_square(field), 1.0, 1e-6);
  }
}

TEST(PowerSpectrum, ASineIsAtItsFrequency) {
  constexpr int width = 128;
  constexpr int height = 64;
  std::vector<float> field;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      field.push_back(float(std::sin(tau * (13.0 * x / width + 9.0 * y / height) + 0.7)));
    }
  }
  const double frequency = std::hypot(13.0 / width, 9.0 / height);
  const auto spectrum = radial_spectra({{field}}, width, height, width * height).front();
  for (const SpectrumBin& bin : spectrum) {
    const double total = bin.power * double(bin.count) / (width * height);
    const bool here = std::abs(bin.frequency - frequency) <= 0.5 * spectrum_bin_width;
    EXPECT_NEAR(total, here ? 0.5 : 0.0, 1e-6) << "at " << bin.frequency;
  }
}

TEST(PowerSpectrum, IsTheSumWrittenOut) {
  constexpr int width = 7;
  constexpr int height = 6;
  std::mt19937_64 random(2);
  const std::vector<float> field = white_noise(random, width * height, 1.0f);
  const auto spectrum = radial_spectra({{field}}, width, height, 10.0).front();
  for (const SpectrumBin& bin : spectrum) {
    double sum = 0.0;
    long count = 0;
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const double radius = std::hypot(double(std::min(u, width - u)) / width,
                                         double(std::min(v, height - v)) / height);
        if (int(radius / spectrum_bin_width) != int(bin.frequency / spectrum_bin_width)) continue;
        std::complex<double> amplitude = 0.0;
        for (int y = 0; y < height; ++y) {
          for (int x = 0; x < width; ++x) {
            amplitude += double(field[std::size_t(y) * std::size_t(width) + std::size_t(x)]) *
                         std::polar(1.0, -tau * (double(u * x) / width + double(v * y) / height));
          }
        }
        sum += std::norm(amplitude) / 10.0;
        ++count;
      }
    }
    EXPECT_EQ(bin.count, count);
    EXPECT_NEAR(bin.power, sum / double(count), 1e-5 * sum) << "at " << bin.frequency;
  }
}

TEST(PowerSpectrum, FieldsAreToldApart) {
  constexpr int width = 33;
  constexpr int height = 20;
  std::mt19937_64 random(3);
  std::vector<std::vector<float>> fields;
  for (const float deviation : {1.0f, 0.01f, 3.0f}) {
    fields.push_back(white_noise(random, width * height, deviation));
  }
  const auto together = radial_spectra(fields, width, height, width * height);
  ASSERT_EQ(together.size(), 3u);
  for (std::size_t k = 0; k < fields.size(); ++k) {
    const auto alone = radial_spectra({&fields[k], 1}, width, height, width * height).front();
    for (std::size_t bin = 0; bin < alone.size(); ++bin) {
      EXPECT_NEAR(together[k][bin].power, alone[bin].power, 2e-4 * alone[bin].power);
    }
  }
}

// |F|^2 of c frequencies of white noise is chi-square with c degrees of freedom, of which
// Wilson and Hilferty's cube root is normal to better than 1e-2 sigma from 50 degrees on. False
// alarms: 46 two-sided tests at 5.6 sigma, one in a million runs.
TEST(PowerSpectrum, WhiteNoiseIsFlatAtItsVariance) {
  constexpr int size = 256;
  std::mt19937_64 random(4);
  const std::vector<float> field = white_noise(random, size * size, 0.5f);
  const auto spectrum = radial_spectra({{field}}, size, size, size * size).front();
  EXPECT_EQ(spectrum.size(), 46u);
  for (const SpectrumBin& bin : spectrum) {
    const double spread = 2.0 / (9.0 * double(bin.count));
    const double z = (std::cbrt(bin.power / 0.25) - (1.0 - spread)) / std::sqrt(spread);
    EXPECT_LT(std::abs(z), 5.6) << "at " << bin.frequency << ": " << bin.power;
  }
}

TEST(PowerSpectrum, RefusesWhatIsNoField) {
  const std::vector<std::vector<float>> fields = {std::vector<float>(6, 0.0f)};
  EXPECT_THROW(radial_spectra(fields, 2, 2, 4.0), InputError);
  EXPECT_THROW(radial_spectra(fields, 3, 2, 0.0), InputError);
  EXPECT_THROW(radial_spectra(fields, 0, 0, 1.0), InputError);
}

TEST(NoiseSpectrum, ItsMeanIsTheNoise) {
  constexpr int width = 40;
  constexpr int height = 30;
  std::mt19937_64 random(5);
  Image mask(width, height, 1);
  for (std::size_t i = 0; i < mask.values().size(); ++i)
    mask.values()[i] = i % 5 == 0 ? 0.0f : 1.0f;
  RunStatistics runs(mask);
  for (int k = 0; k < 5; ++k) {
    std::vector<float> field = white_noise(random, width * height, 0.2f);
    for (float& value : field) value += 2.0f;  // what all runs share is no noise
    runs.add(image_of(field, width, height));
  }
  const Image reference =
      image_of(std::vector<float>(std::size_t(width) * std::size_t(height), 4.0f), width, height);
  const NoiseBias noise = noise_and_bias(runs, reference);
  const NoiseSpectrum spectrum = noise_spectrum(runs, noise.mean_luminance);
  double sum = 0.0;
  for (const NoiseSpectrum::Bin& bin : spectrum.bins) {
    ASSERT_TRUE(bin.power.value && bin.power.interval);
    EXPECT_LT(bin.power.interval->low, *bin.power.value);
    EXPECT_GT(bin.power.interval->high, *bin.power.value);
    sum += *bin.power.value * double(bin.count);
  }
  EXPECT_NEAR(sum / (width * height) / *noise.noise_squared.value, 1.0, 1e-6);
}

TEST(NoiseSpectrum, SaysWhyThereIsNone) {
  const Image mask = image_of(std::vector<float>(12, 1.0f), 4, 3);
  RunStatistics runs(mask);
  runs.add(image_of(std::vector<float>(12, 1.0f), 4, 3));
  EXPECT_THROW(noise_spectrum(runs, 1.0), InputError);
  runs.add(image_of(std::vector<float>(12, std::numeric_limits<float>::infinity()), 4, 3));
  const NoiseSpectrum infinite = noise_spectrum(runs, 1.0);
  for (const auto& bin : infinite.bins) {
    EXPECT_FALSE(bin.power.value);
    EXPECT_NE(bin.power.reason.find("non-finite"), std::string::npos);
  }
  const NoiseSpectrum black = noise_spectrum(runs, 0.0);
  for (const auto& bin : black.bins) EXPECT_FALSE(bin.power.reason.empty());
}

// 8 runs of white noise, 300 times, in bins of at least 8 frequencies: nominal 95% intervals. Bins
// of one repetition share the correction, but their powers are independent: 300 * bins trials, of
// which a true coverage of 93% falls below 91.5% once in 10^9 runs.
TEST(NoiseSpectrum, IntervalsCover) {
  constexpr int size = 24;
  std::mt19937_64 random(6);
  const Image mask =
      image_of(std::vector<float>(std::size_t(size) * std::size_t(size), 1.0f), size, size);
  long inside = 0;
  long trials = 0;
  long inside_few = 0;
  long trials_few = 0;
  for (int repetition = 0; repetition < 300; ++repetition) {
    RunStatistics runs(mask);
    for (int k = 0; k < 8; ++k) {
      runs.add(image_of(white_noise(random, size * size, 1.0f), size, size));
    }
    const NoiseSpectrum spectrum = noise_spectrum(runs, 1.0);
    for (const NoiseSpectrum::Bin& bin : spectrum.bins) {
      const bool covers = bin.power.interval->low <= 1.0 && bin.power.interval->high >= 1.0;
      (bin.count >= 8 ? inside : inside_few) += covers;
      (bin.count >= 8 ? trials : trials_few) += 1;
    }
  }
  std::printf("coverage %.4f of %ld; of bins of fewer than 8 frequencies %.4f of %ld\n",
              double(inside) / double(trials), trials, double(inside_few) / double(trials_few),
              trials_few);
  EXPECT_GT(double(inside) / double(trials), 0.915);
}

}  // namespace
}  // namespace occlab
