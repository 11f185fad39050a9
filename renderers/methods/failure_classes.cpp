#include "renderers/methods/failure_classes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "renderers/shared/march.h"
#include "renderers/shared/representation_ao.h"
#include "renderers/shared/representation_radiance.h"
#include "renderers/shared/visibility.h"

namespace occlab {
namespace {

glm::vec3 vec3_at(const Image& image, glm::ivec2 pixel) {
  return {image.at(pixel.x, pixel.y, 0), image.at(pixel.x, pixel.y, 1),
          image.at(pixel.x, pixel.y, 2)};
}

/// Sums of V (n.s) and of V L (n.s), a class after the other.
struct ClassSums {
  std::vector<Image> occlusion;
  std::vector<Image> light;

  explicit ClassSums(const Image& mask) {
    for (std::size_t c = 0; c < failure_class_names.size(); ++c) {
      occlusion.emplace_back(mask.width(), mask.height(), 1);
      light.emplace_back(mask.width(), mask.height(), 3);
    }
  }
};

/// A direction of a pixel as both see it.
struct Disagreement {
  ShadedPoint point;
  glm::vec3 direction;
  float march_offset = 0.0f;
  DepthMarch::Result march;
  float hit_distance = 0.0f;  ///< of the ray; infinite where it meets nothing at all
  float traced_visibility = 1.0f;
};

/// Images that show a point, each at a pixel of its own: the first surfaces, and the layers behind
/// them or what other cameras see.
class Looks {
 public:
  Looks(const GBufferImages& surface, const HiddenImages* hidden, const DepthMarch& march)
      : surface_(surface), hidden_(hidden), march_(march) {}

  struct Look {
    const GBufferImages* images;
    const glm::mat4* camera_from_view;  ///< null for the view's own camera
    glm::ivec2 pixel;
    bool first;  ///< whether the images are of first surfaces
    float z(glm::vec3 q) const {
      return camera_from_view ? (*camera_from_view * glm::vec4(q, 1.0f)).z : q.z;
    }
  };

  /// Those that have q on their screens, that of the view's own camera first.
  std::vector<Look> at(glm::vec3 q) const {
    std::vector<Look> looks;
    const std::optional<glm::ivec2> pixel = march_.pixel_of(q);
    if (pixel) looks.push_back({&surface_, nullptr, *pixel, true});
    if (!hidden_) return looks;
    for (std::size_t i = 0; i < hidden_->images.size(); ++i) {
      const GBufferImages& images = hidden_->images[i];
      if (hidden_->cameras.empty()) {
        if (pixel) looks.push_back({&images, nullptr, *pixel, false});
        continue;
      }
      const HiddenCamera& camera = hidden_->cameras[i];
      const glm::vec3 there(camera.camera_from_view * glm::vec4(q, 1.0f));
      const glm::vec2 center = 0.5f * glm::vec2(camera.view.width, camera.view.height);
      const glm::vec2 place = project_to_pixel(there, center, camera.view.focal_pixels());
      if (!on_screen(there, place, center)) continue;
      looks.push_back({&images, &camera.camera_from_view, glm::ivec2(place), true});
    }
    return looks;
  }

 private:
  const GBufferImages& surface_;
  const HiddenImages* hidden_;
  const DepthMarch& march_;
};

class Classifier {
 public:
  Classifier(const Looks& looks, const DepthMarch& march, const PassConstants& constants)
      : looks_(looks), march_(march), constants_(constants) {}

  FailureClass operator()(const Disagreement& d) const {
    return d.march.visibility > d.traced_visibility ? leak(d) : loss(d);
  }

 private:
  /// The ray is blocked at h (more than the march is).
  FailureClass leak(const Disagreement& d) const {
    const glm::vec3 h = d.point.position + d.hit_distance * d.direction;
    const std::vector<Look> looks = looks_.at(h);
    if (looks.empty()) return FailureClass::off_screen;
    const auto shown = [&](const Look& look) { return shows(look, look.pixel, h); };
    if (std::ranges::any_of(looks, shown)) return FailureClass::thin;
    const auto shown_beside = [&](const Look& look) {
      return any_neighbour(look, [&](glm::ivec2 other) { return shows(look, other, h); });
    };
    if (std::ranges::any_of(looks, shown_beside)) return FailureClass::edge;
    // Something nearer than h is seen there, or, with h on a sliver between centres, past it.
    const auto hidden = [&](const Look& look) {
      return !look.first || nearer(look, look.pixel, h);
    };
    return std::ranges::all_of(looks, hidden) ? FailureClass::hidden_blocker : FailureClass::edge;
  }

  /// The march is blocked at its sample (more than the ray is).
  FailureClass loss(const Disagreement& d) const {
    if (std::isfinite(d.hit_distance) && d.hit_distance > constants_.d_max_world) {
      return FailureClass::beyond_radius;
    }
    // A march enters what it takes for a blocker at its silhouette: only where none of its points
    // is inside is the silhouette to blame.
    for (DepthMarch::Result found = d.march; found.blocked;
         found = march_.march(d.point, d.direction, d.march_offset, constants_.d_max_world,
                              found.step + 1)) {
      if (!open_beside(found.sample)) return FailureClass::behind_surface;
    }
    return FailureClass::edge;
  }

  using Look = Looks::Look;

  /// Whether a pixel next to that of a blocked sample, in any image that decides, shows it to be
  /// free. Of layers, one that is not between a pair is.
  bool open_beside(glm::vec3 sample) const {
    const std::vector<Look> looks = looks_.at(sample);
    if (std::ranges::any_of(looks, [](const Look& look) { return !look.first; })) {
      return any_neighbour(looks.front(),
                           [&](glm::ivec2 other) { return !between(looks, other, sample); });
    }
    return std::ranges::any_of(looks, [&](const Look& look) {
      return any_neighbour(look, [&](glm::ivec2 other) { return !nearer(look, other, sample); });
    });
  }

  /// Whether q is between the surfaces of a pair of the pixel; `layers` are in their order.
  bool between(const std::vector<Look>& layers, glm::ivec2 pixel, glm::vec3 q) const {
    for (std::size_t i = 0; i < layers.size(); i += 2) {
      const bool no_back = i + 1 == layers.size() || !seen(layers[i + 1], pixel);
      if (!nearer(layers[i], pixel, q)) return false;
      if (no_back || layers[i + 1].images->position_view.at(pixel.x, pixel.y, 2) < q.z) return true;
    }
    return false;
  }

  static bool seen(const Look& look, glm::ivec2 pixel) {
    return look.images->mask.at(pixel.x, pixel.y) > 0.5f;
  }

  /// Whether q lies on the plane of the surface seen through the pixel.
  bool shows(const Look& look, glm::ivec2 pixel, glm::vec3 q) const {
    if (!seen(look, pixel)) return false;
    const glm::vec3 apart = q - vec3_at(look.images->position_view, pixel);
    const glm::vec3 normal = vec3_at(look.images->geometric_normal_view, pixel);
    return std::abs(dot(apart, normal)) <= on_plane(q);
  }

  /// Whether the surface seen through the pixel is nearer to its camera than q.
  bool nearer(const Look& look, glm::ivec2 pixel, glm::vec3 q) const {
    return seen(look, pixel) &&
           look.z(vec3_at(look.images->position_view, pixel)) > look.z(q) + constants_.bias_world;
  }

  /// A thousandth of the distance to the camera: curved surfaces leave their tangent plane by less
  /// within a pixel, and it is above float noise.
  static float on_plane(glm::vec3 q) { return 1e-3f * length(q); }

  template <typename Test>
  static bool any_neighbour(const Look& look, const Test& test) {
    const glm::ivec2 pixel = look.pixel;
    const Image& mask = look.images->mask;
    for (int y = pixel.y - 1; y <= pixel.y + 1; ++y) {
      for (int x = pixel.x - 1; x <= pixel.x + 1; ++x) {
        const bool inside = x >= 0 && y >= 0 && x < mask.width() && y < mask.height();
        if (inside && glm::ivec2(x, y) != pixel && test(glm::ivec2(x, y))) return true;
      }
    }
    return false;
  }

  const Looks& looks_;
  const DepthMarch& march_;
  const PassConstants& constants_;
};

/// Everything one round reads.
struct Inputs {
  const GBufferImages& surface;
  const Looks& looks;
  const View& view;
  const TracedScene& traced;
  const CpuLighting& lighting;
  const PassConstants& constants;
};

/// One set's directions at the pixels of one group.
class GroupFailures {
 public:
  GroupFailures(const Inputs& in, const DepthMarch& march, const PixelGroup& group)
      : in_(in),
        march_(march),
        classify_(in.looks, march, in.constants),
        group_(group),
        rays_through_(in.traced, in.constants.blocker) {
    everywhere_.v.fill(std::numeric_limits<float>::infinity());
  }

  void add(const glm::vec4& sample, float shift, ClassSums& sums) {
    const Lanes3 direction = out_of(group_.frame, glm::vec3(sample));
    const GroupRays rays = rays_of(group_, direction, in_.view, in_.traced.ray_lift_world());
    const Lanes hit =
        rays_through_.nearest(rays.origin, group_.active, rays.direction, everywhere_);
    const auto radiance = CpuLighting::radiance(in_.lighting.probe_texels(direction));
    for (int i = 0; i < lane_count; ++i) {
      if (!group_.active[i]) continue;
      const ShadedPoint point = group_.point(i);
      const glm::vec3 s = at(direction, i);
      const float xi = fract(sample.w + shift);
      const Disagreement d{.point = point,
                           .direction = s,
                           .march_offset = xi,
                           .march = march_.march(point, s, xi, in_.constants.d_max_world),
                           .hit_distance = hit[i],
                           .traced_visibility = traced_visibility_at(hit[i])};
      const float difference = d.march.visibility - d.traced_visibility;
      if (difference == 0.0f) continue;
      const auto c = std::size_t(classify_(d));
      const glm::ivec2 pixel = group_.pixel[std::size_t(i)];
      ao_accumulate(sums.occlusion[c].at(pixel.x, pixel.y), difference, sample.z);
      for (int channel = 0; channel < 3; ++channel) {
        sums.light[c].at(pixel.x, pixel.y, channel) +=
            difference * sample.z * radiance[std::size_t(channel)][i];
      }
    }
  }

 private:
  float traced_visibility_at(float hit_distance) const {
    if (hit_distance > in_.constants.d_max_world) return 1.0f;
    const BlockerWeight& blocker = in_.constants.blocker;
    return blocked_visibility(blocker.weight, hit_distance, blocker.d_max_world,
                              blocker.lambda_per_world, blocker.fade_start);
  }

  const Inputs& in_;
  const DepthMarch& march_;
  Classifier classify_;
  const PixelGroup& group_;
  PacketVisibility rays_through_;
  Lanes everywhere_;
};

void add_failures(const Inputs& in, const DepthMarch& march, const SampleSet& samples,
                  ClassSums& sums) {
  for_each_group(in.surface, samples, TurnPattern::tiles, [&](const PixelGroup& group, int set) {
    GroupFailures failures(in, march, group);
    for (const glm::vec4& sample : samples.directions) {
      failures.add(sample, samples.sets[std::size_t(set)].z, sums);
    }
  });
}

/// RMS over the surface of half the difference of two halves' k_A, all classes together.
double half_difference(const ClassSums& a, const ClassSums& b, int directions, const Image& mask) {
  double squares = 0.0;
  std::size_t pixels = 0;
  for (std::size_t p = 0; p < mask.pixel_count(); ++p) {
    if (mask.values()[p] < 0.5f) continue;
    float difference = 0.0f;
    for (std::size_t c = 0; c < failure_class_names.size(); ++c) {
      difference += a.occlusion[c].values()[p] - b.occlusion[c].values()[p];
    }
    const double k_A = 0.5 * double(ao_result(difference, directions));
    squares += k_A * k_A;
    ++pixels;
  }
  return pixels == 0 ? 0.0 : std::sqrt(squares / double(pixels));
}

}  // namespace

Failures classify_failures(const GBufferImages& surface, const View& view,
                           const TracedScene& traced, const Lighting& lighting,
                           const PassConstants& constants, const Convergence& convergence,
                           const HiddenImages* hidden) {
  const auto start = std::chrono::steady_clock::now();
  const CpuLighting light(lighting, constants);
  const DepthMarch march(surface, hidden, view, constants);
  const Looks looks(surface, hidden, march);
  const Inputs in{surface, looks, view, traced, light, constants};
  std::array<ClassSums, 2> halves = {ClassSums(surface.mask), ClassSums(surface.mask)};
  Failures result;
  std::uint64_t seed = convergence.seed;
  int per_half = 0;
  for (int directions = convergence.first_round;; directions *= 2) {
    for (ClassSums& half : halves) {
      add_failures(in, march, make_sample_set(directions, seed++), half);
    }
    per_half += directions;
    result.standard_error = half_difference(halves[0], halves[1], per_half, surface.mask);
    result.reached = result.standard_error <= convergence.tolerance;
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    if (result.reached || elapsed.count() > convergence.budget_seconds) break;
  }
  result.directions = 2 * per_half;
  for (std::size_t c = 0; c < failure_class_names.size(); ++c) {
    FailureMaps& maps = result.classes[c];
    maps.occlusion = Image(surface.mask.width(), surface.mask.height(), 1);
    maps.radiance = Image(surface.mask.width(), surface.mask.height(), 3);
    for (std::size_t p = 0; p < surface.mask.pixel_count(); ++p) {
      const float k_A = halves[0].occlusion[c].values()[p] + halves[1].occlusion[c].values()[p];
      maps.occlusion.values()[p] = ao_result(k_A, result.directions);
      for (std::size_t i = 3 * p; i < 3 * p + 3; ++i) {
        const float sum = halves[0].light[c].values()[i] + halves[1].light[c].values()[i];
        maps.radiance.values()[i] =
            surface.albedo.values()[i] / pi * sum * (2.0f * pi / float(result.directions));
      }
    }
  }
  return result;
}

}  // namespace occlab
