// What cpu_passes.h declares of whole methods: their passes one after the other.

#include <array>

#include "renderers/methods/bounce.h"
#include "renderers/methods/cpu_bounce.h"
#include "renderers/methods/cpu_passes.h"
#include "renderers/methods/representation_layers.h"

namespace occlab {
namespace {

/// The occlusion pass at other surfaces than the first, too.
Image occlusion_at(const GBufferImages& surface, const Frame& frame, const ParameterSet& parameters,
                   const Representation& representation) {
  const PassConstants constants = pass_constants(parameters);
  const CpuLighting lighting(frame.lighting, constants);
  const DirectionPass pass{surface, lighting, constants, visibility_source(frame, parameters)};
  const SampleSet samples =
      make_sample_set(constants.samples, std::uint64_t(parameters.integer("seed")));
  Image sums(surface.mask.width(), surface.mask.height(), representation.channels);
  const std::array<const Representation*, 1> one = {&representation};
  add_directions(pass, samples, TurnPattern::interleaved, one, std::span(&sums, 1));
  return representation_of(representation, sums, constants.samples);
}

/// What the first surfaces, whose occlusion is `direct`, and then the hidden ones send.
std::vector<Image> lit_senders(const Frame& frame, const ParameterSet& parameters,
                               const Representation& representation, const Image& direct) {
  const CpuLighting lighting(frame.lighting, pass_constants(parameters));
  std::vector<Image> lit = {
      light_on_cpu(representation, direct, frame.surface(gbuffer_bits(parameters)), lighting)};
  if (const std::optional<HiddenSettings> settings = hidden_settings(parameters)) {
    for (const GBufferImages& surface : frame.hidden_images(*settings).images) {
      lit.push_back(light_on_cpu(representation,
                                 occlusion_at(surface, frame, parameters, representation), surface,
                                 lighting));
    }
  }
  return lit;
}

}  // namespace

Image occlusion_on_cpu(const Frame& frame, const ParameterSet& parameters,
                       const Representation& representation) {
  return occlusion_at(frame.surface(gbuffer_bits(parameters)), frame, parameters, representation);
}

PassValues collect_on_cpu(const Frame& frame, const ParameterSet& parameters,
                          const Representation& representation) {
  PassValues values{.representation = occlusion_on_cpu(frame, parameters, representation),
                    .direct = {},
                    .bounce = {}};
  const Bounce* const bounce = representation.bounce;
  if (!bounce) return values;
  if (!bounce->reads_lit) {
    values.bounce = bounce_on_cpu(frame, parameters, *bounce, {});
    return values;
  }
  values.direct = values.representation;
  const std::vector<Image> lit = lit_senders(frame, parameters, representation, values.direct);
  values.representation = sum_of(values.direct, bounce_on_cpu(frame, parameters, *bounce, lit));
  return values;
}

PassValues filter_on_cpu(const PassValues& values, const GBufferImages& surface,
                         const PassConstants& constants) {
  const auto filtered = [&](const Image& image) {
    return image.empty() ? Image() : filter_on_cpu(image, surface, constants);
  };
  return {filtered(values.representation), filtered(values.direct), filtered(values.bounce)};
}

Image light_on_cpu(const Representation& representation, const PassValues& values,
                   const GBufferImages& surface, const CpuLighting& lighting) {
  const Image radiance = light_on_cpu(representation, values.representation, surface, lighting);
  if (values.bounce.empty()) return radiance;
  return sum_of(radiance,
                light_bounce_on_cpu(*representation.bounce, values.bounce, surface, lighting));
}

Image light_bounce_on_cpu(const Representation& representation, const PassValues& values,
                          const GBufferImages& surface, const CpuLighting& lighting) {
  if (!values.bounce.empty()) {
    return light_bounce_on_cpu(*representation.bounce, values.bounce, surface, lighting);
  }
  return difference(light_on_cpu(representation, values.representation, surface, lighting),
                    light_on_cpu(representation, values.direct, surface, lighting));
}

Layers evaluate_on_cpu(const Frame& frame, const ParameterSet& parameters,
                       const Representation& representation) {
  const PassConstants constants = pass_constants(parameters);
  const GBufferImages& surface = frame.surface(gbuffer_bits(parameters));
  const CpuLighting lighting(frame.lighting, constants);
  std::size_t negative_pixels = 0;
  const auto lit = [&](const PassValues& values) {
    return clamp_negative(light_on_cpu(representation, values, surface, lighting), negative_pixels);
  };
  const auto bounced = [&](const PassValues& values) {
    return light_bounce_on_cpu(representation, values, surface, lighting);
  };
  const PassValues unfiltered = collect_on_cpu(frame, parameters, representation);
  const PassValues filtered =
      filters(parameters) ? filter_on_cpu(unfiltered, surface, constants) : unfiltered;
  Layers layers;
  layers.add("radiance", lit(filtered));
  representation.add_layers(filtered.representation, layers);
  if (filters(parameters)) layers.add("radiance_unfiltered", lit(unfiltered));
  if (representation.bounce) {
    layers.add("radiance_indirect", bounced(filtered));
    if (filters(parameters)) layers.add("radiance_indirect_unfiltered", bounced(unfiltered));
  }
  return layers;
}

}  // namespace occlab
