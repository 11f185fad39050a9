#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "renderers/scene/error.h"
#include "renderers/scene/gltf_parts.h"
#include "renderers/scene/limits.h"
#include "renderers/scene/parallel.h"

namespace occlab {
namespace {

/// Extensions without which a file may say it cannot be read, and that we do read. The two material
/// ones change only what a Lambertian surface does not have.
const std::vector<std::string> accepted_extensions = {
    "KHR_lights_punctual", "KHR_materials_ior", "KHR_materials_specular", "KHR_mesh_quantization",
    "KHR_texture_transform"};

std::string node_name(const JsonValue& node, const std::string& fallback) {
  const std::string name = node.text_or("name", "");
  return name.empty() ? fallback : name;
}

class SceneLoader {
 public:
  explicit SceneLoader(const std::filesystem::path& path) : file_(path), materials_(file_, scene_) {
    scene_.name = path.stem().string();
    scene_.path = path;
  }

  Scene load() {
    check_extensions();
    const JsonValue root_scene = active_scene();
    walk(root_scene);
    read_extras(root_scene);
    if (scene_.cameras.empty()) {
      throw InputError(fmt::format("{}: no camera; at least one perspective camera is needed",
                                   file_.path().string()));
    }
    if (scene_.triangle_count() == 0) {
      throw InputError(
          fmt::format("{}: no triangles; at least one is needed", file_.path().string()));
    }
    warn_of_whole_file();
    compute_bounds();
    finish_cameras();
    return std::move(scene_);
  }

 private:
  void check_extensions() const {
    for (const JsonValue& extension : file_.root().array("extensionsRequired")) {
      const std::string name = extension.text();
      if (std::ranges::find(accepted_extensions, name) == accepted_extensions.end()) {
        extension.fail(fmt::format("the file requires '{}'; accepted: {}", name,
                                   fmt::join(accepted_extensions, ", ")));
      }
    }
  }

  JsonValue active_scene() const {
    const auto& scenes = file_.list("scenes");
    if (scenes.empty()) file_.root().fail("has no scene");
    const auto chosen = file_.root().find("scene");
    return scenes[chosen ? chosen->index(scenes.size(), "scenes") : 0];
  }

  /// Without recursion: a file may nest nodes deeper than the stack.
  void walk(const JsonValue& root_scene) {
    struct Visit {
      std::size_t node;
      glm::dmat4 world_from_parent;
    };
    const auto& nodes = file_.list("nodes");
    std::vector<bool> visited(nodes.size(), false);
    std::vector<Visit> pending;
    const auto push = [&](const std::vector<JsonValue>& children, const glm::dmat4& parent) {
      // Reversed, so that nodes are visited in the file's order.
      for (auto child = children.rbegin(); child != children.rend(); ++child) {
        const std::size_t index = child->index(nodes.size(), "nodes");
        if (visited[index]) {
          child->fail(
              fmt::format("node {} is its own descendant or has two parents; the nodes "
                          "must form trees",
                          index));
        }
        visited[index] = true;
        pending.push_back({index, parent});
      }
    };
    push(root_scene.array("nodes"), glm::dmat4(1.0));
    while (!pending.empty()) {
      const Visit visit = pending.back();
      pending.pop_back();
      const JsonValue& node = nodes[visit.node];
      const glm::dmat4 world = visit.world_from_parent * local_transform(node);
      require_float_range(node, world);
      add_node(node, visit.node, world);
      push(node.array("children"), world);
    }
  }

  void add_node(const JsonValue& node, std::size_t index, const glm::dmat4& world) {
    if (const auto mesh = node.find("mesh")) {
      add_instances(node, mesh->index(file_.list("meshes").size(), "meshes"), world);
    }
    if (const auto camera = node.find("camera")) {
      const auto& cameras = file_.list("cameras");
      add_camera(node, cameras[camera->index(cameras.size(), "cameras")], world);
    }
    const auto extensions = node.find("extensions");
    if (!extensions) return;
    if (const auto punctual = extensions->find("KHR_lights_punctual")) {
      if (!lights_) lights_ = lights();
      const std::vector<JsonValue>& list = *lights_;
      add_light(node_name(node, fmt::format("light {}", index)),
                list[punctual->at("light").index(list.size(), "lights")], world);
    }
    if (extensions->find("EXT_mesh_gpu_instancing")) {
      extensions->fail("EXT_mesh_gpu_instancing is not accepted; export instances as nodes");
    }
  }

  void add_instances(const JsonValue& node, std::size_t gltf_mesh, const glm::dmat4& world) {
    if (node.find("skin")) {
      scene_.warnings.push_back(
          fmt::format("node '{}': its skin is not used; it keeps its bind pose",
                      node_name(node, "without name")));
    }
    if (!is_invertible(glm::mat3(world))) {
      node.fail(
          fmt::format("the transform of this mesh has determinant {}; it must be invertible in "
                      "floats",
                      glm::determinant(glm::dmat3(world))));
    }
    const std::vector<int>& meshes = meshes_of(gltf_mesh);
    require_within(Limit::instances, scene_.instances.size() + meshes.size(),
                   "instances, with those before", node.where());
    for (const int mesh : meshes) {
      triangles_ = saturating_add(triangles_, scene_.meshes[std::size_t(mesh)].indices.size() / 3);
      scene_.instances.push_back({mesh, glm::mat4(world)});
    }
    require_within(Limit::triangles, triangles_, "triangles in instances, with those before",
                   node.where());
  }

  /// Indices into Scene::meshes of a glTF mesh's primitives; read at first use, shared afterwards.
  const std::vector<int>& meshes_of(std::size_t gltf_mesh) {
    const auto [entry, is_new] = loaded_meshes_.try_emplace(gltf_mesh);
    if (is_new) {
      const JsonValue& json = file_.list("meshes")[gltf_mesh];
      const std::string name = node_name(json, fmt::format("mesh {}", gltf_mesh));
      const auto primitives = json.array("primitives");
      if (primitives.empty()) json.fail("has no primitives");
      for (const JsonValue& primitive : primitives) {
        if (auto mesh =
                load_primitive(file_, primitive, name, materials_, geometry_, scene_.warnings)) {
          entry->second.push_back(int(scene_.meshes.size()));
          scene_.meshes.push_back(std::move(*mesh));
        }
      }
    }
    return entry->second;
  }

  void add_camera(const JsonValue& node, const JsonValue& json, const glm::dmat4& world) {
    require_within(Limit::cameras, scene_.cameras.size() + 1, "cameras", node.where());
    Camera camera;
    camera.name =
        node_name(node, json.text_or("name", fmt::format("camera {}", scene_.cameras.size())));
    const std::string type = json.at("type").text();
    if (type != "perspective") {
      json.fail(
          fmt::format("camera '{}' is of type '{}'; accepted: perspective", camera.name, type));
    }
    if (std::ranges::find(scene_.cameras, camera.name, &Camera::name) != scene_.cameras.end()) {
      node.fail(fmt::format("two cameras are called '{}'; their names must differ", camera.name));
    }
    const JsonValue lens = json.at("perspective");
    const auto positive = [&](const char* key, double fallback, double limit) {
      const double value = lens.number_or(key, fallback);
      // A tiny number may be 0 as a float.
      if (!(float(value) > 0.0f && value < limit)) {
        lens.at(key).fail(fmt::format("found {:g}; accepted: above 0, below {:g}", value, limit));
      }
      return float(value);
    };
    constexpr double no_limit = std::numeric_limits<float>::max();
    lens.at("yfov");
    lens.at("znear");
    camera.yfov = positive("yfov", 0.0, std::numbers::pi);
    camera.aspect = positive("aspectRatio", camera.aspect, no_limit);
    camera.znear = positive("znear", 0.0, no_limit);
    // 0 stands for an infinite projection until the bounds are known.
    camera.zfar = lens.find("zfar") ? positive("zfar", 0.0, no_limit) : 0.0f;
    if (camera.zfar != 0.0f && camera.zfar <= camera.znear) {
      lens.fail(fmt::format("zfar {:g} is not beyond znear {:g}", camera.zfar, camera.znear));
    }
    camera.world_from_camera = glm::mat4(camera_transform(node, world));
    scene_.cameras.push_back(std::move(camera));
  }

  std::vector<JsonValue> lights() const {
    const auto extensions = file_.root().find("extensions");
    const auto punctual = extensions ? extensions->find("KHR_lights_punctual") : std::nullopt;
    return punctual ? punctual->array("lights") : std::vector<JsonValue>{};
  }

  void add_light(const std::string& name, const JsonValue& json, const glm::dmat4& world) {
    require_within(Limit::lights, scene_.lights.size() + 1, "lights", json.where());
    Light light;
    light.name = name;
    const std::string type = json.at("type").text();
    if (type == "point") {
      light.type = LightType::point;
    } else if (type == "directional") {
      light.type = LightType::directional;
    } else if (type == "spot") {
      light.type = LightType::spot;
    } else {
      json.at("type").fail(fmt::format("found '{}'; accepted: point, directional, spot", type));
    }
    std::vector<double> color{1.0, 1.0, 1.0};
    if (const auto found = json.find("color")) color = found->numbers(3);
    const double intensity = json.number_or("intensity", 1.0);
    if (std::ranges::any_of(color, [](double c) { return c < 0.0; }) || intensity < 0.0) {
      json.fail("a negative intensity or colour; accepted: at least 0");
    }
    if (intensity * std::ranges::max(color) > double(std::numeric_limits<float>::max())) {
      json.fail("its intensity times its colour is beyond the range of float");
    }
    light.intensity = glm::vec3(intensity * glm::dvec3(color[0], color[1], color[2]));
    if (json.find("range")) {
      scene_.warnings.push_back(
          fmt::format("light '{}': its range is not used; it falls off as 1/d^2", name));
    }
    if (light.type == LightType::spot) {
      const JsonValue spot = json.at("spot");
      const double inner = spot.number_or("innerConeAngle", 0.0);
      const double outer = spot.number_or("outerConeAngle", std::numbers::pi / 4.0);
      // A float's half pi may lie above the double's.
      if (!(inner >= 0.0 && inner <= outer && float(outer) > 0.0f &&
            outer <= std::numbers::pi / 2.0 + 1e-6)) {
        spot.fail(
            fmt::format("innerConeAngle {:g}, outerConeAngle {:g}; accepted: 0 <= inner <= "
                        "outer <= pi/2",
                        inner, outer));
      }
      light.inner_cone_angle = float(inner);
      light.outer_cone_angle = float(outer);
    }
    light.position_world = glm::vec3(world[3]);
    const glm::dvec3 axis = world[2];
    if (!(glm::length(axis) > 0.0)) json.fail("the transform of its node is singular");
    light.direction_world = glm::vec3(-glm::normalize(axis));
    scene_.lights.push_back(std::move(light));
  }

  /// What scenes/export.py adds for occlab: scenes/FORMAT.md.
  void read_extras(const JsonValue& root_scene) {
    const auto extras = root_scene.find("extras");
    const auto ours = extras ? extras->find("occlab") : std::nullopt;
    if (!ours) return;
    ours->require_keys({"format", "lights", "resolution", "warnings", "world"});
    const JsonValue format = ours->at("format");
    if (format.unsigned_integer() != 1) {
      format.fail(fmt::format("found {}; accepted: 1", format.unsigned_integer()));
    }
    for (const JsonValue& warning : ours->array("warnings")) {
      scene_.warnings.push_back("export: " + warning.text());
    }
    const auto world = ours->find("world");
    if (!world) return;
    if (const auto radiance = world->find("radiance")) {
      world->require_keys({"radiance"});
      const std::vector<double> rgb = radiance->numbers(3);
      scene_.warnings.push_back(
          fmt::format("the world's constant radiance {:g} {:g} {:g} is not used; choose a probe",
                      rgb[0], rgb[1], rgb[2]));
      return;
    }
    world->require_keys({"probe", "rotation_degrees", "strength"});
    SceneEnvironment environment;
    environment.probe = world->at("probe").text();
    environment.rotation_degrees = world->real_or("rotation_degrees", 0.0f);
    environment.strength = world->real_or("strength", 1.0f);
    if (environment.probe.empty()) world->at("probe").fail("is empty; accepted: a name or a path");
    if (environment.strength < 0.0f) {
      world->at("strength").fail("is negative; accepted: at least 0");
    }
    scene_.environment = environment;
  }

  void warn_of_whole_file() {
    if (!file_.root().array("animations").empty()) {
      scene_.warnings.emplace_back("animations are not used; everything keeps its pose");
    }
    // The same warning for every primitive says nothing new.
    std::set<std::string> seen;
    std::erase_if(scene_.warnings, [&](const std::string& w) { return !seen.insert(w).second; });
  }

  void compute_bounds() {
    struct Box {
      glm::vec3 low{std::numeric_limits<float>::infinity()};
      glm::vec3 high{-std::numeric_limits<float>::infinity()};
    };
    std::vector<Box> boxes(scene_.instances.size());
    parallel_for(boxes.size(), [&](std::size_t i) {
      const Instance& instance = scene_.instances[i];
      Box box;
      for (const glm::vec3& position : scene_.meshes[std::size_t(instance.mesh)].positions) {
        const glm::vec3 world = instance.world_from_object * glm::vec4(position, 1.0f);
        box.low = glm::min(box.low, world);
        box.high = glm::max(box.high, world);
      }
      boxes[i] = box;
    });
    Box all;
    for (const Box& box : boxes) {
      all.low = glm::min(all.low, box.low);
      all.high = glm::max(all.high, box.high);
    }
    scene_.bounds_min = all.low;
    scene_.bounds_max = all.high;
    // Squares of distances must be floats, too, also of scenes far from the origin.
    if (!std::isfinite(scene_.bounding_radius()) || !std::isfinite(glm::length(all.low)) ||
        !std::isfinite(glm::length(all.high))) {
      throw InputError(
          fmt::format("{}: the scene's size is beyond the range of float", file_.path().string()));
    }
  }

  void finish_cameras() {
    for (Camera& camera : scene_.cameras) {
      const glm::vec3 eye(camera.world_from_camera[3]);
      if (!std::isfinite(glm::length(eye))) {
        throw InputError(fmt::format("{}: the place of camera '{}' is beyond the range of float",
                                     file_.path().string(), camera.name));
      }
      if (camera.zfar != 0.0f) continue;
      const glm::vec3 farthest =
          glm::max(glm::abs(scene_.bounds_min - eye), glm::abs(scene_.bounds_max - eye));
      camera.zfar = std::max(1.01f * glm::length(farthest), 2.0f * camera.znear);
      scene_.warnings.push_back(
          fmt::format("camera '{}' has no zfar; {:g}, beyond the whole scene, is used", camera.name,
                      camera.zfar));
    }
  }

  GltfFile file_;
  Scene scene_;
  MaterialTable materials_;
  GeometryTotals geometry_;
  std::uint64_t triangles_ = 0;  // instances counted
  std::optional<std::vector<JsonValue>> lights_;
  std::map<std::size_t, std::vector<int>> loaded_meshes_;
};

}  // namespace

Scene load_scene(const std::filesystem::path& path) { return SceneLoader(path).load(); }

}  // namespace occlab
