#include "renderers/methods/cpu_passes.h"

#include <algorithm>

#include "renderers/methods/representation_layers.h"
#include "renderers/scene/interrupt.h"
#include "renderers/scene/parallel.h"
#include "renderers/shared/filter.h"
#include "renderers/shared/lights.h"

namespace occlab {
namespace {

using Values = Representation::Values;

/// The values of a representation's pixel; the rest are 0.
Values values_at(const Image& image, int x, int y) {
  Values values{};
  std::ranges::copy(image.pixel(x, y), values.begin());
  return values;
}

void set_values(Image& image, int x, int y, const Values& values) {
  std::copy_n(values.begin(), image.channels(), image.pixel(x, y).begin());
}

ShadedPoint point_at(const GBufferImages& surface, int x, int y) {
  const auto p = surface.position_view.pixel(x, y);
  const auto n = surface.normal_view.pixel(x, y);
  return {{p[0], p[1], p[2]}, {n[0], n[1], n[2]}};
}

template <typename Body>
void for_each_surface_pixel(const GBufferImages& surface, const Body& body) {
  parallel_for(std::size_t(surface.mask.height()), [&](std::size_t row) {
    throw_if_interrupted();
    const int y = int(row);
    for (int x = 0; x < surface.mask.width(); ++x) {
      if (surface.mask.at(x, y) > 0.5f) body(x, y);
    }
  });
}

/// The sums of one group's pixels for all representations.
class GroupSums {
 public:
  GroupSums(const DirectionPass& pass, const PixelGroup& group,
            std::span<const Representation* const> representations)
      : pass_(pass), group_(group), representations_(representations) {
    sums_.resize(representations.size());
    reads_radiance_ =
        std::ranges::any_of(representations, [](const auto* r) { return r->reads_radiance; });
  }

  void add(const SampleSet& samples, float shift) {
    Lanes reach;
    reach.v.fill(pass_.constants.d_max_world);
    for (const glm::vec4& sample : samples.directions) {
      LaneDirections direction;
      for (std::size_t i = 0; i < direction.size(); ++i) {
        direction[i] = group_.frame[i] * glm::vec3(sample);
      }
      const float xi = fract(sample.w + shift);
      const Lanes visible = pass_.visibility(group_, direction, xi, reach);
      if (reads_radiance_) radiance_ = pass_.lighting.probe_radiance(direction);
      for (int i = 0; i < lane_count; ++i) add(i, direction[std::size_t(i)], sample.z, visible[i]);
    }
    if (reads_radiance_) add_lights(samples, shift);
  }

  void store(std::span<Image> sums) const {
    for (std::size_t r = 0; r < sums.size(); ++r) {
      for (int i = 0; i < lane_count; ++i) {
        if (!group_.active[i]) continue;
        const glm::ivec2 pixel = group_.pixel[std::size_t(i)];
        const auto target = sums[r].pixel(pixel.x, pixel.y);
        for (std::size_t c = 0; c < target.size(); ++c) target[c] += sums_[r][std::size_t(i)][c];
      }
    }
  }

 private:
  void add(int lane, glm::vec3 direction, float cosine, float visibility) {
    if (!group_.active[lane]) return;
    const SampledDirection sampled{direction, cosine, visibility, radiance_[std::size_t(lane)]};
    for (std::size_t r = 0; r < representations_.size(); ++r) {
      representations_[r]->accumulate(sums_[r][std::size_t(lane)], sampled);
    }
  }

  /// A punctual light is one more direction, up to the light or d_max. Its irradiance is that of a
  /// sample of radiance E N / (2 pi).
  void add_lights(const SampleSet& samples, float shift) {
    const float xi = fract(samples.directions.front().w + shift);
    const float radiance_of_irradiance = float(samples.directions.size()) / (2.0f * pi);
    for (const PunctualLight& light : pass_.lighting.lights()) {
      std::array<IncidentLight, lane_count> incident;
      LaneDirections direction;
      Lanes reach;
      for (std::size_t i = 0; i < direction.size(); ++i) {
        incident[i] = incident_light(light, group_.position[i]);
        direction[i] = incident[i].direction;
        reach.v[i] = std::min(pass_.constants.d_max_world, incident[i].distance);
      }
      const Lanes visible = pass_.visibility(group_, direction, xi, reach);
      for (std::size_t i = 0; i < direction.size(); ++i) {
        const float cosine = dot(group_.normal[i], direction[i]);
        if (!group_.active.v[i] || cosine <= 0.0f) continue;
        const SampledDirection sampled{direction[i], cosine, visible.v[i],
                                       incident[i].irradiance * radiance_of_irradiance};
        for (std::size_t r = 0; r < representations_.size(); ++r) {
          if (representations_[r]->reads_radiance) {
            representations_[r]->accumulate(sums_[r][i], sampled);
          }
        }
      }
    }
  }

  const DirectionPass& pass_;
  const PixelGroup& group_;
  std::span<const Representation* const> representations_;
  bool reads_radiance_ = false;
  std::array<glm::vec3, lane_count> radiance_{};
  std::vector<std::array<Values, lane_count>> sums_;
};

}  // namespace

void add_directions(const DirectionPass& pass, const SampleSet& samples,
                    std::span<const Representation* const> representations, std::span<Image> sums) {
  for_each_group(pass.surface, samples, [&](const PixelGroup& group, int set) {
    GroupSums group_sums(pass, group, representations);
    group_sums.add(samples, samples.sets[std::size_t(set)].z);
    group_sums.store(sums);
  });
}

Image representation_of(const Representation& representation, const Image& sums, int count) {
  Image result = sums;
  for (int y = 0; y < sums.height(); ++y) {
    for (int x = 0; x < sums.width(); ++x) {
      Values values = values_at(sums, x, y);
      representation.result(values, count);
      set_values(result, x, y, values);
    }
  }
  return result;
}

Image filter_on_cpu(const Image& values, const GBufferImages& surface,
                    const PassConstants& constants) {
  Image filtered(values.width(), values.height(), values.channels());
  const float scale = constants.filter_scale * constants.d_max_world;
  for_each_surface_pixel(surface, [&](int x, int y) {
    const ShadedPoint center = point_at(surface, x, y);
    Values sum{};
    float weights = 0.0f;
    for (int row = y + filter_first; row <= y + filter_last; ++row) {
      for (int column = x + filter_first; column <= x + filter_last; ++column) {
        if (row < 0 || row >= values.height() || column < 0 || column >= values.width()) continue;
        if (surface.mask.at(column, row) < 0.5f) continue;
        const ShadedPoint neighbour = point_at(surface, column, row);
        const float w = bilateral_weight(center.position, center.normal, neighbour.position,
                                         neighbour.normal, constants.filter_power, scale);
        weights += w;
        const auto texel = values.pixel(column, row);
        for (std::size_t c = 0; c < texel.size(); ++c) sum[c] += w * texel[c];
      }
    }
    for (float& value : sum) value /= weights;
    set_values(filtered, x, y, sum);
  });
  return filtered;
}

Image light_on_cpu(const Representation& representation, const Image& values,
                   const GBufferImages& surface, const CpuLighting& lighting) {
  Image radiance(values.width(), values.height(), 3);
  for_each_surface_pixel(surface, [&](int x, int y) {
    const glm::vec3 E =
        representation.irradiance(values_at(values, x, y), point_at(surface, x, y), lighting);
    for (int c = 0; c < 3; ++c) {
      radiance.at(x, y, c) = surface.albedo.at(x, y, c) / pi * E[c];
    }
  });
  return radiance;
}

GBufferBits gbuffer_bits(const ParameterSet& parameters) {
  return parameters.choice("gbuffer_bits") == "32" ? GBufferBits::float32 : GBufferBits::float16;
}

Image occlusion_on_cpu(const Frame& frame, const ParameterSet& parameters,
                       const Representation& representation) {
  const PassConstants constants = pass_constants(parameters);
  const GBufferImages& surface = frame.surface(gbuffer_bits(parameters));
  const CpuLighting lighting(frame.lighting, constants);
  const DirectionPass pass{surface, lighting, constants,
                           traces(parameters)
                               ? traced_visibility(frame.traced(), frame.view, constants)
                               : depth_visibility(surface, frame.view, constants)};
  const SampleSet samples =
      make_sample_set(constants.samples, std::uint64_t(parameters.integer("seed")));
  Image sums(surface.mask.width(), surface.mask.height(), representation.channels);
  const std::array<const Representation*, 1> one = {&representation};
  add_directions(pass, samples, one, std::span(&sums, 1));
  return representation_of(representation, sums, constants.samples);
}

Layers evaluate_on_cpu(const Frame& frame, const ParameterSet& parameters,
                       const Representation& representation) {
  const PassConstants constants = pass_constants(parameters);
  const GBufferImages& surface = frame.surface(gbuffer_bits(parameters));
  const CpuLighting lighting(frame.lighting, constants);
  std::size_t negative_pixels = 0;
  const auto lit = [&](const Image& values) {
    return clamp_negative(light_on_cpu(representation, values, surface, lighting), negative_pixels);
  };
  const Image unfiltered = occlusion_on_cpu(frame, parameters, representation);
  Layers layers;
  if (!filters(parameters)) {
    layers.add("radiance", lit(unfiltered));
    representation.add_layers(unfiltered, layers);
    return layers;
  }
  const Image filtered = filter_on_cpu(unfiltered, surface, constants);
  layers.add("radiance", lit(filtered));
  representation.add_layers(filtered, layers);
  layers.add("radiance_unfiltered", lit(unfiltered));
  return layers;
}

}  // namespace occlab
