// A device, and frames of built scenes on it, for tests of the passes.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <initializer_list>
#include <memory>

#include "renderers/gl/context.h"
#include "renderers/methods/frame.h"
#include "renderers/methods/method.h"
#include "tests/analytic/built_scenes.h"

namespace occlab::test {

/// One context and one program cache for a test program.
inline const DeviceInfo& device() {
  static const Context context("surfaceless");
  return context.info();
}

inline ProgramCache& programs() {
  static ProgramCache cache;
  return cache;
}

inline View look_at(glm::vec3 eye, glm::vec3 target, float yfov, int width, int height,
                    glm::vec3 up = {0, 1, 0}) {
  View view;
  view.camera.world_from_camera = glm::inverse(glm::lookAt(eye, target, up));
  view.camera.yfov = yfov;
  view.camera.znear = 0.05f;
  view.camera.zfar = 200.0f;
  view.width = width;
  view.height = height;
  return view;
}

/// Values of parameters, by name.
using Values = std::vector<std::pair<std::string, ParameterValue>>;

/// A built scene seen and lit one way.
class TestFrame {
 public:
  TestFrame(Scene scene, const View& view, Environment environment, std::vector<Light> lights = {})
      : ready_(device().renderer.empty()),
        scene_(std::move(scene)),
        gpu_scene_(scene_),
        frame_{.scene = scene_,
               .gpu_scene = gpu_scene_,
               .view = view,
               .lighting = Lighting(std::move(environment), std::move(lights), view),
               .programs = programs()} {}

  const Frame& frame() const { return frame_; }
  const GBufferImages& surface() const { return frame_.surface(); }
  int width() const { return frame_.view.width; }
  int height() const { return frame_.view.height; }

  /// `facts`, if wanted, are the method's.
  Layers evaluate(const std::string& method, const Values& values,
                  Metadata* facts = nullptr) const {
    const MethodInfo& info = find_method(method);
    ParameterSet parameters(info.parameters);
    for (const auto& [name, value] : values) parameters.set(name, value);
    Metadata ignored;
    return info.make()->evaluate(frame_, parameters, facts ? *facts : ignored);
  }
  Image layer(const std::string& method, const std::string& name, const Values& values) const {
    return evaluate(method, values).at(name);
  }

 private:
  bool ready_;  // the context is made before anything uses it
  Scene scene_;
  GpuScene gpu_scene_;
  Frame frame_;
};

/// Those of direct light.
inline const std::vector<std::string> screen_space_methods = {"ssao", "s3ho", "ssdo", "ssbn"};
/// Those with a bounce.
inline const std::vector<std::string> bounce_methods = {"s3hogi", "ssdogi"};

/// The layer that holds a method's ambient occlusion, "" if it has none.
inline std::string occlusion_layer(const std::string& method) {
  for (const std::string& layer : find_method(method).layers) {
    if (layer.ends_with("_occlusion")) return layer;
  }
  return "";
}

inline glm::dvec3 pixel3(const Image& image, int x, int y) {
  return {image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)};
}

/// The floor y = 0, facing up, and the wall x = 0, facing +X.
inline Scene floor_and_tall_wall(float size = 20.0f) {
  return SceneBuilder()
      .add(quad({0, 0, -size}, {0, 0, 2 * size}, {size, 0, 0}))
      .add(quad({0, 0, -size}, {0, size, 0}, {0, 0, 2 * size}))
      .build();
}

inline Scene open_floor(float size = 60.0f) {
  return SceneBuilder().add(quad({-size, 0, -size}, {0, 0, 2 * size}, {2 * size, 0, 0})).build();
}

}  // namespace occlab::test
