#include "renderers/methods/cpu_passes.h"

#include <algorithm>

#include "renderers/methods/bounce.h"
#include "renderers/methods/cpu_bounce.h"
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

/// A direction of a set, in the tangent frames of all pixels.
struct TangentDirection {
  glm::vec3 direction;
  float offset;  ///< of the march
  int cell;      ///< tangent_cell()
};

/// Those of a cell one after the other: they meet the same triangles. Turned by the angle whose
/// cosine and sin are `turn`.
std::vector<TangentDirection> tangent_directions(const SampleSet& samples, glm::vec2 turn) {
  std::vector<TangentDirection> directions;
  for (const glm::vec4& s : samples.directions) {
    const glm::vec3 d(turn.x * s.x - turn.y * s.y, turn.x * s.y + turn.y * s.x, s.z);
    directions.push_back({d, s.w, tangent_cell(d)});
  }
  std::ranges::stable_sort(directions, {}, &TangentDirection::cell);
  return directions;
}

/// What V (and the radiance, where it is read) of each direction is multiplied with: the same in
/// all tangent frames.
using Weights = std::vector<Values>;

Weights weights_of(const Representation& representation,
                   const std::vector<TangentDirection>& directions) {
  Weights weights(directions.size());
  for (std::size_t k = 0; k < weights.size(); ++k) {
    const glm::vec3 direction = directions[k].direction;
    representation.accumulate(weights[k], {.direction = direction,
                                           .cosine = direction.z,
                                           .visibility = 1.0f,
                                           .radiance = glm::vec3(1.0f)});
  }
  return weights;
}

/// sum += weight * value
void add_lanes(Lanes& sum, float weight, const Lanes& value) {
  for (const int half : half_lanes) {
    store8(sum, half, load8(sum, half) + load8(value, half) * weight);
  }
}

Lanes product(const Lanes& a, const Lanes& b) {
  Lanes result;
  for (const int half : half_lanes) store8(result, half, load8(a, half) * load8(b, half));
  return result;
}

/// The sums of one group's pixels for one representation, in the pixels' frames.
struct LaneSums {
  const Representation* representation;
  const Weights* weights;
  std::array<Lanes, std::tuple_size_v<Values>> sums{};

  void add(std::size_t k, const Lanes& visible, const std::array<Lanes, 3>& visible_radiance) {
    const Values& weight = (*weights)[k];
    for (std::size_t c = 0; c < std::size_t(representation->channels); ++c) {
      add_lanes(sums[c], weight[c], representation->reads_radiance ? visible_radiance[c] : visible);
    }
  }

  Values in_view(int lane, const PixelGroup& group) const {
    Values values{};
    for (std::size_t c = 0; c < values.size(); ++c) values[c] = sums[c][lane];
    if (representation->turn) {
      representation->turn(values, {at(group.frame.tangent, lane), at(group.frame.bitangent, lane),
                                    at(group.frame.normal, lane)});
    }
    return values;
  }
};

/// The directions of a set as the passes add them up.
struct PreparedSet {
  /// `turn`: of the set against the pixels' frames.
  PreparedSet(const DirectionSums& in, glm::vec2 turn,
              std::span<const Representation* const> representations)
      : samples(&in.samples), sums(in.sums), directions(tangent_directions(in.samples, turn)) {
    for (const Representation* r : representations) weights.push_back(weights_of(*r, directions));
  }

  const SampleSet* samples;
  std::span<Image> sums;
  std::vector<TangentDirection> directions;
  std::vector<Weights> weights;  ///< of each representation
};

/// One group's pixels.
class GroupPass {
 public:
  GroupPass(const DirectionPass& pass, std::span<const Representation* const> representations,
            const PixelGroup& group, int turn, VisibilitySource& visibility)
      : pass_(pass),
        representations_(representations),
        group_(group),
        turn_(std::size_t(turn)),
        visibility_(visibility) {}

  void add(const PreparedSet& set) const {
    std::vector<LaneSums> lanes;
    for (std::size_t r = 0; r < representations_.size(); ++r) {
      lanes.push_back({representations_[r], &set.weights[r]});
    }
    add_probe(set, lanes);
    for (std::size_t r = 0; r < lanes.size(); ++r) {
      if (representations_[r]->reads_radiance) add_lights(*set.samples, lanes[r]);
      store(lanes[r], set.sums[r]);
    }
  }

 private:
  void add_probe(const PreparedSet& set, std::span<LaneSums> lanes) const {
    const float shift = set.samples->sets[turn_].z;
    const bool reads_radiance =
        std::ranges::any_of(representations_, [](const auto* r) { return r->reads_radiance; });
    std::array<Lanes, 3> radiance;
    for (std::size_t k = 0; k < set.directions.size(); ++k) {
      const TangentDirection& d = set.directions[k];
      // Texels are fetched while the rays are traced.
      CpuLighting::Texels texels;
      if (reads_radiance) texels = pass_.lighting.probe_texels(out_of(group_.frame, d.direction));
      const Lanes visible = visibility_.toward(d.direction, d.cell, fract(d.offset + shift));
      if (reads_radiance) {
        radiance = CpuLighting::radiance(texels);
        for (Lanes& channel : radiance) channel = product(channel, visible);
      }
      for (LaneSums& sums : lanes) sums.add(k, visible, radiance);
    }
  }

  /// A punctual light is one more direction, up to the light or d_max. Its irradiance is that of a
  /// sample of radiance E N / (2 pi).
  void add_lights(const SampleSet& samples, LaneSums& lanes) const {
    const float xi = fract(samples.directions.front().w + samples.sets[turn_].z);
    const float radiance_of_irradiance = float(samples.directions.size()) / (2.0f * pi);
    for (const PunctualLight& light : pass_.lighting.lights()) {
      std::array<IncidentLight, lane_count> incident;
      Lanes3 direction;
      Lanes reach;
      for (int i = 0; i < lane_count; ++i) {
        IncidentLight& here = incident[std::size_t(i)];
        here = incident_light(light, group_.position[std::size_t(i)]);
        set_lane(direction, i, here.direction);
        reach[i] = std::min(pass_.constants.d_max_world, here.distance);
      }
      const Lanes visible = visibility_.along(direction, xi, reach);
      for (int i = 0; i < lane_count; ++i) {
        const float cosine = dot(at(group_.frame.normal, i), at(direction, i));
        if (!group_.active[i] || cosine <= 0.0f) continue;
        Values added{};
        lanes.representation->accumulate(
            added, {at(direction, i), cosine, visible[i],
                    incident[std::size_t(i)].irradiance * radiance_of_irradiance});
        for (std::size_t c = 0; c < added.size(); ++c) lanes.sums[c][i] += added[c];
      }
    }
  }

  void store(const LaneSums& lanes, Image& sums) const {
    for (int i = 0; i < lane_count; ++i) {
      if (!group_.active[i]) continue;
      const glm::ivec2 pixel = group_.pixel[std::size_t(i)];
      const auto target = sums.pixel(pixel.x, pixel.y);
      const Values values = lanes.in_view(i, group_);
      for (std::size_t c = 0; c < target.size(); ++c) target[c] += values[c];
    }
  }

  const DirectionPass& pass_;
  std::span<const Representation* const> representations_;
  const PixelGroup& group_;
  std::size_t turn_;
  VisibilitySource& visibility_;
};

}  // namespace

void add_directions(const DirectionPass& pass, std::span<const DirectionSums> sets,
                    TurnPattern pattern, std::span<const Representation* const> representations) {
  std::vector<PreparedSet> prepared;
  long directions = 0;
  const SampleSet& turns = sets.front().samples;
  const glm::vec2 first_turn(turns.sets.front());
  for (const DirectionSums& set : sets) {
    const glm::vec2 own(set.samples.sets.front());
    const glm::vec2 apart(glm::dot(own, first_turn), own.y * first_turn.x - own.x * first_turn.y);
    prepared.emplace_back(set, &set == sets.data() ? glm::vec2(1, 0) : apart, representations);
    directions += long(set.samples.directions.size());
  }
  const auto add_group = [&, visibility = pass.visibility](const PixelGroup& group,
                                                           int set) mutable {
    visibility.set_group(group, directions);
    const GroupPass group_pass(pass, representations, group, set, visibility);
    for (const PreparedSet& each : prepared) group_pass.add(each);
  };
  for_each_group(pass.surface, turns, pattern, add_group);
}

void add_directions(const DirectionPass& pass, const SampleSet& samples, TurnPattern pattern,
                    std::span<const Representation* const> representations, std::span<Image> sums) {
  const DirectionSums one{samples, sums};
  add_directions(pass, std::span(&one, 1), pattern, representations);
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
    Bounce::Values sum{};
    float weights = 0.0f;
    for (int row = y + filter_first; row <= y + filter_last; ++row) {
      for (int column = x + filter_first; column <= x + filter_last; ++column) {
        if (row < 0 || row >= values.height() || column < 0 || column >= values.width()) continue;
        if (surface.mask.at(column, row) < 0.5f) continue;
        const ShadedPoint neighbour = point_at(surface, column, row);
        const float w =
            bilateral_weight(center.position, center.normal, neighbour.position, neighbour.normal,
                             constants.filter_power, whole_filter_power(constants), scale);
        weights += w;
        const auto texel = values.pixel(column, row);
        for (std::size_t c = 0; c < texel.size(); ++c) sum[c] += w * texel[c];
      }
    }
    const auto target = filtered.pixel(x, y);
    for (std::size_t c = 0; c < target.size(); ++c) target[c] = sum[c] / weights;
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

}  // namespace occlab
