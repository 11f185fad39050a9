#include "renderers/methods/cpu_bounce.h"

#include <algorithm>
#include <variant>

#include "renderers/methods/cpu_passes.h"
#include "renderers/methods/visibility_source.h"
#include "renderers/scene/interrupt.h"
#include "renderers/scene/parallel.h"
#include "renderers/shared/bounce.h"
#include "renderers/trace/surface_rays.h"

namespace occlab {
namespace {

glm::vec3 vec3_at(const Image& image, glm::ivec2 pixel) {
  return {image.at(pixel.x, pixel.y, 0), image.at(pixel.x, pixel.y, 1),
          image.at(pixel.x, pixel.y, 2)};
}

using Senders = std::array<Sender, lane_count>;

/// What the march through the depth buffer meets.
class DepthSenders {
 public:
  DepthSenders(const Frame& frame, const ParameterSet& parameters, std::span<const Image> lit)
      : lit_(lit),
        march_(depth_march(frame, parameters)),
        d_max_world_(parameters.real32("d_max_world")) {
    surfaces_.push_back(&frame.surface(gbuffer_bits(parameters)));
    if (const std::optional<HiddenSettings> settings = hidden_settings(parameters)) {
      for (const GBufferImages& images : frame.hidden_images(*settings).images) {
        surfaces_.push_back(&images);
      }
    }
  }

  Senders toward(const PixelGroup& group, glm::vec3 direction_tangent, float xi) const {
    const Lanes3 direction = out_of(group.frame, direction_tangent);
    Senders senders;
    for (int i = 0; i < lane_count; ++i) {
      if (!group.active[i]) continue;
      const ShadedPoint point = group.point(i);
      const DepthMarch::Result hit = march_.march(point, at(direction, i), xi, d_max_world_);
      if (!hit.blocked) continue;
      const GBufferImages& surface = *surfaces_[std::size_t(hit.source)];
      senders[std::size_t(i)] = {.share = 1.0f - hit.visibility,
                                 .to_sender = hit.to_surface,
                                 .normal = vec3_at(surface.normal_view, hit.pixel),
                                 .albedo = vec3_at(surface.albedo, hit.pixel),
                                 .lit = lit_.empty()
                                            ? glm::vec3(0.0f)
                                            : vec3_at(lit_[std::size_t(hit.source)], hit.pixel)};
    }
    return senders;
  }

 private:
  std::vector<const GBufferImages*> surfaces_;  ///< the first, then the hidden ones
  std::span<const Image> lit_;
  DepthMarch march_;
  float d_max_world_;
};

/// What rays through the whole scene meet.
class TracedSenders {
 public:
  TracedSenders(const Frame& frame, const PassConstants& constants)
      : rays_(frame.traced(), frame.scene),
        view_(frame.view),
        lift_world_(frame.traced().ray_lift_world()),
        blocker_(constants.blocker) {
    reach_.v.fill(blocker_.d_max_world);
  }

  Senders toward(const PixelGroup& group, glm::vec3 direction_tangent, float) const {
    const Lanes3 direction = out_of(group.frame, direction_tangent);
    const GroupRays rays = rays_of(group, direction, view_, lift_world_);
    const SurfaceRays::Hits hits = rays_.nearest(rays.origin, group.active, rays.direction, reach_);
    const glm::mat3 view_from_world = glm::transpose(view_.world_from_view_rotation());
    Senders senders;
    for (int i = 0; i < lane_count; ++i) {
      const SurfaceRays::Hit& hit = hits[std::size_t(i)];
      if (!hit.found) continue;
      const float visibility =
          blocked_visibility(blocker_.weight, hit.distance, blocker_.d_max_world,
                             blocker_.lambda_per_world, blocker_.fade_start);
      senders[std::size_t(i)] = {.share = 1.0f - visibility,
                                 .to_sender = hit.distance * at(direction, i),
                                 .normal = view_from_world * hit.normal,
                                 .albedo = hit.albedo,
                                 .lit = glm::vec3(0.0f)};
    }
    return senders;
  }

 private:
  SurfaceRays rays_;
  View view_;
  float lift_world_;
  BlockerWeight blocker_;
  Lanes reach_;
};

using SenderSource = std::variant<DepthSenders, TracedSenders>;

SenderSource sender_source(const Frame& frame, const ParameterSet& parameters,
                           std::span<const Image> lit) {
  const PassConstants constants = pass_constants(parameters);
  if (traces(parameters)) return TracedSenders(frame, constants);
  return DepthSenders(frame, parameters, lit);
}

/// f, as bounce.glsl has it.
class FormFactor {
 public:
  explicit FormFactor(const PassConstants& constants)
      : kind_(constants.form_factor),
        samples_(constants.samples),
        area_(patch_area(constants.sender_area, constants.d_max_world, constants.samples)),
        least_(least_distance(constants.distance_clamp, constants.d_max_world, constants.samples)) {
  }

  float operator()(const Sender& sender, glm::vec3 n, float cosine) const {
    if (kind_ == form_factor_solid_angle) return solid_angle_form_factor(cosine, samples_);
    return patch_form_factor(sender.to_sender, n, sender.normal, area_, least_);
  }

 private:
  int kind_;
  int samples_;
  float area_;
  float least_;
};

}  // namespace

Image bounce_on_cpu(const Frame& frame, const ParameterSet& parameters, const Bounce& bounce,
                    std::span<const Image> lit) {
  const GBufferImages& surface = frame.surface(gbuffer_bits(parameters));
  const PassConstants constants = pass_constants(parameters);
  const SampleSet samples =
      make_sample_set(constants.samples, std::uint64_t(parameters.integer("seed")));
  const FormFactor form_factor(constants);
  const SenderSource source = sender_source(frame, parameters, lit);
  Image values(surface.mask.width(), surface.mask.height(), bounce.channels);
  const auto add_group = [&](const PixelGroup& group, int set) {
    std::array<Bounce::Values, lane_count> sums{};
    const float shift = samples.sets[std::size_t(set)].z;
    for (const glm::vec4& s : samples.directions) {
      const Senders senders = std::visit(
          [&](const auto& from) { return from.toward(group, glm::vec3(s), fract(s.w + shift)); },
          source);
      for (int i = 0; i < lane_count; ++i) {
        const auto lane = std::size_t(i);
        const Sender& sender = senders[lane];
        if (!group.active[i] || sender.share == 0.0f) continue;
        const float f = form_factor(sender, at(group.frame.normal, i), s.z);
        bounce.accumulate(sums[lane], sender, sender.share * f);
      }
    }
    for (int i = 0; i < lane_count; ++i) {
      if (!group.active[i]) continue;
      const auto lane = std::size_t(i);
      if (bounce.result) bounce.result(sums[lane]);
      std::copy_n(sums[lane].begin(), bounce.channels,
                  values.pixel(group.pixel[lane].x, group.pixel[lane].y).begin());
    }
  };
  for_each_group(surface, samples, TurnPattern::interleaved, add_group);
  return values;
}

Image light_bounce_on_cpu(const Bounce& bounce, const Image& values, const GBufferImages& surface,
                          const CpuLighting& lighting) {
  Image radiance(values.width(), values.height(), 3);
  parallel_for(std::size_t(values.height()), [&](std::size_t row) {
    throw_if_interrupted();
    const int y = int(row);
    for (int x = 0; x < values.width(); ++x) {
      if (surface.mask.at(x, y) < 0.5f) continue;
      Bounce::Values pixel{};
      std::ranges::copy(values.pixel(x, y), pixel.begin());
      const glm::ivec2 place(x, y);
      const ShadedPoint point{vec3_at(surface.position_view, place),
                              vec3_at(surface.normal_view, place)};
      const glm::vec3 L =
          vec3_at(surface.albedo, place) / pi * bounce.irradiance(pixel, point, lighting);
      for (int c = 0; c < 3; ++c) radiance.at(x, y, c) = L[c];
    }
  });
  return radiance;
}

}  // namespace occlab
