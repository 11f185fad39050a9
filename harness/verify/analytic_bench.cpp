#include "harness/verify/analytic_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <glm/gtc/matrix_transform.hpp>

#include "renderers/methods/method.h"
#include "renderers/scene/error.h"
#include "renderers/scene/parallel.h"

namespace occlab {
namespace {

/// What is done to the world: no axis keeps its place.
glm::mat4 placement(World world) {
  if (world == World::plain || world == World::rolled) return glm::mat4(1.0f);
  const glm::mat4 turn = glm::translate(glm::mat4(1.0f), {3, -2, 1}) *
                         glm::rotate(glm::mat4(1.0f), 2.1f, glm::normalize(glm::vec3(1, -2, 3)));
  return world == World::turned ? turn : turn * glm::scale(glm::mat4(1.0f), {-1, 1, 1});
}

/// Mirrored, where the world is mirrored, left to right: a camera itself cannot be.
glm::mat4 placed_camera(const glm::mat4& place, const glm::mat4& world_from_camera, World world) {
  const glm::mat4 camera = place * world_from_camera;
  if (world == World::rolled) return camera * glm::scale(glm::mat4(1.0f), {-1, -1, 1});
  return world == World::mirrored ? camera * glm::scale(glm::mat4(1.0f), {-1, 1, 1}) : camera;
}

Scene placed_scene(Scene scene, const glm::mat4& place) {
  scene.bounds_min = glm::vec3(std::numeric_limits<float>::infinity());
  scene.bounds_max = -scene.bounds_min;
  for (Instance& instance : scene.instances) {
    instance.world_from_object = place * instance.world_from_object;
    for (const glm::vec3& p : scene.meshes[std::size_t(instance.mesh)].positions) {
      const glm::vec3 world(instance.world_from_object * glm::vec4(p, 1.0f));
      scene.bounds_min = glm::min(scene.bounds_min, world);
      scene.bounds_max = glm::max(scene.bounds_max, world);
    }
  }
  for (Light& light : scene.lights) {
    light.position_world = glm::vec3(place * glm::vec4(light.position_world, 1.0f));
    light.direction_world = glm::mat3(place) * light.direction_world;
  }
  return scene;
}

GBufferImages one_point(const AnalyticPoint& point) {
  const auto pixel = [](glm::vec3 value) {
    Image image(1, 1, 3);
    for (int c = 0; c < 3; ++c) image.at(0, 0, c) = value[c];
    return image;
  };
  return {pixel(point.position), pixel(point.normal), pixel(point.geometric_normal),
          pixel(glm::vec3(1.0f)), Image(1, 1, 1, 1.0f)};
}

/// The case's region of a layer, put right where the picture is mirrored or upside down.
Image cropped(const Image& layer, const AnalyticRegion& region, World world) {
  const bool flips_x = world == World::mirrored || world == World::rolled;
  const bool flips_y = world == World::rolled;
  Image part(region.columns, region.rows, layer.channels());
  for (int y = 0; y < region.rows; ++y) {
    for (int x = 0; x < region.columns; ++x) {
      const int column = flips_x ? region.width - 1 - (region.x + x) : region.x + x;
      const int row = flips_y ? region.height - 1 - (region.y + y) : region.y + y;
      std::ranges::copy(layer.pixel(column, row), part.pixel(x, y).begin());
    }
  }
  return part;
}

Image vectors_in_world(const Image& view, const glm::mat3& world_from_view) {
  Image world(view.width(), view.height(), 3);
  for (int y = 0; y < view.height(); ++y) {
    for (int x = 0; x < view.width(); ++x) {
      const glm::vec3 v =
          world_from_view * glm::vec3(view.at(x, y, 0), view.at(x, y, 1), view.at(x, y, 2));
      for (int c = 0; c < 3; ++c) world.at(x, y, c) = v[c];
    }
  }
  return world;
}

std::array<double, 16> coefficients(glm::vec3 direction) {
  const Sh4 y = sh_basis(direction);
  const std::array<vec4, 4> quarters = {y.c0, y.c1, y.c2, y.c3};
  std::array<double, 16> values{};
  for (std::size_t i = 0; i < 16; ++i) values[i] = double(quarters[i / 4][int(i % 4)]);
  return values;
}

/// D_ij = int y_i(w) y_j(V w) dw, by a rule that is exact for products of order-4 harmonics: four
/// Gauss-Legendre heights (degree 7) and eight azimuths.
std::array<std::array<double, 16>, 16> sh_rotation(const glm::mat3& view_from_world) {
  constexpr std::array<double, 4> heights = {-0.8611363115940526, -0.3399810435848563,
                                             0.3399810435848563, 0.8611363115940526};
  constexpr std::array<double, 4> weights = {0.3478548451374538, 0.6521451548625461,
                                             0.6521451548625461, 0.3478548451374538};
  std::array<std::array<double, 16>, 16> matrix{};
  for (std::size_t h = 0; h < 4; ++h) {
    for (int a = 0; a < 8; ++a) {
      const double phi = 0.25 * double(pi) * a;
      const double r = std::sqrt(1.0 - heights[h] * heights[h]);
      const glm::vec3 w(r * std::cos(phi), r * std::sin(phi), heights[h]);
      const auto world = coefficients(w);
      const auto view = coefficients(view_from_world * w);
      for (std::size_t i = 0; i < 16; ++i) {
        for (std::size_t j = 0; j < 16; ++j) {
          matrix[i][j] += weights[h] * 0.25 * double(pi) * world[i] * view[j];
        }
      }
    }
  }
  return matrix;
}

}  // namespace

struct AnalyticBench::Place {
  Place(Scene placed, const glm::mat4& where) : scene(std::move(placed)), world_from_file(where) {}
  Scene scene;
  GpuScene gpu_scene{scene};
  glm::mat4 world_from_file;
};

AnalyticBench::AnalyticBench(const AnalyticFile& file, ProgramCache& programs)
    : path_(file.path), scene_(load_scene(file.path)), programs_(programs) {}

AnalyticBench::~AnalyticBench() = default;

const AnalyticBench::Place& AnalyticBench::place(World world) {
  auto& made = places_[world];
  if (!made) {
    const glm::mat4 where = placement(world);
    made = std::make_unique<Place>(world == World::plain ? scene_ : placed_scene(scene_, where),
                                   where);
  }
  return *made;
}

Frame& AnalyticBench::frame(const AnalyticCase& one, World world) {
  View view;
  view.width = view.height = 1;
  std::string key = fmt::format("{} {}", int(world), one.sky->name);
  const Place& at = place(world);
  if (one.region) {
    view = {find_camera(scene_, one.region->camera), one.region->width, one.region->height};
    view.camera.world_from_camera =
        placed_camera(at.world_from_file, view.camera.world_from_camera, world);
    key += fmt::format(" {} {}x{}", view.camera.name, view.width, view.height);
  }
  auto& made = frames_[key];
  if (!made) {
    Environment sky = *one.sky;
    sky.probe_from_world = sky.probe_from_world * glm::mat3(glm::inverse(at.world_from_file));
    made = std::make_unique<Frame>(Frame{.scene = at.scene,
                                         .gpu_scene = at.gpu_scene,
                                         .view = view,
                                         .lighting = Lighting(sky, at.scene.lights, view),
                                         .programs = programs_});
    made->traced();
  }
  if (one.point) made->made.surfaces.front() = one_point(*one.point);
  return *made;
}

std::vector<Layers> AnalyticBench::render_layers(const AnalyticCase& one,
                                                 const AnalyticQuantity& quantity, World world,
                                                 int first_seed, int seeds) {
  const Frame& seen = frame(one, world);
  const MethodInfo& method = find_method(quantity.method);
  std::vector<Layers> repetitions(static_cast<std::size_t>(seeds));
  const auto repeat = [&](OcclusionMethod& with, std::size_t i) {
    ParameterSet parameters = quantity.parameters();
    parameters.set("seed", long(first_seed) + long(i));
    Metadata facts;
    repetitions[i] = with.evaluate(seen, parameters, facts);
  };
  if (one.point) {
    // Too small to keep every thread busy by itself, and no graphics context is needed.
    parallel_for(repetitions.size(), [&](std::size_t i) { repeat(*method.make(), i); });
  } else {
    const auto with = method.make();
    for (std::size_t i = 0; i < repetitions.size(); ++i) repeat(*with, i);
  }
  return repetitions;
}

std::vector<Image> AnalyticBench::render(const AnalyticCase& one, const AnalyticQuantity& quantity,
                                         World world, int first_seed, int seeds) {
  const AnalyticRegion region = one.region.value_or(
      AnalyticRegion{.camera = {}, .width = 1, .height = 1, .columns = 1, .rows = 1});
  const Image shown = cropped(frame(one, world).surface().mask, region, world);
  if (std::ranges::count(shown.values(), 0.0f) > 0) {
    throw InputError(fmt::format(
        "{}.view.pixels: some show no surface; accepted: pixels that all do", one.place));
  }
  const std::string view = fmt::format("{} {}x{}", region.camera, region.width, region.height);
  // Points are shaded anew: no two cases share one.
  if (one.point || view != rendered_view_) rendered_.clear();
  rendered_view_ = view;
  const std::string key =
      fmt::format("{} {} {} {} {}+{}", int(world), one.sky->name, quantity.method,
                  quantity.parameters().to_string(), first_seed, seeds);
  auto made = rendered_.find(key);
  if (made == rendered_.end()) {
    made = rendered_.emplace(key, render_layers(one, quantity, world, first_seed, seeds)).first;
  }
  const glm::mat3 world_from_view = frame(one, world).view.world_from_view_rotation();
  std::vector<Image> images;
  for (const Layers& layers : made->second) {
    images.push_back(cropped(layers.at(quantity.layer), region, world));
    if (quantity.layer == "bent_normal") {
      images.back() = vectors_in_world(images.back(), world_from_view);
    } else if (quantity.layer == "sh_visibility") {
      images.back() = sh_in_world(images.back(), glm::transpose(world_from_view));
    }
  }
  return images;
}

Image sh_in_world(const Image& sh_view, const glm::mat3& view_from_world) {
  const auto turn = sh_rotation(view_from_world);
  Image world(sh_view.width(), sh_view.height(), 16);
  for (std::size_t p = 0; p < world.pixel_count(); ++p) {
    for (std::size_t i = 0; i < 16; ++i) {
      double sum = 0.0;
      for (std::size_t j = 0; j < 16; ++j) {
        sum += turn[i][j] * double(sh_view.values()[16 * p + j]);
      }
      world.values()[16 * p + i] = float(sum);
    }
  }
  return world;
}

}  // namespace occlab
