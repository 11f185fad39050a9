#include "harness/verify/layer_agreement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderers/methods/bounce.h"
#include "renderers/methods/cpu_bounce.h"
#include "renderers/methods/cpu_passes.h"
#include "renderers/methods/representation_layers.h"
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

/// The sum over the channels of what moving one by its bound makes of what is lit from them.
template <typename Lit>
Image moved_light(const Image& values, const Image& bound, const Lit& lit) {
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
  return result;
}

void add_rounding(Image& bound, const Image& values) {
  for (std::size_t i = 0; i < bound.values().size(); ++i) {
    bound.values()[i] += pass_rounding * std::abs(values.values()[i]);
  }
}

/// The bounds of a method's values and of the layers that are lit from them.
class Bounds {
 public:
  Bounds(const Frame& frame, const MethodInfo& method, const ParameterSet& parameters,
         const CpuLighting& lighting)
      : representation_(*method.representation),
        constants_(pass_constants(parameters)),
        surface_(frame.surface(gbuffer_bits(parameters))),
        lighting_(lighting) {}

  /// Of the passes that collect the values.
  PassValues collected(const PassValues& values) const {
    return stored(values,
                  {zeros(values.representation), zeros(values.direct), zeros(values.bounce)});
  }

  /// Of the filter, which hands on the bounds of what it reads.
  PassValues filtered(const PassValues& values, const PassValues& unfiltered_bounds) const {
    return stored(values, filter_on_cpu(unfiltered_bounds, surface_, constants_));
  }

  Image radiance(const PassValues& values, const PassValues& bounds) const {
    Image bound = direct(values.representation, bounds.representation);
    if (!values.bounce.empty()) bound = sum_of(std::move(bound), bounce(values, bounds));
    add_rounding(bound, light_on_cpu(representation_, values, surface_, lighting_));
    return bound;
  }

  /// Of a difference of two radiances, on the GPU; what direct light has in common cancels.
  Image indirect(const PassValues& values, const PassValues& bounds) const {
    Image bound = values.bounce.empty()
                      ? sum_of(direct(values.representation, bounds.representation),
                               direct(values.direct, bounds.direct))
                      : bounce(values, bounds);
    const Image all = light_on_cpu(representation_, values, surface_, lighting_);
    add_rounding(bound, all);
    add_rounding(bound, all);
    return bound;
  }

 private:
  static Image zeros(const Image& like) {
    return like.empty() ? Image() : Image(like.width(), like.height(), like.channels());
  }

  PassValues stored(const PassValues& values, PassValues bounds) const {
    const float error = representation_.storage_error;
    add_stored(bounds.representation, values.representation, surface_.mask, error);
    if (!values.direct.empty()) {
      add_stored(bounds.direct, values.direct, surface_.mask, error);
      // What senders send was itself lit and read before.
      add_stored(bounds.representation, values.representation, surface_.mask, error);
    }
    if (!values.bounce.empty()) {
      add_stored(bounds.bounce, values.bounce, surface_.mask,
                 representation_.bounce->storage_error);
    }
    return bounds;
  }

  Image direct(const Image& values, const Image& bound) const {
    return moved_light(values, bound, [&](const Image& of) {
      return light_on_cpu(representation_, of, surface_, lighting_);
    });
  }

  Image bounce(const PassValues& values, const PassValues& bounds) const {
    return moved_light(values.bounce, bounds.bounce, [&](const Image& of) {
      return light_bounce_on_cpu(*representation_.bounce, of, surface_, lighting_);
    });
  }

  const Representation& representation_;
  PassConstants constants_;
  const GBufferImages& surface_;
  const CpuLighting& lighting_;
};

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
  const CpuLighting lighting(frame.lighting, pass_constants(parameters));
  const Bounds of(frame, method, parameters, lighting);
  const PassValues values = collect_on_cpu(frame, parameters, representation);
  const PassValues bound = of.collected(values);
  PassValues filtered = values;
  PassValues filtered_bound = bound;
  if (filters(parameters)) {
    filtered =
        filter_on_cpu(values, frame.surface(gbuffer_bits(parameters)), pass_constants(parameters));
    filtered_bound = of.filtered(filtered, bound);
  }
  Layers bounds;
  bounds.add("radiance", of.radiance(filtered, filtered_bound));
  // channels of the values, or multiples of them
  representation.add_layers(filtered_bound.representation, bounds);
  if (filters(parameters)) bounds.add("radiance_unfiltered", of.radiance(values, bound));
  if (representation.bounce) {
    bounds.add("radiance_indirect", of.indirect(filtered, filtered_bound));
    if (filters(parameters)) {
      bounds.add("radiance_indirect_unfiltered", of.indirect(values, bound));
    }
  }
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
