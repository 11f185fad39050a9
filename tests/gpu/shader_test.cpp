// Shader sources: their expansion, where errors are said to be, what compiles, and that the headers
// which C++ and GLSL share compute the same.
//
// This program has embedded sources of its own: the repository's files and some broken ones.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <deque>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "renderers/gl/embedded_shaders.h"
#include "renderers/scene/error.h"
#include "renderers/shared/equirect.h"
#include "renderers/shared/filter.h"
#include "renderers/shared/frame.h"
#include "renderers/shared/representation_bent_cone.h"
#include "renderers/shared/representation_sh4.h"
#include "renderers/shared/visibility.h"
#include "tests/gpu/gpu_frame.h"

namespace occlab {
namespace {

/// Kept where it is for the views into it.
struct Sources {
  std::deque<std::string> texts;
  std::vector<EmbeddedShader> shaders;

  void add(const std::string& path, const std::string& text) {
    const std::string& kept_path = texts.emplace_back(path);
    const std::string& kept_text = texts.emplace_back(text);
    shaders.push_back({kept_path, kept_text});
  }
};

Sources make_sources() {
  Sources sources;
  const std::filesystem::path root = OCCLAB_SOURCE_DIR;
  for (const char* folder : {"renderers/shared", "renderers/gl", "renderers/methods"}) {
    for (const auto& entry : std::filesystem::directory_iterator(root / folder)) {
      const std::string extension = entry.path().extension().string();
      const bool shader = extension == ".frag" || extension == ".vert" || extension == ".glsl" ||
                          (extension == ".h" && std::string(folder) == "renderers/shared");
      if (!shader) continue;
      std::ostringstream text;
      text << std::ifstream(entry.path()).rdbuf();
      sources.add(std::filesystem::relative(entry.path(), root).generic_string(), text.str());
    }
  }
  sources.add("test/a.glsl", "#pragma once\nfloat a() { return 1.0; }\n");
  sources.add("test/b.glsl",
              "#pragma once\n#include \"test/a.glsl\"\n\nfloat b() { return a(); }\n");
  sources.add("test/good.frag",
              "#include \"test/b.glsl\"\n  #  include \"test/a.glsl\"\n"
              "// #include \"test/absent.glsl\"\nout vec4 colour;\n"
              "void main() { colour = vec4(a() + b()); }\n");
  sources.add("test/broken.glsl",
              "float fine() { return 1.0; }\n\nfloat broken() { return nix; }\n");
  sources.add("test/includes_broken.frag",
              "#include \"test/a.glsl\"\n#include \"test/broken.glsl\"\nvoid main() {}\n");
  sources.add("test/broken_after.frag",
              "#include \"test/b.glsl\"\nout vec4 colour;\n\nvoid main() { colour = nix; }\n");
  sources.add("test/missing.glsl", "\n\n#include \"test/absent.glsl\"\n");
  sources.add("test/includes_missing.frag", "// first\n#include \"test/missing.glsl\"\n");
  sources.add("test/unlinked.frag",
              "in vec4 nobody_writes_this;\nout vec4 colour;\n"
              "void main() { colour = nobody_writes_this; }\n");
  // Each row evaluates a header at the direction of the row and the column.
  sources.add("test/shared_headers.frag", R"(
#include "renderers/shared/equirect.h"
#include "renderers/shared/filter.h"
#include "renderers/shared/frame.h"
#include "renderers/shared/representation_bent_cone.h"
#include "renderers/shared/representation_sh4.h"
#include "renderers/shared/visibility.h"
layout(binding = 0) uniform sampler2D directions;
layout(location = 0) out vec4 out_0;
layout(location = 1) out vec4 out_1;
layout(location = 2) out vec4 out_2;
layout(location = 3) out vec4 out_3;
layout(location = 4) out vec4 out_uv;
layout(location = 5) out vec4 out_frame;
layout(location = 6) out vec4 out_other;
layout(location = 7) out uvec4 out_packed;
void main() {
  vec3 d = texelFetch(directions, ivec2(gl_FragCoord.xy), 0).xyz;
  Sh4 y = sh_basis(d);
  out_0 = y.c0;
  out_1 = y.c1;
  out_2 = y.c2;
  out_3 = y.c3;
  vec2 uv = equirect_uv(d);
  vec3 back = equirect_direction(uv);
  out_uv = vec4(uv, back.xy);
  mat3 frame = tangent_frame(d);
  out_frame = vec4(frame[0], frame[1].x);
  out_other = vec4(bent_cone_angle(0.5 + 0.5 * abs(d.x), cone_angle_exact),
                   blocked_visibility(weight_smoothstep, abs(d.y), 1.0, 1.0, 0.25),
                   blocked_visibility(weight_lambda, abs(d.y), 1.0, 3.0, 0.25),
                   bilateral_weight(d, d, d.yzx, d.zxy, 5.0, 5, 0.5));
  out_packed = sh_pack_low(sh_zonal(vec4(1.0, 2.0, 3.0, 4.0), d));
}
)");
  return sources;
}

}  // namespace

std::span<const EmbeddedShader> embedded_shaders() {
  static const Sources sources = make_sources();
  return sources.shaders;
}

namespace test {
namespace {

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++found;
  }
  return found;
}

template <typename Error, typename Action>
std::string message_of(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return "";
}

TEST(ShaderSource, EachFileIsIncludedOnce) {
  const ShaderSource source = expand_shader("test/good.frag", "#define PREAMBLE 1\n");
  EXPECT_TRUE(source.text.starts_with("#version 450 core\n#define PREAMBLE 1\n#line 1 0\n"));
  EXPECT_EQ(source.files,
            (std::vector<std::string>{"test/good.frag", "test/b.glsl", "test/a.glsl"}));
  EXPECT_EQ(count(source.text, "float a()"), 1u);
  EXPECT_EQ(count(source.text, "float b()"), 1u);
  EXPECT_EQ(count(source.text, "#pragma once"), 0u);
  device();
  EXPECT_NO_THROW(Program(fullscreen_vertex_shader, "test/good.frag", ""));
}

TEST(ShaderSource, EveryLineKeepsItsNumber) {
  // Follows the #line directives as a compiler does.
  const ShaderSource source = expand_shader("renderers/methods/ssbn_lighting.frag", "");
  std::istringstream lines(source.text);
  std::size_t file = 0, number = 0, compared = 0;
  bool started = false;
  for (std::string line; std::getline(lines, line);) {
    if (std::sscanf(line.c_str(), "#line %zu %zu", &number, &file) == 2) {
      started = true;
      continue;
    }
    if (!started) continue;
    std::istringstream original{std::string(shader_file(source.files.at(file)))};
    std::string expected;
    for (std::size_t i = 0; i < number; ++i) std::getline(original, expected);
    if (!line.empty()) {
      EXPECT_EQ(line, expected) << source.files[file] << ":" << number;
      ++compared;
    }
    ++number;
  }
  EXPECT_GT(compared, 150u);
}

TEST(ShaderSource, AMissingIncludeIsNamedWithItsPlace) {
  const std::string message =
      message_of<InputError>([] { expand_shader("test/includes_missing.frag", ""); });
  EXPECT_NE(message.find("test/includes_missing.frag:2: test/missing.glsl:3: "), std::string::npos)
      << message;
  EXPECT_NE(message.find("'test/absent.glsl'"), std::string::npos) << message;
  message_of<InputError>([] { expand_shader("test/absent.frag", ""); });
}

TEST(ShaderSource, CompilerMessagesNameTheOriginalFileAndLine) {
  device();
  const auto compile = [](const char* path) {
    return message_of<DeviceError>([&] { Program(fullscreen_vertex_shader, path, "\n\n\n"); });
  };
  const std::string included = compile("test/includes_broken.frag");
  EXPECT_NE(included.find("test/broken.glsl:3"), std::string::npos) << included;
  EXPECT_NE(included.find("nix"), std::string::npos) << included;
  const std::string after = compile("test/broken_after.frag");
  EXPECT_NE(after.find("test/broken_after.frag:4"), std::string::npos) << after;
  const std::string unlinked = compile("test/unlinked.frag");
  EXPECT_NE(unlinked.find("nobody_writes_this"), std::string::npos) << unlinked;
}

TEST(ShaderSource, MessagesOfOtherDriversAreLocatedToo) {
  const std::vector<std::string> files = {"first.frag", "second.glsl"};
  EXPECT_EQ(locate_messages("1:14(5): error: x", files), "second.glsl:14: error: x");
  EXPECT_EQ(locate_messages("0(7) : error C1503: x", files), "first.frag:7 : error C1503: x");
  EXPECT_EQ(locate_messages("ERROR: 1:9: 'x' : undeclared", files),
            "ERROR: second.glsl:9: 'x' : undeclared");
  EXPECT_EQ(locate_messages("9:14(5): error: x", files), "9:14(5): error: x") << "no such file";
  EXPECT_EQ(locate_messages("0:1(2): a\n1:3(4): b\n", files),
            "first.frag:1: a\nsecond.glsl:3: b\n");
}

TEST(Shaders, EveryMethodCompilesForAllItsChoices) {
  const Light lamp{.name = "lamp", .intensity = glm::vec3(1.0f)};
  const View view = look_at({1, 4, 5}, {0, 0, 0}, 0.6f, 4, 4);
  const Environment white = constant_environment(glm::vec3(1.0f));
  const TestFrame lit(open_floor(), view, white, std::vector<Light>(3, lamp));
  const TestFrame unlit(open_floor(), view, white);
  for (const MethodInfo& info : methods()) {
    Values few;  // lights of methods that make some, which does not change their programs
    for (const char* name : {"environment_lights", "bounce_lights"}) {
      if (ParameterSet(info.parameters).has(name)) few.emplace_back(name, 2L);
    }
    EXPECT_NO_THROW(unlit.evaluate(info.name, few)) << info.name;
    EXPECT_NO_THROW(lit.evaluate(info.name, few)) << info.name;
    for (const Parameter& parameter : info.parameters) {
      for (const std::string& word : parameter.choices) {
        if (ParameterValue(word) == parameter.default_value) continue;
        Values values = few;
        values.emplace_back(parameter.name, word);
        EXPECT_NO_THROW(lit.evaluate(info.name, values))
            << info.name << " " << parameter.name << " " << word;
      }
    }
  }
  // The ends of what is accepted.
  for (const Values& ends : {Values{{"samples", 1L}, {"steps", 1L}, {"filter", "none"}},
                             Values{{"samples", 256L}, {"steps", 64L}, {"filter", "none"}}}) {
    EXPECT_NO_THROW(lit.evaluate("s3ho", ends));
  }
}

/// Programs that the driver still has, of the names it has given.
std::size_t living_programs() {
  std::size_t living = 0;
  for (GLuint id = 1; id < 4096; ++id) living += glIsProgram(id) ? 1 : 0;
  return living;
}

TEST(ProgramCache, HoldsNoMoreThanItSaysAndKeepsWhatIsUsed) {
  device();
  const std::size_t before = living_programs();
  {
    ProgramCache cache;
    const auto get = [&](std::size_t number) -> const Program& {
      return cache.get(fullscreen_vertex_shader, "test/good.frag",
                       fmt::format("#define NUMBER {}\n", number));
    };
    const Program* const used_always = &get(0);
    for (std::size_t i = 1; i < 2 * ProgramCache::most; ++i) {
      get(i);
      EXPECT_EQ(&get(0), used_always);
    }
    EXPECT_EQ(living_programs() - before, ProgramCache::most);
  }
  EXPECT_EQ(living_programs(), before);
}

TEST(Shaders, EveryMethodNamesItsShaders) {
  // They are part of a cell's identity: a pass that is not named could change unnoticed.
  std::vector<std::string> without;
  for (const MethodInfo& info : methods()) {
    for (const std::string& path : info.shaders) EXPECT_NO_THROW(shader_file(path)) << path;
    const auto names = [&](const std::string& path) {
      return std::ranges::find(info.shaders, path) != info.shaders.end();
    };
    if (info.shaders.empty()) without.push_back(info.name);
    const bool filters = ParameterSet(info.parameters).has("filter");
    EXPECT_EQ(names("renderers/methods/bilateral.frag"), filters) << info.name;
    for (const EmbeddedShader& shader : embedded_shaders()) {
      const std::string path(shader.path);
      for (const char* next : {".", "_"}) {
        const bool own = path.starts_with("renderers/methods/" + info.name + next);
        EXPECT_TRUE(!own || !path.ends_with(".frag") || names(path)) << info.name << " " << path;
      }
    }
  }
  EXPECT_EQ(without, (std::vector<std::string>{"rtdo", "rtgi_unoccluded", "rtgi_shaded"}));
}

TEST(Shaders, SharedHeadersComputeTheSameOnBothSides) {
  device();
  // 1024 directions over the sphere, the axes among them.
  Image directions(32, 32, 3);
  for (int i = 0; i < 1024; ++i) {
    const float z = 1.0f - 2.0f * (float(i) + 0.5f) / 1024.0f;
    const float r = std::sqrt(1.0f - z * z), phi = 2.3999632f * float(i);
    glm::vec3 d = glm::normalize(glm::vec3(r * std::cos(phi), r * std::sin(phi), z));
    if (i < 6) {
      d = glm::vec3(0.0f);
      d[i / 2] = i % 2 ? -1.0f : 1.0f;
    }
    for (int c = 0; c < 3; ++c) directions.at(i % 32, i / 32, c) = d[c];
  }
  constexpr std::array<GLenum, 8> formats = {GL_RGBA32F, GL_RGBA32F, GL_RGBA32F, GL_RGBA32F,
                                             GL_RGBA32F, GL_RGBA32F, GL_RGBA32F, GL_RGBA32UI};
  const Framebuffer target(32, 32, formats, false);
  const Program program(fullscreen_vertex_shader, "test/shared_headers.frag", "");
  const Texture input = Texture::from_image(directions);
  program.use();
  Program::bind_texture(0, input);
  target.bind();
  draw_fullscreen();
  check_gl("the test's pass");
  std::vector<Image> found;
  for (std::size_t i = 0; i < 7; ++i) found.push_back(target.colors()[i].download());
  const std::vector<std::uint32_t> packed = target.colors()[7].download_integers();

  const auto expect = [&](std::size_t output, int x, int y, glm::vec4 expected, float tolerance) {
    for (int c = 0; c < 4; ++c) {
      EXPECT_NEAR(found[output].at(x, y, c), expected[c], tolerance)
          << "output " << output << " at " << x << " " << y;
    }
  };
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) {
      const glm::vec3 d(pixel3(directions, x, y));
      const Sh4 basis = sh_basis(d);
      const glm::vec4 quarters[4] = {basis.c0, basis.c1, basis.c2, basis.c3};
      for (std::size_t i = 0; i < 4; ++i) expect(i, x, y, quarters[i], 1e-6f);
      const vec2 uv = equirect_uv(d);
      const vec3 back = equirect_direction(uv);
      // acos is ill-conditioned near the poles; llvmpipe's atan and acos are good to some 1e-4.
      expect(4, x, y, {uv.x, uv.y, back.x, back.y}, 1e-3f);
      const mat3 frame = tangent_frame(d);
      expect(5, x, y, {frame[0], frame[1].x}, 1e-6f);
      expect(6, x, y,
             {bent_cone_angle(0.5f + 0.5f * std::abs(d.x), cone_angle_exact),
              blocked_visibility(weight_smoothstep, std::abs(d.y), 1.0f, 1.0f, 0.25f),
              blocked_visibility(weight_lambda, std::abs(d.y), 1.0f, 3.0f, 0.25f),
              bilateral_weight(d, d, {d.y, d.z, d.x}, {d.z, d.x, d.y}, 5.0f, 5, 0.5f)},
             2e-4f);
      // Halves, each within a last bit of the value: the rounding is the device's.
      const Sh4 zonal = sh_zonal(vec4(1, 2, 3, 4), d);
      const std::size_t p = 4 * std::size_t(x + 32 * y);
      const Sh4 unpacked =
          sh_unpack(uvec4(packed[p], packed[p + 1], packed[p + 2], packed[p + 3]), uvec4(0u));
      for (int i = 0; i < 4; ++i) {
        EXPECT_NEAR(unpacked.c0[i], zonal.c0[i], std::abs(zonal.c0[i]) * 0x1p-11f + 1e-6f);
        EXPECT_NEAR(unpacked.c1[i], zonal.c1[i], std::abs(zonal.c1[i]) * 0x1p-11f + 1e-6f);
      }
    }
  }
}

}  // namespace
}  // namespace test
}  // namespace occlab
