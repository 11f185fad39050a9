// Objects of OpenGL are given back: 500 cells leave as many as the first few did, the wrappers
// count what the driver has, and nothing is left when the context ends.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <optional>

#include "renderers/methods/frame.h"
#include "renderers/methods/method.h"
#include "tests/gpu/gpu_frame.h"

namespace occlab {
namespace {

using test::Values;

/// Numbers of objects are small; this many are asked about.
constexpr GLuint most_names = 4096;

struct Counts {
  long textures = 0, framebuffers = 0, buffers = 0, vertex_arrays = 0, programs = 0, shaders = 0,
       queries = 0;
  bool operator==(const Counts&) const = default;
  long sum() const {
    return textures + framebuffers + buffers + vertex_arrays + programs + shaders + queries;
  }
};

std::ostream& operator<<(std::ostream& stream, const Counts& c) {
  return stream << fmt::format(
             "{} textures, {} framebuffers, {} buffers, {} vertex arrays, {} programs, {} shaders, "
             "{} queries",
             c.textures, c.framebuffers, c.buffers, c.vertex_arrays, c.programs, c.shaders,
             c.queries);
}

/// What the driver itself says, whoever made it.
Counts objects_of_driver() {
  Counts counts;
  for (GLuint name = 1; name <= most_names; ++name) {
    counts.textures += glIsTexture(name) != 0;
    counts.framebuffers += glIsFramebuffer(name) != 0;
    counts.buffers += glIsBuffer(name) != 0;
    counts.vertex_arrays += glIsVertexArray(name) != 0;
    counts.programs += glIsProgram(name) != 0;
    counts.shaders += glIsShader(name) != 0;
    counts.queries += glIsQuery(name) != 0;
  }
  return counts;
}

/// What the wrappers say; shaders and queries do not outlive their functions.
Counts objects_of_wrappers() {
  return {GlObject<delete_texture>::live(),
          GlObject<delete_framebuffer>::live(),
          GlObject<delete_buffer>::live(),
          GlObject<delete_vertex_array>::live(),
          GlObject<delete_program>::live(),
          0,
          0};
}

Values settings(int cell) {
  const std::array<const char*, 2> visibility = {"depth", "traced"};
  const std::array<const char*, 2> bits = {"32", "16"};
  const std::array<const char*, 2> filter = {"bilateral", "none"};
  return {{"samples", 4L},
          {"steps", 1L},
          {"seed", long(cell)},
          {"visibility", std::string(visibility[std::size_t(cell / 4 % 2)])},
          {"gbuffer_bits", std::string(bits[std::size_t(cell / 8 % 2)])},
          {"filter", std::string(filter[std::size_t(cell / 16 % 2)])}};
}

/// A frame of its own, as each bench of a run makes one.
void render_cells(ProgramCache& programs, int first, int last) {
  const Scene scene = test::floor_and_tall_wall();
  const View view = test::look_at({3, 2, 0}, {0, 1, 0}, 1.0f, 16, 16);
  const GpuScene gpu_scene(scene);
  const Frame frame{.scene = scene,
                    .gpu_scene = gpu_scene,
                    .view = view,
                    .lighting = Lighting(constant_environment(glm::vec3(1.0f)), {}, view),
                    .programs = programs};
  for (int cell = first; cell < last; ++cell) {
    const std::string& name = test::screen_space_methods[std::size_t(cell % 4)];
    const MethodInfo& info = find_method(name);
    ParameterSet parameters(info.parameters);
    for (const auto& [parameter, value] : settings(cell)) parameters.set(parameter, value);
    Metadata facts;
    info.make()->evaluate(frame, parameters, facts);
  }
}

TEST(GlObjects, FiveHundredCellsLeaveNothing) {
  std::optional<Context> context(std::in_place, "surfaceless");
  ASSERT_EQ(live_gl_objects, 0);
  ASSERT_EQ(objects_of_driver(), Counts());
  {
    ProgramCache programs;
    constexpr int different_settings = 32;
    render_cells(programs, 0, different_settings);
    const Counts first = objects_of_driver();
    EXPECT_EQ(first, objects_of_wrappers());
    EXPECT_GT(first.programs, 4);
    EXPECT_EQ(first.sum(), first.programs);  // nothing but the cache's
    for (int cell = different_settings; cell < 500; cell += 39) {
      render_cells(programs, cell, cell + 39);
      ASSERT_EQ(objects_of_driver(), first) << "after cell " << cell + 39;
    }
    EXPECT_EQ(objects_of_wrappers(), first);
  }
  glUseProgram(0);  // one that is in use is deleted when it no longer is
  EXPECT_EQ(objects_of_driver(), Counts());
  context.reset();
  EXPECT_EQ(live_gl_objects, 0);
}

TEST(GlObjects, ShadowMapsAreGivenBack) {
  std::optional<Context> context(std::in_place, "surfaceless");
  ASSERT_EQ(objects_of_driver(), Counts());
  {
    ProgramCache programs;
    const Scene scene = test::floor_and_tall_wall();
    const View view = test::look_at({3, 2, 0}, {0, 1, 0}, 1.0f, 16, 16);
    const GpuScene gpu_scene(scene);
    const Light lamp{.name = "lamp", .position_world = {1, 2, 0}, .intensity = glm::vec3(1.0f)};
    const Light sun{.name = "sun", .type = LightType::directional, .intensity = glm::vec3(1.0f)};
    const Frame frame{
        .scene = scene,
        .gpu_scene = gpu_scene,
        .view = view,
        .lighting = Lighting(constant_environment(glm::vec3(1.0f)), {lamp, sun}, view),
        .programs = programs};
    const auto render = [&](long cell) {
      for (const char* name : {"shadow_maps", "instant_radiosity"}) {
        const MethodInfo& info = find_method(name);
        ParameterSet parameters(info.parameters);
        parameters.set("environment_lights", 2L);
        parameters.set("shadow_map_side", 16L + 16L * (cell % 2));
        if (parameters.has("bounce_lights")) parameters.set("bounce_lights", 3L);
        if (parameters.has("near_bounce")) parameters.set("near_bounce", std::string("screen"));
        Metadata facts;
        info.make()->evaluate(frame, parameters, facts);
      }
    };
    render(0);
    const Counts first = objects_of_driver();
    EXPECT_EQ(first, objects_of_wrappers());
    for (long cell = 1; cell < 6; ++cell) render(cell);
    EXPECT_EQ(objects_of_driver(), first);
  }
  glUseProgram(0);
  EXPECT_EQ(objects_of_driver(), Counts());
  context.reset();
  EXPECT_EQ(live_gl_objects, 0);
}

TEST(GlObjects, TheDriverIsAskedRightly) {
  const Context context("surfaceless");
  const Counts before = objects_of_driver();
  GLuint leaked = 0;
  glCreateBuffers(1, &leaked);
  EXPECT_EQ(objects_of_driver().buffers, before.buffers + 1);
  glDeleteBuffers(1, &leaked);
  EXPECT_EQ(objects_of_driver(), before);
  {
    const Texture texture(4, 4, GL_RGBA32F);
    EXPECT_EQ(objects_of_driver().textures, before.textures + 1);
    EXPECT_EQ(live_gl_objects, 1);
  }
  EXPECT_EQ(live_gl_objects, 0);
}

}  // namespace
}  // namespace occlab
