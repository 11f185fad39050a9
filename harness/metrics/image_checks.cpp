#include "harness/metrics/image_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "harness/metrics/colour.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

std::span<const float> pixel_at(const Image& image, std::size_t index) {
  const auto channels = static_cast<std::size_t>(image.channels());
  return image.values().subspan(index * channels, channels);
}

template <typename Accepts>
void require_values(const Image& image, std::string_view name,
                    std::span<const std::size_t> foreground, std::string_view accepted,
                    Accepts&& accepts) {
  for (const std::size_t index : foreground) {
    for (const float value : pixel_at(image, index)) {
      if (accepts(value)) continue;
      const auto width = static_cast<std::size_t>(image.width());
      throw InputError(fmt::format("{} image: pixel ({}, {}) holds {}; accepted in the mask: {}",
                                   name, index % width, index / width, value, accepted));
    }
  }
}

}  // namespace

std::vector<std::size_t> foreground_pixels(const Image& mask) {
  if (mask.channels() != 1) {
    throw InputError(fmt::format("mask image: {} channels; accepted: 1", mask.channels()));
  }
  std::vector<std::size_t> foreground;
  foreground.reserve(mask.pixel_count());
  const std::span<const float> values = mask.values();
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) {
      throw InputError(
          fmt::format("mask image: value {} of {} is {}; accepted: finite values, "
                      "foreground above 0.5",
                      i, values.size(), values[i]));
    }
    if (values[i] > 0.5f) foreground.push_back(i);
  }
  if (foreground.empty()) {
    throw InputError(
        fmt::format("mask image: none of its {} x {} pixels exceeds 0.5; at least one "
                    "foreground pixel is needed",
                    mask.width(), mask.height()));
  }
  return foreground;
}

void require_shape(const Image& image, std::string_view name, const Image& like, int channels) {
  if (!image.same_size(like)) {
    throw InputError(fmt::format("{} image: {} x {} pixels; accepted: {} x {} as the others", name,
                                 image.width(), image.height(), like.width(), like.height()));
  }
  if (image.channels() != channels) {
    throw InputError(
        fmt::format("{} image: {} channels; accepted: {}", name, image.channels(), channels));
  }
}

void require_finite(const Image& image, std::string_view name,
                    std::span<const std::size_t> foreground) {
  require_values(image, name, foreground, "finite values",
                 [](float value) { return std::isfinite(value); });
}

void require_finite_non_negative(const Image& image, std::string_view name,
                                 std::span<const std::size_t> foreground) {
  require_values(image, name, foreground, "finite values of at least 0",
                 [](float value) { return std::isfinite(value) && value >= 0.0f; });
}

std::size_t count_non_finite(const Image& image, std::span<const std::size_t> foreground) {
  return static_cast<std::size_t>(
      std::count_if(foreground.begin(), foreground.end(), [&](std::size_t index) {
        const std::span<const float> pixel = pixel_at(image, index);
        return !std::all_of(pixel.begin(), pixel.end(), [](float v) { return std::isfinite(v); });
      }));
}

double mean_luminance(const Image& image, std::span<const std::size_t> foreground) {
  double sum = 0.0;
  for (const std::size_t index : foreground) {
    const std::span<const float> p = pixel_at(image, index);
    sum += p.size() == 1 ? p[0] : luminance({p[0], p[1], p[2]});
  }
  return sum / static_cast<double>(foreground.size());
}

}  // namespace occlab
