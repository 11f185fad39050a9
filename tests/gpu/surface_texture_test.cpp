// Textures and alpha masks: by hand, and the G-buffer's pass, the ray tracer and cut geometry
// against each other.

#include "renderers/scene/surface_texture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderers/shared/surface_texture.h"
#include "tests/gpu/gpu_frame.h"

namespace occlab::test {
namespace {

/// Every texel another value, red to alpha.
Image numbered_texture(int width, int height) {
  Image texture(width, height, 4);
  for (std::size_t i = 0; i < texture.values().size(); ++i) {
    texture.values()[i] = float((i * 7919) % 101) / 101.0f;
  }
  return texture;
}

TEST(SurfaceTexture, MixesAndWrapsAsWorkedOutByHand) {
  Image row(4, 1, 1);
  for (int x = 0; x < 4; ++x) row.at(x, 0) = float(x);
  const auto at = [&](float u, int wrap, bool nearest = false) {
    const glm::vec4 value = texture_at(row, {wrap, wrap_repeat, nearest}, {u, 0.3f});
    EXPECT_EQ(value.y, 0.0f);
    EXPECT_EQ(value.w, 1.0f);
    return value.x;
  };
  // Texel centres are at 1/8, 3/8, 5/8 and 7/8.
  EXPECT_EQ(at(0.375f, wrap_repeat), 1.0f);
  EXPECT_EQ(at(0.4375f, wrap_repeat), 1.25f);
  EXPECT_EQ(at(0.0f, wrap_repeat), 1.5f);  // half the last, half the first
  EXPECT_EQ(at(1.0f - 0.0625f, wrap_repeat), 2.25f);
  EXPECT_EQ(at(-0.625f, wrap_repeat), 1.0f);
  EXPECT_EQ(at(1e30f, wrap_repeat), 1.5f);
  EXPECT_EQ(at(0.0f, wrap_clamp_to_edge), 0.0f);
  EXPECT_EQ(at(-5.0f, wrap_clamp_to_edge), 0.0f);
  EXPECT_EQ(at(7.0f, wrap_clamp_to_edge), 3.0f);
  EXPECT_EQ(at(0.0f, wrap_mirrored_repeat), 0.0f);
  EXPECT_EQ(at(1.0f, wrap_mirrored_repeat), 3.0f);
  EXPECT_EQ(at(1.375f, wrap_mirrored_repeat), 2.0f);
  EXPECT_EQ(at(-0.375f, wrap_mirrored_repeat), 1.0f);
  EXPECT_EQ(at(2.4375f, wrap_mirrored_repeat), 1.25f);
  EXPECT_EQ(at(0.49f, wrap_repeat, true), 1.0f);
  EXPECT_EQ(at(0.51f, wrap_repeat, true), 2.0f);
  EXPECT_EQ(at(-0.01f, wrap_repeat, true), 3.0f);
  EXPECT_EQ(at(-0.01f, wrap_mirrored_repeat, true), 0.0f);
  EXPECT_EQ(at(1.0f, wrap_clamp_to_edge, true), 3.0f);
}

/// A quad in front of the camera, turned out of its plane, its texture 5 times as large as its uvs.
Scene textured_scene(const TextureSampling& sampling) {
  Mesh mesh = quad({-1, -1, -5}, {2, 0, -1.5f}, {0, 2, 0.5f});
  for (glm::vec2& uv : mesh.uvs) uv = 5.0f * uv - glm::vec2(2.3f, 1.7f);
  Scene scene = SceneBuilder().add(mesh).build();
  scene.textures.push_back(numbered_texture(6, 5));
  scene.materials[0].albedo = {0.5f, 0.25f, 1.0f};
  scene.materials[0].albedo_texture = 0;
  scene.materials[0].sampling = sampling;
  return scene;
}

View straight_ahead(int size) {
  View view;
  view.camera.yfov = 2.0f * std::atan(1.0f / 5.0f);
  view.width = view.height = size;
  return view;
}

/// The hit of the ray through a view-space point; the camera is the identity.
std::optional<SurfaceHit> hit_through(const TracedScene& traced, glm::vec3 point) {
  RTCRayHit ray{};
  ray.ray.dir_x = point.x;
  ray.ray.dir_y = point.y;
  ray.ray.dir_z = point.z;
  ray.ray.tfar = 100.0f;
  ray.ray.mask = ~0u;
  ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(traced.handle(), &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return TracedScene::surface_hit(ray.hit.instID[0], ray.hit.geomID, ray.hit.primID, ray.hit.u,
                                  ray.hit.v);
}

TEST(SurfaceTexture, ThePassAndTheTracerHaveOneAlbedo) {
  for (const TextureSampling& sampling :
       {TextureSampling{wrap_repeat, wrap_clamp_to_edge, false},
        TextureSampling{wrap_mirrored_repeat, wrap_repeat, false},
        TextureSampling{wrap_clamp_to_edge, wrap_mirrored_repeat, false},
        TextureSampling{wrap_mirrored_repeat, wrap_mirrored_repeat, true}}) {
    const Scene scene = textured_scene(sampling);
    const TestFrame frame(scene, straight_ahead(48), constant_environment(glm::vec3(1)));
    const TracedScene traced(scene);
    int compared = 0, different = 0;
    double largest = 0.0, smallest = 1.0;
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 48; ++x) {
        if (frame.surface().mask.at(x, y) == 0.0f) continue;
        const glm::vec3 point(pixel3(frame.surface().position_view, x, y));
        const auto hit = hit_through(traced, point);
        if (!hit) continue;  // the outline's
        const glm::dvec3 seen = pixel3(frame.surface().albedo, x, y);
        // Rounding of uv, about 1e-6, times the steepest slope, 6 texels.
        different += glm::length(seen - glm::dvec3(albedo_at(scene, *hit))) > 2e-5;
        largest = std::max(largest, seen.y);
        smallest = std::min(smallest, seen.y);
        ++compared;
      }
    }
    EXPECT_GT(compared, 1000);
    // A nearest texel may be the neighbour within rounding of an edge.
    EXPECT_LE(different, sampling.nearest ? 2 : 0);
    EXPECT_GT(largest, 0.15);
    EXPECT_LT(smallest, 0.1);
  }
}

TEST(SurfaceTexture, AlbedoAtAHitIsOfItsInstanceAndTriangle) {
  // Two instances of one mesh and a mesh of its own, each another albedo.
  Scene scene = SceneBuilder()
                    .add(quad({-3, -0.5f, -5}, {1, 0, 0}, {0, 1, 0}))
                    .material({1, 0, 0})
                    .add(quad({-1, -0.5f, -5}, {1, 0, 0}, {0, 1, 0}))
                    .material({0, 1, 0})
                    .instance(0, glm::translate(glm::mat4(1.0f), glm::vec3(4, 0, 0)))
                    .build();
  const TracedScene traced(scene);
  const auto albedo = [&](float x) { return albedo_at(scene, *hit_through(traced, {x, 0, -5})); };
  EXPECT_EQ(albedo(-2.5f), glm::vec3(1, 0, 0));
  EXPECT_EQ(albedo(-0.5f), glm::vec3(0, 1, 0));
  EXPECT_EQ(albedo(1.5f), glm::vec3(1, 0, 0));
  EXPECT_EQ(hit_through(traced, {1.5f, 0, -5})->instance, 2);
  EXPECT_FALSE(hit_through(traced, {5, 0, -5}).has_value());
}

/// A floor, a wall behind it, and a screen that stands on the floor. Its lower part, up to `cut` of
/// 2, is missing: as a hole in an alpha mask, or as geometry that is not there.
Scene screen_scene(bool masked, bool twice) {
  constexpr float cut = 0.75f;
  const float bottom = masked ? 0.0f : cut;
  Mesh screen = quad({-1, bottom, 0}, {2, 0, 0}, {0, 2 - bottom, 0});
  SceneBuilder builder;
  builder.add(quad({-3, 0, -2}, {0, 0, 5}, {6, 0, 0})).add(quad({-3, 0, -2}, {6, 0, 0}, {0, 3, 0}));
  builder.add(screen).material({0.2f, 0.8f, 0.4f});
  if (twice) {
    builder.instance(2, glm::translate(glm::mat4(1.0f), glm::vec3(0.3f, 0, 0.9f)));
  }
  Scene scene = builder.build();
  if (!masked) return scene;
  // v = 0 is the quad's lower edge: 3 of the 8 rows of the texture are a hole.
  Image texture(1, 8, 4, 1.0f);
  for (int y = 0; y < 3; ++y) texture.at(0, y, 3) = 0.4f;
  scene.textures.push_back(texture);
  Material& material = scene.materials[1];
  material.albedo_texture = 0;
  material.sampling.nearest = true;
  material.alpha_cutoff = 0.5f;
  return scene;
}

/// The share of pixels that differ by more than rounding, and the largest mean difference.
void expect_alike(const Image& a, const Image& b, const std::string& what) {
  ASSERT_TRUE(a.same_size(b));
  double difference = 0.0;
  std::size_t different = 0;
  for (std::size_t i = 0; i < a.values().size(); ++i) {
    const double d = double(a.values()[i]) - double(b.values()[i]);
    different += std::abs(d) > 1e-3 ? 1 : 0;
    difference += d;
  }
  EXPECT_LE(different, a.values().size() / 50) << what;
  EXPECT_LE(std::abs(difference) / double(a.values().size()), 1e-3) << what;
}

TEST(AlphaMask, AHoleIsAsNoSurfaceToPassAndTracer) {
  const View view = look_at({1.5f, 1.6f, 4.0f}, {0, 0.6f, 0}, 0.9f, 96, 64);
  const Environment sky = probe_of(64, [](glm::vec3 d) {
    return glm::vec3(1.0f + d.x, 1.0f + 0.5f * d.z, std::max(d.y, 0.0f));
  });
  Light lamp;
  lamp.type = LightType::directional;
  lamp.direction_world = glm::normalize(glm::vec3(0.2f, -0.5f, -1.0f));
  lamp.intensity = glm::vec3(2.0f);
  for (const bool twice : {false, true}) {  // a mesh of its own, and instances
    const TestFrame masked(screen_scene(true, twice), view, sky, {lamp});
    const TestFrame cut(screen_scene(false, twice), view, sky, {lamp});
    Scene opaque = screen_scene(true, twice);
    opaque.materials[1].alpha_cutoff = std::nullopt;
    const TestFrame whole(opaque, view, sky, {lamp});
    expect_alike(masked.surface().mask, cut.surface().mask, "mask");
    expect_alike(masked.surface().position_view, cut.surface().position_view, "position");
    expect_alike(masked.surface().albedo, cut.surface().albedo, "albedo");
    for (const char* method : {"ssao", "s3ho", "ssdo", "rtdo"}) {
      Values values = {{"d_max_world", 2.0}};
      if (method == std::string("rtdo")) values.push_back({"rays_per_pixel", 256});
      const Image a = masked.layer(method, "radiance", values);
      const Image b = cut.layer(method, "radiance", values);
      const Image c = whole.layer(method, "radiance", values);
      expect_alike(a, b, method);
      double change = 0.0;
      for (std::size_t i = 0; i < a.values().size(); ++i) {
        change += std::abs(double(a.values()[i]) - double(c.values()[i]));
      }
      EXPECT_GT(change / double(a.values().size()), 0.02) << method << " does not see the hole";
    }
  }
}

TEST(AlphaMask, WithoutTextureTheFactorDecides) {
  for (const float alpha : {0.49f, 0.5f}) {
    Scene scene = SceneBuilder().add(quad({-1, -1, -5}, {2, 0, 0}, {0, 2, 0})).build();
    scene.materials[0].alpha = alpha;
    scene.materials[0].alpha_cutoff = 0.5f;
    const TestFrame frame(scene, straight_ahead(8), constant_environment(glm::vec3(1)));
    EXPECT_EQ(frame.surface().mask.at(3, 3), alpha >= 0.5f ? 1.0f : 0.0f);
    EXPECT_EQ(hit_through(TracedScene(scene), {0.1f, 0, -5}).has_value(), alpha >= 0.5f);
  }
}

}  // namespace
}  // namespace occlab::test
