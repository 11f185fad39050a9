#include "harness/metrics/power_spectrum.h"

#include <fmt/format.h>
#include <kissfft/kiss_fftnd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <new>

#include "harness/metrics/colour.h"
#include "harness/metrics/image_checks.h"
#include "harness/metrics/parallel.h"
#include "harness/statistics.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

static_assert(std::is_same_v<kiss_fft_scalar, float>, "the library's variant of floats");

constexpr std::size_t bin_count = 46;  // sqrt(1/2) / spectrum_bin_width, rounded up

/// The bin of every frequency of the grid, in the order of the transform.
struct Grid {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> bins;
  std::array<long, bin_count> counts{};

  Grid(int w, int h)
      : width(w), height(h), bins(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {
    const auto frequency = [](int index, int size) {
      return static_cast<double>(std::min(index, size - index)) / size;
    };
    std::size_t place = 0;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x, ++place) {
        const double radius = std::hypot(frequency(x, width), frequency(y, height));
        bins[place] = static_cast<std::uint8_t>(radius / spectrum_bin_width);
        ++counts[bins[place]];
      }
    }
  }

  std::size_t size() const { return bins.size(); }
};

struct FreePlan {
  void operator()(kiss_fftnd_cfg plan) const { kiss_fft_free(plan); }
};

/// Two real fields as one complex, which its transform tells apart.
struct Transform {
  std::unique_ptr<kiss_fftnd_state, FreePlan> plan;
  std::vector<kiss_fft_cpx> values;
  std::vector<kiss_fft_cpx> transformed;

  explicit Transform(const Grid& grid) : values(grid.size()), transformed(grid.size()) {
    const std::array<int, 2> sizes = {grid.height, grid.width};
    plan.reset(kiss_fftnd_alloc(sizes.data(), 2, 0, nullptr, nullptr));
    if (!plan) throw std::bad_alloc();
  }
};

using Sums = std::array<double, bin_count>;

/// With F the transform of a + i b, that of a is (F(k) + F*(-k)) / 2, that of b
/// (F(k) - F*(-k)) / 2i.
void add_powers(const Grid& grid, const std::vector<kiss_fft_cpx>& transformed, Sums& of_a,
                Sums& of_b) {
  const auto width = static_cast<std::size_t>(grid.width);
  const auto height = static_cast<std::size_t>(grid.height);
  for (std::size_t y = 0; y < height; ++y) {
    const std::size_t opposite_row = ((height - y) % height) * width;
    for (std::size_t x = 0; x < width; ++x) {
      const kiss_fft_cpx f = transformed[y * width + x];
      const kiss_fft_cpx opposite = transformed[opposite_row + (width - x) % width];
      const double sum_r = double(f.r) + double(opposite.r);
      const double difference_r = double(f.r) - double(opposite.r);
      const double sum_i = double(f.i) + double(opposite.i);
      const double difference_i = double(f.i) - double(opposite.i);
      const std::size_t bin = grid.bins[y * width + x];
      of_a[bin] += 0.25 * (sum_r * sum_r + difference_i * difference_i);
      of_b[bin] += 0.25 * (sum_i * sum_i + difference_r * difference_r);
    }
  }
}

/// Sums of |F|^2 in the bins, for each field. `fill(k, values)` adds field k to the real parts of
/// values (imaginary: odd k).
template <typename Fill>
std::vector<Sums> power_sums(const Grid& grid, std::size_t fields, Fill&& fill) {
  std::vector<Sums> sums(fields + fields % 2, Sums{});
  std::vector<Transform> transforms;
  for (std::size_t pair = 0; pair < sums.size() / 2; ++pair) transforms.emplace_back(grid);
  for_each_row(
      static_cast<int>(transforms.size()),
      [&](int row) {
        const auto pair = static_cast<std::size_t>(row);
        Transform& transform = transforms[pair];
        fill(2 * pair, transform.values);
        if (2 * pair + 1 < fields) fill(2 * pair + 1, transform.values);
        kiss_fftnd(transform.plan.get(), transform.values.data(), transform.transformed.data());
        add_powers(grid, transform.transformed, sums[2 * pair], sums[2 * pair + 1]);
      },
      grid.size());
  sums.resize(fields);
  return sums;
}

void put(kiss_fft_cpx& value, std::size_t field, float number) {
  (field % 2 == 0 ? value.r : value.i) = number;
}

double frequency_of(std::size_t bin) {
  return (static_cast<double>(bin) + 0.5) * spectrum_bin_width;
}

/// Luminance of the foreground's values of a run.
std::vector<float> luminances(std::span<const float> values, int channels) {
  if (channels == 1) return {values.begin(), values.end()};
  std::vector<float> result(values.size() / 3);
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i] = static_cast<float>(
        luminance({double(values[3 * i]), double(values[3 * i + 1]), double(values[3 * i + 2])}));
  }
  return result;
}

std::string why_unmeasured(const RunStatistics& runs, double mean_luminance) {
  if (!(mean_luminance > 0.0)) {
    return fmt::format(
        "the reference's mean luminance over the foreground is {}, and errors are relative to it",
        mean_luminance);
  }
  for (int k = 0; k < runs.runs(); ++k) {
    const auto finite = [](float value) { return std::isfinite(value); };
    if (!std::ranges::all_of(runs.run(k), finite)) return "a run holds non-finite values";
  }
  return "";
}

/// The runs' powers in one bin, each K / (K - 1) times its share of the noise.
Estimate estimate_power(const std::vector<double>& powers, double confidence) {
  Estimate result;
  result.value = mean(powers);
  const auto runs = static_cast<double>(powers.size());
  if (powers.size() < 3 || !(*result.value > 0.0)) return result;
  // Deviations from the mean of the runs add up to 0, which makes their powers alike: for Gaussian
  // noise the spread tells (K - 2) / (K - 1) of the mean's variance.
  const double squared_error = variance(powers) / runs * (runs - 1.0) / (runs - 2.0);
  const double half = student_quantile(0.5 + 0.5 * confidence, runs - 1.0) *
                      std::sqrt(squared_error) / *result.value;
  result.interval =
      Interval{*result.value * std::exp(-half), *result.value * std::exp(half), confidence};
  return result;
}

}  // namespace

std::vector<std::vector<SpectrumBin>> radial_spectra(std::span<const std::vector<float>> fields,
                                                     int width, int height, double norm) {
  if (width < 1 || height < 1 || !(norm > 0.0)) {
    throw InputError(
        fmt::format("power spectrum: {}x{} values, norm {}; accepted: 1x1 or more, a "
                    "positive norm",
                    width, height, norm));
  }
  const Grid grid(width, height);
  for (const auto& field : fields) {
    if (field.size() != grid.size()) {
      throw InputError(
          fmt::format("power spectrum: {} values; accepted: {}x{}", field.size(), width, height));
    }
  }
  const auto fill = [&](std::size_t k, std::vector<kiss_fft_cpx>& values) {
    for (std::size_t i = 0; i < values.size(); ++i) put(values[i], k, fields[k][i]);
  };
  std::vector<std::vector<SpectrumBin>> spectra;
  for (const Sums& sums : power_sums(grid, fields.size(), fill)) {
    spectra.emplace_back();
    for (std::size_t bin = 0; bin < bin_count; ++bin) {
      const long count = grid.counts[bin];
      if (count == 0) continue;
      spectra.back().push_back(
          {frequency_of(bin), count, sums[bin] / (norm * static_cast<double>(count))});
    }
  }
  return spectra;
}

NoiseSpectrum noise_spectrum(const RunStatistics& runs, double mean_luminance, double confidence) {
  const auto count = static_cast<std::size_t>(runs.runs());
  if (count < 2) {
    throw InputError(fmt::format("noise spectrum: {} runs; accepted: 2 or more", runs.runs()));
  }
  const std::vector<std::size_t> foreground = foreground_pixels(runs.mask());
  const Grid grid(runs.mask().width(), runs.mask().height());
  const std::string reason = why_unmeasured(runs, mean_luminance);
  std::vector<Sums> sums(count, Sums{});
  if (reason.empty()) {
    std::vector<std::vector<float>> lights(count);
    std::vector<double> centre(foreground.size(), 0.0);
    for (std::size_t k = 0; k < count; ++k) {
      lights[k] = luminances(runs.run(static_cast<int>(k)), runs.channels());
      for (std::size_t i = 0; i < centre.size(); ++i) centre[i] += double(lights[k][i]);
    }
    const double share = 1.0 / static_cast<double>(count);
    sums = power_sums(grid, count, [&](std::size_t k, std::vector<kiss_fft_cpx>& values) {
      for (std::size_t i = 0; i < foreground.size(); ++i) {
        const double deviation = double(lights[k][i]) - share * centre[i];
        put(values[foreground[i]], k, static_cast<float>(deviation / mean_luminance));
      }
    });
  }

  NoiseSpectrum spectrum;
  const double unbiased = static_cast<double>(count) / (static_cast<double>(count) - 1.0);
  for (std::size_t bin = 0; bin < bin_count; ++bin) {
    if (grid.counts[bin] == 0) continue;
    NoiseSpectrum::Bin result{frequency_of(bin), grid.counts[bin], {}};
    if (reason.empty()) {
      const double norm =
          static_cast<double>(foreground.size()) * static_cast<double>(grid.counts[bin]);
      std::vector<double> powers;
      for (const Sums& of_run : sums) powers.push_back(unbiased * of_run[bin] / norm);
      result.power = estimate_power(powers, confidence);
    } else {
      result.power.reason = reason;
    }
    spectrum.bins.push_back(std::move(result));
  }
  return spectrum;
}

}  // namespace occlab
