#include "renderers/methods/converged.h"

#include <algorithm>
#include <cmath>

#include "renderers/methods/representation_layers.h"

namespace occlab {
namespace {

constexpr int halves = 2;

double luminance(double r, double g, double b) { return 0.2126 * r + 0.7152 * g + 0.0722 * b; }

/// RMS over the surface's values of half the difference, in mean luminances of the mean: the
/// standard error of the mean of the two. Infinite where the image is black.
double relative_half_difference(const Image& a, const Image& b, const Image& mask) {
  double squares = 0.0;
  double sum = 0.0;
  std::size_t pixels = 0;
  for (std::size_t p = 0; p < mask.pixel_count(); ++p) {
    if (mask.values()[p] < 0.5f) continue;
    std::array<double, 3> mean{};
    for (std::size_t c = 0; c < 3; ++c) {
      const double first = double(a.values()[p * 3 + c]);
      const double second = double(b.values()[p * 3 + c]);
      squares += 0.25 * (first - second) * (first - second);
      mean[c] = 0.5 * (first + second);
    }
    sum += luminance(mean[0], mean[1], mean[2]);
    ++pixels;
  }
  return std::sqrt(squares / (3.0 * double(pixels))) / (sum / double(pixels));
}

}  // namespace

std::vector<Converged> converge(const GBufferImages& surface, const Lighting& lighting,
                                const VisibilitySource& visibility,
                                const std::vector<ConvergedMethod>& methods,
                                const Convergence& convergence) {
  const auto start = std::chrono::steady_clock::now();
  const Image& mask = surface.mask;
  const PassConstants& constants = methods.front().constants;
  const CpuLighting sampling_light(lighting, constants);
  const DirectionPass pass{surface, sampling_light, constants, visibility};
  std::vector<const Representation*> representations;
  std::array<std::vector<Image>, halves> sums;
  for (const ConvergedMethod& method : methods) {
    representations.push_back(method.representation);
    for (auto& half : sums) {
      half.emplace_back(mask.width(), mask.height(), method.representation->channels);
    }
  }

  std::vector<Converged> result(methods.size());
  const auto light = [&](std::size_t m, const Image& method_sums, int count) {
    std::size_t negative_pixels = 0;
    const Representation& representation = *methods[m].representation;
    return clamp_negative(
        light_on_cpu(representation, representation_of(representation, method_sums, count), surface,
                     CpuLighting(lighting, methods[m].constants)),
        negative_pixels);
  };
  std::uint64_t seed = convergence.seed;
  int per_half = 0;
  // Every round is one set, twice as large as the last: a large stratified set is worth more than
  // many small ones.
  for (int directions = convergence.first_round;; directions *= 2) {
    const SampleSet first = make_sample_set(directions, seed++);
    const SampleSet second = make_sample_set(directions, seed++);
    const std::array<DirectionSums, halves> sets = {{{first, sums[0]}, {second, sums[1]}}};
    add_directions(pass, sets, TurnPattern::tiles, representations);
    per_half += directions;
    bool reached = true;
    for (std::size_t m = 0; m < methods.size(); ++m) {
      result[m].standard_error = relative_half_difference(light(m, sums[0][m], per_half),
                                                          light(m, sums[1][m], per_half), mask);
      result[m].reached = result[m].standard_error <= convergence.tolerance;
      reached &= result[m].reached;
    }
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    if (reached || elapsed.count() > convergence.budget_seconds) break;
  }
  for (std::size_t m = 0; m < methods.size(); ++m) {
    result[m].directions = halves * per_half;
    result[m].radiance = light(m, sum_of(sums[0][m], sums[1][m]), result[m].directions);
  }
  return result;
}

}  // namespace occlab
