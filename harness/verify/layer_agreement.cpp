#include "harness/verify/layer_agreement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderers/methods/cpu_passes.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

/// Half a last place of a float (2^-24) for each of the hundred-odd operations behind a value.
constexpr float pass_rounding = 0x1p-17f;
constexpr float half_floor = 0x1p-14f;

double share_of(double difference, double bound) {
  if (difference == 0.0) return 0.0;
  const double share = difference / bound;
  return std::isnan(share) ? std::numeric_limits<double>::infinity() : share;
}

const Image& matching(const Layers& layers, const std::string& name, const Image& other) {
  const Image& image = layers.at(name);
  if (!image.same_size(other) || image.channels() != other.channels()) {
    throw InputError(
        fmt::format("layer '{}': {}x{} with {} channels in one, {}x{} with {} in the other", name,
                    image.width(), image.height(), image.channels(), other.width(), other.height(),
                    other.channels()));
  }
  return image;
}

float mean_magnitude(const Image& values, const Image& mask) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t p = 0; p < mask.pixel_count(); ++p) {
    if (mask.values()[p] < 0.5f) continue;
    const auto channels = std::size_t(values.channels());
    for (const float value : values.values().subspan(p * channels, channels)) {
      sum += std::abs(double(value));
    }
    count += channels;
  }
  return count == 0 ? 0.0f : float(sum / double(count));
}

/// Adds what writing `values` may lose; 0 stays where no surface is seen.
void add_stored(Image& bound, const Image& values, const Image& mask, float storage_error) {
  const float mean = mean_magnitude(values, mask);
  const auto channels = std::size_t(values.channels());
  for (std::size_t i = 0; i < values.values().size(); ++i) {
    if (mask.values()[i / channels] < 0.5f) continue;
    const float magnitude = std::abs(values.values()[i]);
    bound.values()[i] += storage_error * magnitude + (storage_error > 0.0f ? half_floor : 0.0f) +
                         pass_rounding * (magnitude + mean);
  }
}

/// The image with one channel moved by `sign` times its bound.
Image moved(const Image& values, const Image& bound, int channel, float sign) {
  Image result = values;
  for (std::size_t i = std::size_t(channel); i < values.values().size();
       i += std::size_t(values.channels())) {
    result.values()[i] += sign * bound.values()[i];
  }
  return result;
}

/// The bound of L_o from that of the values it is lit from.
Image radiance_bound(const Representation& representation, const Image& values, const Image& bound,
                     const GBufferImages& surface, const CpuLighting& lighting) {
  const auto lit = [&](const Image& of) {
    return light_on_cpu(representation, of, surface, lighting);
  };
  const Image radiance = lit(values);
  Image result(radiance.width(), radiance.height(), radiance.channels());
  for (int c = 0; c < values.channels(); ++c) {
    const Image above = lit(moved(values, bound, c, 1.0f));
    const Image below = lit(moved(values, bound, c, -1.0f));
    for (std::size_t i = 0; i < result.values().size(); ++i) {
      const float here = radiance.values()[i];
      result.values()[i] +=
          std::max(std::abs(above.values()[i] - here), std::abs(below.values()[i] - here));
    }
  }
  for (std::size_t i = 0; i < result.values().size(); ++i) {
    result.values()[i] += pass_rounding * std::abs(radiance.values()[i]);
  }
  return result;
}

}  // namespace

WorstPixel worst_pixel(const LayerAgreement& agreement) {
  WorstPixel worst;
  for (const Layers::Layer& layer : agreement.expected.all()) {
    const Image& expected = layer.image;
    const Image& measured = matching(agreement.measured, layer.name, expected);
    const Image& bounds = matching(agreement.bounds, layer.name, expected);
    for (int y = 0; y < expected.height(); ++y) {
      for (int x = 0; x < expected.width(); ++x) {
        for (int c = 0; c < expected.channels(); ++c) {
          const double a = double(measured.at(x, y, c));
          const double b = double(expected.at(x, y, c));
          const double bound = double(bounds.at(x, y, c));
          const double share = share_of(std::abs(a - b), bound);
          if (worst.layer.empty() || share > worst.share) {
            worst = {layer.name, x, y, c, a, b, bound, share};
          }
        }
      }
    }
  }
  return worst;
}

std::string describe(const WorstPixel& worst) {
  return fmt::format("{}[{}] at ({}, {}): {:.9g} for {:.9g}, {:.3g} allowed", worst.layer,
                     worst.channel, worst.x, worst.y, worst.measured, worst.expected, worst.bound);
}

Layers rounding_bounds(const Frame& frame, const MethodInfo& method,
                       const ParameterSet& parameters) {
  const Representation& representation = *method.representation;
  const PassConstants constants = pass_constants(parameters);
  const GBufferImages& surface = frame.surface(gbuffer_bits(parameters));
  const CpuLighting lighting(frame.lighting, constants);
  const auto lit_bound = [&](const Image& values, const Image& bound) {
    return radiance_bound(representation, values, bound, surface, lighting);
  };
  const Image values = occlusion_on_cpu(frame, parameters, representation);
  Image bound(values.width(), values.height(), values.channels());
  add_stored(bound, values, surface.mask, representation.storage_error);
  Layers bounds;
  if (!filters(parameters)) {
    bounds.add("radiance", lit_bound(values, bound));
    representation.add_layers(bound, bounds);  // channels of the values, or multiples of them
    return bounds;
  }
  const Image filtered = filter_on_cpu(values, surface, constants);
  Image filtered_bound = filter_on_cpu(bound, surface, constants);
  add_stored(filtered_bound, filtered, surface.mask, representation.storage_error);
  bounds.add("radiance", lit_bound(filtered, filtered_bound));
  representation.add_layers(filtered_bound, bounds);
  bounds.add("radiance_unfiltered", lit_bound(values, bound));
  return bounds;
}

LayerAgreement gpu_and_cpu(const Frame& frame, const MethodInfo& method,
                           const ParameterSet& parameters) {
  Metadata facts;
  return {.measured = method.make()->evaluate(frame, parameters, facts),
          .expected = evaluate_on_cpu(frame, parameters, *method.representation),
          .bounds = rounding_bounds(frame, method, parameters)};
}

void write_agreement(const LayerAgreement& agreement, const std::filesystem::path& folder,
                     const Metadata& metadata) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw DeviceError(fmt::format("{}: cannot be made: {}", folder.string(), error.message()));
  }
  Layers differences;
  for (const Layers::Layer& layer : agreement.expected.all()) {
    Image difference = matching(agreement.measured, layer.name, layer.image);
    for (std::size_t i = 0; i < difference.values().size(); ++i) {
      difference.values()[i] -= layer.image.values()[i];
    }
    differences.add(layer.name, std::move(difference));
  }
  write_exr(folder / "measured.exr", agreement.measured, metadata);
  write_exr(folder / "expected.exr", agreement.expected, metadata);
  write_exr(folder / "difference.exr", differences, metadata);
  write_exr(folder / "bound.exr", agreement.bounds, metadata);
}

}  // namespace occlab
