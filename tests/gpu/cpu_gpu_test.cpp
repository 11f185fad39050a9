// Every method by its shaders and on the CPU: the same layers within the bounds of rounding, at
// every pixel, whatever the scene, the light and the parameters.

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "harness/verify/layer_agreement.h"
#include "renderers/methods/cpu_passes.h"
#include "renderers/scene/error.h"
#include "tests/gpu/gpu_frame.h"
#include "tests/unit/tiny_scenes.h"

namespace occlab::test {
namespace {

/// With and without a bounce.
std::vector<std::string> all_methods() {
  std::vector<std::string> all = screen_space_methods;
  all.insert(all.end(), bounce_methods.begin(), bounce_methods.end());
  return all;
}

ParameterSet parameters_of(const std::string& method, const Values& values) {
  ParameterSet parameters(find_method(method).parameters);
  for (const auto& [name, value] : values) {
    if (parameters.has(name)) parameters.set(name, value);
  }
  return parameters;
}

LayerAgreement agreement_of(const TestFrame& frame, const std::string& method,
                            const Values& values) {
  return gpu_and_cpu(frame.frame(), find_method(method), parameters_of(method, values));
}

void expect_agreement(const TestFrame& frame, const Values& values, const std::string& what,
                      const std::vector<std::string>& methods = all_methods()) {
  for (const std::string& method : methods) {
    const LayerAgreement agreement = agreement_of(frame, method, values);
    const WorstPixel worst = worst_pixel(agreement);
    EXPECT_LE(worst.share, 1.0) << what << ", " << method << ", "
                                << parameters_of(method, values).to_string() << ": "
                                << describe(worst);
    const Image& radiance = agreement.expected.at("radiance");
    EXPECT_GT(std::ranges::max(radiance.values()), 0.0f) << what << ", " << method;
  }
}

/// A floor, a wall, a ball and a board: concave, convex and thin.
Scene still_life() {
  return SceneBuilder()
      .add(quad({-4, 0, -4}, {0, 0, 8}, {8, 0, 0}))
      .material({0.8f, 0.5f, 0.3f})
      .add(quad({-1, 0, -4}, {0, 3, 0}, {0, 0, 8}))
      .material({0.2f, 0.7f, 0.4f})
      .add(sphere_part({0.4, 0.5, 0.2}, 0.5, 0, pi_d, 24))
      .add(quad({0.2f, 0.9f, 0.9f}, {0.8f, 0.2f, 0}, {0, 0.1f, 0.5f}))
      .build();
}

const View from_above = look_at({4, 3, 3}, {0.2f, 0.5f, 0.2f}, 0.5f, 50, 38);
/// Level, with the floor's normal (0, 1, 0) in view space, where n.z = 0 and the probe has its
/// pole, and a wall's (1, 0, 0).
const View level = look_at({0.6f, 0.8f, 4}, {0.6f, 0.8f, 0}, 0.9f, 50, 38);
/// So near that rays of length d_max leave the screen on all sides, and pass behind the camera.
const View near_by = look_at({0.9f, 0.7f, 1.1f}, {0.4f, 0.4f, 0.2f}, 0.8f, 50, 38);

Environment sky() {
  return probe_of(64, [](glm::vec3 d) {
    return glm::vec3(1.0f + d.x, 1.2f + d.y * d.z, std::max(0.0f, d.x + d.y - d.z));
  });
}

/// A sun of two texels, 30000 times as bright as the sky.
Environment sharp_sun() {
  return probe_of(256, [](glm::vec3 d) {
    const bool sun = glm::dot(d, glm::normalize(glm::vec3(0.5f, 0.7f, 0.3f))) > 0.9997f;
    return sun ? glm::vec3(30000, 27000, 20000) : glm::vec3(0.3f, 0.5f, 1.0f);
  });
}

std::vector<Light> lights() {
  return {{.name = "sun",
           .type = LightType::directional,
           .direction_world = glm::normalize(glm::vec3(-1, -2, -0.5f)),
           .intensity = {3, 2, 1}},
          {.name = "lamp", .position_world = {0.9f, 1.3f, 0.3f}, .intensity = {0.5f, 1, 2}},
          {.name = "spot",
           .type = LightType::spot,
           .position_world = {2, 2.5f, 1},
           .direction_world = glm::normalize(glm::vec3(-2, -2.5f, -0.7f)),
           .intensity = {9, 9, 9},
           .inner_cone_angle = 0.2f,
           .outer_cone_angle = 0.4f}};
}

TEST(CpuAndGpu, AgreeForEveryWeight) {
  const TestFrame frame(still_life(), from_above, sky(), lights());
  for (const char* weight : {"binary", "lambda", "smoothstep"}) {
    expect_agreement(frame, {{"weight", weight}}, "still life");
  }
}

TEST(CpuAndGpu, AgreeForAnyNumberOfSamplesAndSteps) {
  const TestFrame frame(still_life(), from_above, sky(), lights());
  for (const auto& [samples, steps] : {std::pair(1L, 1L), std::pair(7L, 5L), std::pair(33L, 9L)}) {
    expect_agreement(frame, {{"samples", samples}, {"steps", steps}, {"seed", samples}},
                     "still life");
  }
}

TEST(CpuAndGpu, AgreeUnderASharpSun) {
  const TestFrame frame(still_life(), from_above, sharp_sun());
  expect_agreement(frame, {}, "sharp sun");
  expect_agreement(frame, {{"filter", "none"}}, "sharp sun");
}

TEST(CpuAndGpu, AgreeUnderAConstantProbe) {
  const TestFrame frame(still_life(), from_above, constant_environment({0.7f, 1, 2.3f}));
  expect_agreement(frame, {{"cone_angle", "exact"}}, "constant probe");
}

TEST(CpuAndGpu, AgreeOnPunctualLightsAlone) {
  const TestFrame frame(still_life(), from_above, constant_environment(glm::vec3(0.0f)), lights());
  for (const double width : {0.0, 2.5}) {
    expect_agreement(frame, {{"hanning_width", width}, {"weight", "smoothstep"}}, "lights");
  }
  expect_agreement(frame, {{"cone_angle", "exact"}}, "lights");
}

TEST(CpuAndGpu, AgreeWhereTheNormalIsAtThePoleAndInThePlaneOfTheImage) {
  const TestFrame frame(still_life(), level, sharp_sun(), lights());
  int at_pole = 0, at_side = 0;
  for (int y = 0; y < frame.height(); ++y) {
    for (int x = 0; x < frame.width(); ++x) {
      const glm::dvec3 n = pixel3(frame.surface().normal_view, x, y);
      at_pole += n == glm::dvec3(0, 1, 0) ? 1 : 0;
      at_side += n == glm::dvec3(1, 0, 0) ? 1 : 0;
    }
  }
  EXPECT_GT(at_pole, 100);
  EXPECT_GT(at_side, 100);
  for (const char* filter : {"bilateral", "none"}) {
    expect_agreement(frame, {{"filter", filter}}, "level camera");
  }
}

TEST(CpuAndGpu, AgreeWhereRaysLeaveTheScreen) {
  const TestFrame frame(still_life(), near_by, sky(), lights());
  const Image off_screen = frame.layer("ssao", "off_screen", {{"d_max_world", 5.0}});
  double share = 0.0;
  for (const float value : off_screen.values()) share += double(value);
  EXPECT_GT(share / double(off_screen.values().size()), 0.3);
  expect_agreement(frame, {{"d_max_world", 5.0}, {"steps", 8L}}, "near by");
}

TEST(CpuAndGpu, AgreeOverA16BitGBuffer) {
  const TestFrame frame(still_life(), from_above, sky(), lights());
  expect_agreement(frame, {{"gbuffer_bits", "16"}, {"weight", "lambda"}}, "16 bits");
}

TEST(CpuAndGpu, AgreeOnWhatRaysSaw) {
  // The occlusion pass is the CPU's on both sides; its values are uploaded, filtered and lit.
  const TestFrame frame(still_life(), from_above, sky(), lights());
  expect_agreement(frame, {{"visibility", "traced"}, {"weight", "lambda"}}, "traced",
                   {"ssao", "s3ho", "ssdo", "ssbn", "s3hogi"});
}

/// Few samples, as every loop over them is compiled anew.
Values few_samples(Values values) {
  for (const char* name : {"samples", "steps"}) values.emplace_back(name, 4L);
  return values;
}

TEST(CpuAndGpu, AgreeBehindSeveralLayers) {
  const TestFrame frame(still_life(), from_above, sky(), lights());
  expect_agreement(
      frame, few_samples({{"visibility", "peeled"}, {"layers", 3L}, {"weight", "smoothstep"}}),
      "layers");
  expect_agreement(frame, few_samples({{"visibility", "peeled"}, {"gbuffer_bits", "16"}}),
                   "layers of 16 bits", {"ssao", "ssdogi"});
}

TEST(CpuAndGpu, AgreeOnWhatSeveralCamerasSee) {
  const TestFrame frame(still_life(), from_above, sky(), lights());
  const Values cameras = {{"visibility", "multiview"}, {"cameras", 3L}, {"camera_offset", 0.6}};
  Values values = cameras;
  values.emplace_back("weight", "lambda");
  expect_agreement(frame, few_samples(values), "cameras");
  values = cameras;
  values.emplace_back("gbuffer_bits", "16");
  values.emplace_back("camera_scale", 1.3);
  expect_agreement(frame, few_samples(values), "cameras of 16 bits", {"ssao", "ssdogi"});
}

TEST(CpuAndGpu, AgreeOnEveryFormFactor) {
  const TestFrame frame(still_life(), from_above, sky(), lights());
  for (const char* factor : {"solid_angle", "patch"}) {
    for (const char* clamp : {"unit", "patch_radius", "none"}) {
      if (factor == std::string("solid_angle") && clamp != std::string("unit")) continue;
      expect_agreement(frame,
                       {{"form_factor", factor},
                        {"distance_clamp", clamp},
                        {"sender_area", 1.7},
                        {"weight", "smoothstep"}},
                       "form factors", bounce_methods);
    }
  }
}

TEST(CpuAndGpu, AgreeOnABackground) {
  // Half of the image shows no surface, where all layers are 0 on both sides.
  const TestFrame frame(SceneBuilder().add(sphere_part({0, 0, 0}, 1, 0, pi_d, 24)).build(),
                        look_at({0, 0, 6}, {0, 0, 0}, 0.6f, 50, 38), sky(), lights());
  expect_agreement(frame, {}, "ball");
}

/// What a bound must refuse.
class PlantedError : public testing::Test {
 protected:
  static const TestFrame& frame() {
    static const TestFrame of(still_life(), from_above, sky(), lights());
    return of;
  }
};

TEST_F(PlantedError, OfThreeBoundsIsFoundAndNamed) {
  for (const std::string& method : all_methods()) {
    const LayerAgreement good = agreement_of(frame(), method, {});
    for (const Layers::Layer& layer : good.expected.all()) {
      LayerAgreement bad = good;
      bad.expected = {};
      for (const Layers::Layer& other : good.expected.all()) {
        Image image = other.image;
        if (other.name == layer.name) {
          const int c = image.channels() - 1;
          image.at(17, 21, c) += 3.0f * good.bounds.at(layer.name).at(17, 21, c);
        }
        bad.expected.add(other.name, std::move(image));
      }
      const WorstPixel worst = worst_pixel(bad);
      EXPECT_GT(worst.share, 1.9) << method << " " << layer.name;
      EXPECT_LT(worst.share, 4.1) << method << " " << layer.name;
      EXPECT_EQ(worst.layer, layer.name) << method;
      EXPECT_EQ(worst.x, 17);
      EXPECT_EQ(worst.y, 21);
      EXPECT_EQ(worst.channel, layer.image.channels() - 1);
      const std::string text = describe(worst);
      EXPECT_NE(text.find(layer.name), std::string::npos) << text;
      EXPECT_NE(text.find("at (17, 21)"), std::string::npos) << text;
    }
  }
}

TEST_F(PlantedError, ThatIsNotANumberIsFound) {
  LayerAgreement agreement = agreement_of(frame(), "ssao", {});
  Image radiance = agreement.measured.at("radiance");
  radiance.at(3, 4, 1) = std::numeric_limits<float>::quiet_NaN();
  Layers measured;
  for (const Layers::Layer& layer : agreement.measured.all()) {
    measured.add(layer.name, layer.name == "radiance" ? radiance : layer.image);
  }
  agreement.measured = measured;
  const WorstPixel worst = worst_pixel(agreement);
  EXPECT_EQ(worst.share, std::numeric_limits<double>::infinity());
  EXPECT_EQ(worst.x, 3);
  EXPECT_EQ(worst.y, 4);
}

TEST_F(PlantedError, OnTheBackgroundIsFound) {
  // The bound is 0 there.
  LayerAgreement agreement;
  agreement.measured.add("k", Image(2, 1, 1, 1e-30f));
  agreement.expected.add("k", Image(2, 1, 1));
  agreement.bounds.add("k", Image(2, 1, 1));
  EXPECT_EQ(worst_pixel(agreement).share, std::numeric_limits<double>::infinity());
}

TEST_F(PlantedError, OfAMissingLayerOrAnotherSizeIsAnError) {
  LayerAgreement agreement;
  agreement.expected.add("k", Image(2, 1, 1));
  agreement.bounds.add("k", Image(2, 1, 1));
  expect_error<InputError>([&] { worst_pixel(agreement); }, {"k"});
  agreement.measured.add("k", Image(1, 2, 1));
  expect_error<InputError>([&] { worst_pixel(agreement); }, {"'k'", "1x2", "2x1"});
}

TEST_F(PlantedError, InAParameterIsFound) {
  // One part in a thousand of a constant, or the next sample set.
  for (const std::string& method : all_methods()) {
    for (const auto& [name, value] : Values{{"d_max_world", 1.001},
                                            {"seed", 1L},
                                            {"filter_power", 32.5},
                                            {"filter_scale", 1.01},
                                            {"bias_world", 2e-2}}) {
      LayerAgreement agreement = agreement_of(frame(), method, {});
      agreement.expected = evaluate_on_cpu(frame().frame(), parameters_of(method, {{name, value}}),
                                           *find_method(method).representation);
      EXPECT_GT(worst_pixel(agreement).share, 1.0) << method << " " << name;
    }
  }
}

TEST_F(PlantedError, HasLittleRoom) {
  // The bounds are not there for anything but rounding: below 2.5e-3 of the image's largest value
  // for what is stored as halves twice, and 1e-4 for floats.
  for (const std::string& method : all_methods()) {
    const LayerAgreement agreement = agreement_of(frame(), method, {});
    for (const Layers::Layer& layer : agreement.bounds.all()) {
      if (layer.name.starts_with("radiance")) continue;
      float largest = 0.0f, widest = 0.0f;
      for (std::size_t i = 0; i < layer.image.values().size(); ++i) {
        largest = std::max(largest, std::abs(agreement.expected.at(layer.name).values()[i]));
        widest = std::max(widest, layer.image.values()[i]);
      }
      EXPECT_LT(widest, (method.starts_with("s3ho") ? 2.5e-3f : 1e-4f) * largest)
          << method << layer.name;
      EXPECT_GT(widest, 0.0f);
    }
  }
}

}  // namespace
}  // namespace occlab::test
