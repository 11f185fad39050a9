#include "harness/verify/reference_identities.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "harness/statistics.h"
#include "renderers/methods/cpu_passes.h"
#include "renderers/scene/error.h"
#include "renderers/shared/equirect.h"

namespace occlab {
namespace {

constexpr int region_size = 8;
constexpr std::size_t fewest_pixels = 16;

/// make_sample_set() with each height moved to a random place of its stratum. Its own heights are
/// the strata's middles, of which the mean over seeds has the midpoint rule's error.
SampleSet unbiased_sample_set(int count, std::uint64_t seed) {
  SampleSet set = make_sample_set(count, seed);
  std::mt19937_64 random(seed ^ 0x9e3779b97f4a7c15u);
  for (std::size_t i = 0; i < set.directions.size(); ++i) {
    glm::vec4& s = set.directions[i];
    const double z = (double(i) + double(random() >> 11) * 0x1p-53) / double(count);
    const double stretch = std::sqrt((1.0 - z * z) / (1.0 - double(s.z) * double(s.z)));
    s = glm::vec4(stretch * double(s.x), stretch * double(s.y), z, s.w);
  }
  return set;
}

/// The layers of one replicate, from either side.
constexpr std::array<const char*, 3> layer_names = {"ssao_ambient_occlusion", "s3ho_radiance",
                                                    "ssdo_radiance"};
using Replicate = std::array<Image, layer_names.size()>;

class TracedRepresentations {
 public:
  TracedRepresentations(const Frame& frame, const PassConstants& constants,
                        const CpuLighting& lighting)
      : surface_(frame.surface()),
        constants_(constants),
        lighting_(lighting),
        visibility_(traced_visibility(frame.traced(), frame.view, constants)) {}

  Replicate render(int directions, std::uint64_t seed) const {
    const std::array<const Representation*, 3> representations = {
        find_method("ssao").representation, find_method("s3ho").representation,
        find_method("ssdo").representation};
    std::vector<Image> sums;
    for (const Representation* r : representations) {
      sums.emplace_back(surface_.mask.width(), surface_.mask.height(), r->channels);
    }
    add_directions({surface_, lighting_, constants_, visibility_},
                   unbiased_sample_set(directions, seed), TurnPattern::interleaved, representations,
                   sums);
    const auto values = [&](std::size_t r) {
      return representation_of(*representations[r], sums[r], directions);
    };
    const auto lit = [&](std::size_t r) {
      return light_on_cpu(*representations[r], values(r), surface_, lighting_);
    };
    return {values(0), lit(1), lit(2)};
  }

 private:
  const GBufferImages& surface_;
  const PassConstants& constants_;
  const CpuLighting& lighting_;
  VisibilitySource visibility_;
};

Replicate render_reference(const Frame& frame, const ParameterSet& parameters, long rays,
                           std::uint64_t seed) {
  const MethodInfo& rtdo = find_method("rtdo");
  ParameterSet settings(rtdo.parameters);
  for (const char* shared : {"d_max_world", "weight", "lambda_per_world", "fade_start"}) {
    settings.set(shared, parameters.value(shared));
  }
  settings.set("rays_per_pixel", rays);
  settings.set("seed", long(seed));
  Metadata facts;
  const Layers layers = rtdo.make()->evaluate(frame, settings, facts);
  return {layers.at("ambient_occlusion"), layers.at("radiance"), layers.at("radiance")};
}

struct Region {
  std::string name;
  std::vector<std::size_t> pixels;
};

std::vector<Region> regions_of(const Image& mask) {
  std::vector<Region> regions;
  Region picture{"the picture", {}};
  for (int y0 = 0; y0 < mask.height(); y0 += region_size) {
    for (int x0 = 0; x0 < mask.width(); x0 += region_size) {
      Region block{fmt::format("the block at ({}, {})", x0, y0), {}};
      for (int y = y0; y < std::min(y0 + region_size, mask.height()); ++y) {
        for (int x = x0; x < std::min(x0 + region_size, mask.width()); ++x) {
          if (mask.at(x, y) < 0.5f) continue;
          block.pixels.push_back(std::size_t(y) * std::size_t(mask.width()) + std::size_t(x));
        }
      }
      picture.pixels.insert(picture.pixels.end(), block.pixels.begin(), block.pixels.end());
      if (block.pixels.size() >= fewest_pixels) regions.push_back(std::move(block));
    }
  }
  regions.push_back(std::move(picture));
  return regions;
}

double region_mean(const Image& image, const Region& region, int channel) {
  double sum = 0.0;
  for (const std::size_t p : region.pixels) {
    sum += double(image.values()[p * std::size_t(image.channels()) + std::size_t(channel)]);
  }
  return sum / double(region.pixels.size());
}

/// Pairs of replicates, one layer and channel, as means over a region.
RegionMeans compare(const std::vector<Replicate>& traced, const std::vector<Replicate>& reference,
                    std::size_t layer, int channel, const Region& region) {
  std::vector<double> a;
  std::vector<double> b;
  std::vector<double> difference;
  for (std::size_t r = 0; r < traced.size(); ++r) {
    a.push_back(region_mean(traced[r][layer], region, channel));
    b.push_back(region_mean(reference[r][layer], region, channel));
    difference.push_back(a.back() - b.back());
  }
  return {.layer = layer_names[layer],
          .channel = channel,
          .region = region.name,
          .measured = mean(a),
          .expected = mean(b),
          .standard_error = std::sqrt(variance(difference) / double(difference.size()))};
}

LayerAgreement mean_images(const std::vector<Replicate>& traced,
                           const std::vector<Replicate>& reference) {
  LayerAgreement images;
  std::vector<double> a(traced.size());
  std::vector<double> b(traced.size());
  std::vector<double> difference(traced.size());
  for (std::size_t layer = 0; layer < layer_names.size(); ++layer) {
    const Image& first = traced.front()[layer];
    Image measured(first.width(), first.height(), first.channels());
    Image expected = measured;
    Image error = measured;
    for (std::size_t i = 0; i < first.values().size(); ++i) {
      for (std::size_t r = 0; r < traced.size(); ++r) {
        a[r] = double(traced[r][layer].values()[i]);
        b[r] = double(reference[r][layer].values()[i]);
        difference[r] = a[r] - b[r];
      }
      measured.values()[i] = float(mean(a));
      expected.values()[i] = float(mean(b));
      error.values()[i] = float(std::sqrt(variance(difference) / double(traced.size())));
    }
    images.measured.add(layer_names[layer], std::move(measured));
    images.expected.add(layer_names[layer], std::move(expected));
    images.bounds.add(layer_names[layer], std::move(error));
  }
  return images;
}

}  // namespace

Environment order4_environment(const Environment& probe, int width) {
  Environment result;
  result.name = fmt::format("{}, order 4", probe.name);
  result.probe_from_world = probe.probe_from_world;
  const ShRgb light = project_sh(probe, glm::transpose(probe.probe_from_world));
  const int height = width / 2;
  result.texels = Image(width, height, 3);
  std::array<float, 3> lowest{};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const glm::vec2 uv = (glm::vec2(x, y) + 0.5f) / glm::vec2(width, height);
      const glm::vec3 radiance = sh_dot_rgb(light, sh_basis(equirect_direction(uv)));
      for (int c = 0; c < 3; ++c) {
        result.texels.at(x, y, c) = radiance[c];
        lowest[std::size_t(c)] = std::min(lowest[std::size_t(c)], radiance[c]);
      }
    }
  }
  for (std::size_t i = 0; i < result.texels.values().size(); ++i) {
    result.texels.values()[i] -= lowest[i % 3];
  }
  return result;
}

ReferenceComparison compare_to_reference(const Frame& frame, const ParameterSet& parameters,
                                         const Replication& replication) {
  if (replication.replicates < 4) {
    throw InputError(
        fmt::format("replicates: found {}; accepted: 4 and more", replication.replicates));
  }
  const PassConstants constants = pass_constants(parameters);
  const CpuLighting lighting(frame.lighting, constants);
  const TracedRepresentations representations(frame, constants, lighting);
  std::vector<Replicate> traced;
  std::vector<Replicate> reference;
  for (int r = 0; r < replication.replicates; ++r) {
    const std::uint64_t seed = replication.seed + std::uint64_t(r);
    traced.push_back(representations.render(replication.directions, seed));
    reference.push_back(render_reference(frame, parameters, replication.rays_per_pixel, seed));
  }
  ReferenceComparison comparison{.regions = {}, .images = mean_images(traced, reference)};
  for (const Region& region : regions_of(frame.surface().mask)) {
    for (std::size_t layer = 0; layer < layer_names.size(); ++layer) {
      for (int c = 0; c < traced.front()[layer].channels(); ++c) {
        comparison.regions.push_back(compare(traced, reference, layer, c, region));
      }
    }
  }
  return comparison;
}

const RegionMeans& worst_region(const ReferenceComparison& comparison, const std::string& layer) {
  const RegionMeans* worst = nullptr;
  double most = -1.0;
  for (const RegionMeans& region : comparison.regions) {
    if (region.layer != layer) continue;
    const double error = std::abs(region.measured - region.expected);
    double errors = error == 0.0 ? 0.0 : error / region.standard_error;
    if (std::isnan(errors)) errors = std::numeric_limits<double>::infinity();
    if (errors <= most) continue;
    most = errors;
    worst = &region;
  }
  if (worst == nullptr) throw InputError(fmt::format("no region of a layer '{}'", layer));
  return *worst;
}

double critical_standard_errors(double family_level, int tests, int replicates) {
  return -student_quantile(0.5 * sidak_level(family_level, tests), double(replicates - 1));
}

}  // namespace occlab
