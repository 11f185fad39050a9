#pragma once

// Fake methods, one experiment file that uses every key, and a fixture that loads it with changes.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "harness/config.h"
#include "renderers/scene/error.h"

namespace occlab {

inline MethodInfo fake_method(std::string name, std::vector<Parameter> parameters) {
  MethodInfo method;
  method.name = std::move(name);
  method.parameters = std::move(parameters);
  return method;
}

inline const std::vector<MethodInfo>& fake_methods() {
  static const std::vector<Parameter> screen = {
      integer_parameter("samples", 32, 1, 256, "", ""),
      integer_parameter("steps", 2, 1, 64, "", ""),
      integer_parameter("seed", 0, 0, 1000000, "", ""),
      real_parameter("d_max_world", 1.0, 1e-6, 1e6, "scene units", ""),
      choice_parameter("weight", {"binary", "lambda"}, ""),
      choice_parameter("gbuffer_bits", {"32", "16"}, "")};
  static const std::vector<MethodInfo> methods = [] {
    std::vector<Parameter> cone = screen;
    cone.push_back(choice_parameter("cone_angle", {"linear", "exact"}, ""));
    return std::vector<MethodInfo>{
        fake_method("ssao", screen), fake_method("ssbn", cone),
        fake_method("rtdo", {integer_parameter("rays_per_pixel", 1024, 1, 1 << 20, "", ""),
                             integer_parameter("seed", 0, 0, 1000000, "", ""),
                             real_parameter("d_max_world", 1.0, 1e-6, 1e6, "scene units", "")}),
        fake_method("fixed", {integer_parameter("samples", 32, 1, 256, "", "")})};
  }();
  return methods;
}

// Line numbers matter below: line 1 is `format`.
inline const std::string base = R"(format = 1
[experiment]
name = "test"
title = "A test"
[scene]
source = "gallery"
view = "main"
resolution = [640, 360]
[probe]
source = "sky_sun"
prefilter_degrees = 3
[parameters]
d_max_world = 0.5
[reference]
method = "rtdo"
rays_per_pixel = 64
[[run]]
methods = ["ssao", "ssbn"]
steps = [4, 2]
samples = [16, 8]
seeds = 3
[timing]
methods = ["ssao", "ssbn"]
samples = [16, 8]
baseline = "ssao"
repetitions = 5
budget_seconds = 2
published = "s3ho_table1"
[[figure]]
name = "fig7"
kind = "comparison"
methods = ["rtdo", "ssao"]
samples = 16
steps = 2
[[figure]]
name = "fig8"
kind = "closeups"
stage = "unfiltered"
methods = ["rtdo", "ssbn"]
rows = [{label = "a", rectangle = [600, 300, 40, 60], samples = 8, steps = 4},
        {label = "b", rectangle = [0.5, 0.5, 0.25, 0.5], samples = 16, steps = 4}]
[[figure]]
name = "errors"
kind = "error_map"
methods = ["ssao"]
samples = 16
steps = 2
scale = 0.5
)";

inline std::string changed(const std::string& from, const std::string& to) {
  std::string text = base;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

class ConfigTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        std::filesystem::temp_directory_path() / fmt::format("occlab_config_test_{}", getpid());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Experiment load(const std::string& text, const std::vector<std::string>& overrides = {}) {
    std::ofstream(file()) << text;
    return load_experiment(file(), overrides, fake_methods());
  }
  std::string error_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
    try {
      load(text, overrides);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }
  std::filesystem::path file() const { return folder_ / "test.toml"; }
  /// "FILE:12: key 'scene.view': ".
  std::string at(int line, const std::string& key) const {
    return fmt::format("{}:{}: key '{}': ", file().string(), line, key);
  }

  std::filesystem::path folder_;
};

#define EXPECT_ERROR(text, expected) EXPECT_PRED_FORMAT2(starts_with, error_of(text), expected)
#define EXPECT_OVERRIDE_ERROR(override_text, expected) \
  EXPECT_PRED_FORMAT2(starts_with, error_of(base, {override_text}), expected)

inline testing::AssertionResult starts_with(const char*, const char*, const std::string& found,
                                            const std::string& expected) {
  if (found.starts_with(expected)) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "found:    " << found << "\nexpected: " << expected;
}

}  // namespace occlab
