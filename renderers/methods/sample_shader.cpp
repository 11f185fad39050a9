#include "renderers/methods/sample_shader.h"

#include <fmt/format.h>

#include <array>
#include <vector>

#include "renderers/methods/representation_layers.h"
#include "renderers/methods/sample_set.h"
#include "renderers/shared/representation_sh4.h"

namespace occlab {
namespace {

// Compilers unroll loops of up to some 32 rounds; more marches take long to compile (2 s at 256 on
// Mesa's software rasteriser) and gain less.
constexpr int most_constant_samples = 32;
constexpr int most_constant_marches = 128;

/// Digits that give the float back; GLSL takes an integer's as an integer.
std::string literal(float value) { return fmt::format("{:.9g}", value); }

/// A sum in writing.
class Expression {
 public:
  void add(float weight, const std::string& term) {
    text_ +=
        fmt::format("{} {} * {}", weight < 0.0f ? " -" : " +", literal(std::abs(weight)), term);
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_ = "0.0";
};

using Projection = std::array<Expression, 16>;

int degree_of(std::size_t coefficient) { return coefficient >= 9 ? 3 : coefficient >= 4 ? 2 : 1; }
/// |m| of coefficient i = l(l+1) + m.
int order_of(std::size_t coefficient) {
  if (coefficient == 0) return 0;
  const int l = degree_of(coefficient);
  return std::abs(int(coefficient) - l * (l + 1));
}

/// Appends the ring's bits and what they are combined to, and adds its terms.
class RingTerms {
 public:
  RingTerms(const SampleSet& set, const SampleRing& ring, std::string& glsl, Projection& projection)
      : ring_(ring), glsl_(glsl), projection_(projection) {
    const auto count = float(set.directions.size());
    for (int k = 0; k < ring.count; ++k) {
      const int j = ring.first + k;
      const glm::vec3 s(set.directions[std::size_t(j)]);
      const Sh4 products = sh_scale(sh_basis(s), s.z * 2.0f * pi / count);
      weights_.push_back(values_of(products));
      glsl_ += fmt::format("  float v{} = float((visible[{}] >> {}u) & 1u);\n", j, j / 32, j % 32);
    }
  }

  void add() {
    if (ring_.count == 4) {
      add_four();
    } else if (ring_.count == 2) {
      add_two();
    } else {
      for (int k = 0; k < ring_.count; ++k) {
        for (std::size_t i = 0; i < projection_.size(); ++i) add(i, k, bit(k));
      }
    }
  }

 private:
  /// Half a turn changes the sign of odd orders.
  void add_two() {
    const std::string sum = combine("sum", bit(0) + " + " + bit(1));
    const std::string difference = combine("difference", bit(0) + " - " + bit(1));
    for (std::size_t i = 0; i < projection_.size(); ++i) {
      add(i, 0, order_of(i) % 2 == 0 ? sum : difference);
    }
  }

  /// A quarter turn changes the sign of order 2, and exchanges cosines and sines of odd orders.
  void add_four() {
    const std::string even = combine("even", bit(0) + " + " + bit(2));
    const std::string odd = combine("odd", bit(1) + " + " + bit(3));
    const std::string sum = combine("sum", even + " + " + odd);
    const std::string alternating = combine("alternating", even + " - " + odd);
    const std::string first = combine("first", bit(0) + " - " + bit(2));
    const std::string second = combine("second", bit(1) + " - " + bit(3));
    for (std::size_t i = 0; i < projection_.size(); ++i) {
      switch (order_of(i)) {
        case 0:
          add(i, 0, sum);
          break;
        case 2:
          add(i, 0, alternating);
          break;
        default:
          add(i, 0, first);
          add(i, 1, second);
      }
    }
  }

  std::string bit(int k) const { return fmt::format("v{}", ring_.first + k); }
  std::string combine(const char* name, const std::string& expression) {
    std::string variable = fmt::format("{}{}", name, ring_.first);
    glsl_ += fmt::format("  float {} = {};\n", variable, expression);
    return variable;
  }
  void add(std::size_t coefficient, int k, const std::string& term) {
    projection_[coefficient].add(weights_[std::size_t(k)][coefficient], term);
  }

  const SampleRing& ring_;
  std::string& glsl_;
  Projection& projection_;
  std::vector<Representation::Values> weights_;
};

}  // namespace

bool samples_in_buffer(int samples, int steps) {
  return samples > most_constant_samples || samples * steps > most_constant_marches;
}

std::string sample_constants(int samples, int steps) {
  if (samples_in_buffer(samples, steps)) return "#define SAMPLES_IN_BUFFER\n";
  std::string glsl = fmt::format("const vec4 sample_direction[{}] = vec4[](\n", samples);
  const char* separator = "";
  for (const glm::vec4& s : make_sample_set(samples, 0).directions) {
    glsl += fmt::format("{}  vec4({}, {}, {}, {})", separator, literal(s.x), literal(s.y),
                        literal(s.z), literal(s.w));
    separator = ",\n";
  }
  return glsl + ");\n";
}

std::string sh_projection(int samples) {
  const SampleSet set = make_sample_set(samples, 0);
  std::string glsl = fmt::format(
      "void project_visibility(uint visible[{}], out vec4 c0, out vec4 c1, out vec4 c2, "
      "out vec4 c3) {{\n",
      (samples + 31) / 32);
  Projection projection;
  for (const SampleRing& ring : sample_rings(samples)) {
    RingTerms(set, ring, glsl, projection).add();
  }
  for (std::size_t i = 0; i < projection.size(); ++i) {
    glsl += fmt::format("  c{}.{} = {};\n", i / 4, "xyzw"[i % 4], projection[i].text());
  }
  return glsl + "}\n";
}

}  // namespace occlab
