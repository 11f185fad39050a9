#include "renderers/methods/parameters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderers/methods/method.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

const std::vector<Parameter>& declared() {
  static const std::vector<Parameter> list = {
      integer_parameter("samples", 32, 1, 256, "", "directions"),
      real_parameter("d_max_world", 1.0, 1e-6, 1e6, "scene units", "reach"),
      choice_parameter("weight", {"binary", "lambda"}, "what a blocker lets through"),
      integer_parameter("rays", 1024, 1, 1 << 24, "", "rays"),
      seed_parameter("draws"),
  };
  return list;
}

/// The action must fail with a message that holds all of `parts`.
template <typename Action>
void expect_refused(const Action& action, const std::vector<std::string>& parts) {
  try {
    action();
    ADD_FAILURE() << "accepted";
  } catch (const InputError& error) {
    for (const std::string& part : parts) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos)
          << "'" << part << "' is missing in: " << error.what();
    }
  }
}

TEST(Parameters, StartAtTheirDefaults) {
  const ParameterSet set(declared());
  EXPECT_EQ(set.integer("samples"), 32);
  EXPECT_EQ(set.real("d_max_world"), 1.0);
  EXPECT_EQ(set.choice("weight"), "binary") << "the first word of a choice";
  EXPECT_EQ(set.integer("seed"), 0);
  EXPECT_TRUE(set.has("samples"));
  EXPECT_FALSE(set.has("sample"));
  EXPECT_EQ(set.declared().size(), 5u);
}

TEST(Parameters, RangesIncludeTheirEnds) {
  ParameterSet set(declared());
  for (const long samples : {1L, 256L}) {
    set.set("samples", samples);
    EXPECT_EQ(set.integer("samples"), samples);
  }
  for (const double reach : {1e-6, 1e6}) {
    set.set("d_max_world", reach);
    EXPECT_EQ(set.real("d_max_world"), reach);
  }
  for (const long samples : {0L, 257L, -1L, std::numeric_limits<long>::max()}) {
    expect_refused([&] { set.set("samples", samples); },
                   {"samples = " + std::to_string(samples), "an integer in [1, 256]"});
  }
  for (const double reach : {0.0, 9e-7, 2e6, -1.0, std::numeric_limits<double>::infinity(),
                             std::numeric_limits<double>::quiet_NaN()}) {
    expect_refused([&] { set.set("d_max_world", reach); },
                   {"d_max_world = ", "a number in [1e-06, 1e+06] (scene units)"});
  }
  EXPECT_EQ(set.integer("samples"), 256) << "a refused value changes nothing";
  EXPECT_EQ(set.real("d_max_world"), 1e6);
}

TEST(Parameters, BoundsAreSaidToTheLastDigit) {
  ParameterSet set(declared());
  expect_refused([&] { set.set("rays", 16777217L); }, {"[1, 16777216]"});
  set.set("rays", 16777216L);
}

TEST(Parameters, KindsAreNotMixed) {
  ParameterSet set(declared());
  set.set("d_max_world", 3L);
  EXPECT_EQ(set.real("d_max_world"), 3.0) << "an integer is a number";
  expect_refused([&] { set.set("samples", 8.0); }, {"samples = 8", "an integer"});
  expect_refused([&] { set.set("samples", std::string("8")); }, {"samples = 8", "an integer"});
  expect_refused([&] { set.set("d_max_world", std::string("1")); }, {"d_max_world", "a number"});
  expect_refused([&] { set.set("weight", 1L); }, {"weight = 1", "one of binary, lambda"});
  expect_refused([&] { set.set("weight", std::string("Binary")); }, {"weight = Binary"});
  set.set("weight", std::string("lambda"));
  EXPECT_EQ(set.choice("weight"), "lambda");
}

TEST(Parameters, UnknownNamesGetASuggestion) {
  ParameterSet set(declared());
  expect_refused([&] { set.set("sampels", 8L); }, {"unknown parameter 'sampels'", "'samples'"});
  expect_refused([&] { set.set_text("d_max", "1"); },
                 {"'d_max'", "samples, d_max_world, weight, rays, seed"});
}

TEST(Parameters, TextIsParsedWhole) {
  ParameterSet set(declared());
  set.set_text("samples", "8");
  set.set_text("d_max_world", "0.25");
  set.set_text("weight", "lambda");
  EXPECT_EQ(set.integer("samples"), 8);
  EXPECT_EQ(set.real("d_max_world"), 0.25);
  EXPECT_EQ(set.choice("weight"), "lambda");
  set.set_text("d_max_world", "2e2");
  EXPECT_EQ(set.real("d_max_world"), 200.0);
  for (const char* text : {"", " 8", "8 ", "8x", "8.0", "0x8", "--8", "99999999999999999999"}) {
    expect_refused([&] { set.set_text("samples", text); },
                   {std::string("samples = ") + text + ":", "an integer in [1, 256]"});
  }
  for (const char* text : {"", "1,5", "1.5 m", "nan", "inf", "1e999", "one"}) {
    expect_refused([&] { set.set_text("d_max_world", text); }, {"d_max_world = ", "a number in"});
  }
  expect_refused([&] { set.set_text("weight", "lambda "); }, {"one of binary, lambda"});
}

TEST(Parameters, InfinityIsTextWhereItIsInRange) {
  ParameterSet set(find_method("rtdo").parameters);
  set.set_text("d_max_world", "inf");
  EXPECT_TRUE(std::isinf(set.real("d_max_world")));
}

TEST(Parameters, IdentityNamesEveryValueInDeclaredOrder) {
  ParameterSet set(declared());
  EXPECT_EQ(set.to_string(), "samples=32 d_max_world=1 weight=binary rays=1024 seed=0");
  set.set("d_max_world", 0.1);
  set.set("seed", 7L);
  EXPECT_EQ(set.to_string(), "samples=32 d_max_world=0.1 weight=binary rays=1024 seed=7");
  // Numbers that differ in the last bit are different cells.
  ParameterSet next = set;
  next.set("d_max_world", std::nextafter(0.1, 1.0));
  EXPECT_NE(next.to_string(), set.to_string());
}

TEST(Parameters, ShadersGetConstantsAndUniformsButNoSeed) {
  ParameterSet set(declared());
  set.set("weight", std::string("lambda"));
  set.set("seed", 5L);
  EXPECT_EQ(set.glsl_preamble(),
            "#define PARAMETER_samples 32\n"
            "uniform float d_max_world;\n"
            "#define WEIGHT_BINARY 0\n"
            "#define WEIGHT_LAMBDA 1\n"
            "#define PARAMETER_weight WEIGHT_LAMBDA\n"
            "#define PARAMETER_rays 1024\n");
}

TEST(Methods, AreListedOnceWithValidDeclarations) {
  std::vector<std::string> names;
  for (const MethodInfo& info : methods()) {
    names.push_back(info.name);
    EXPECT_EQ(&find_method(info.name), &info);
    EXPECT_FALSE(info.title.empty());
    EXPECT_FALSE(info.paper.empty());
    EXPECT_NE(info.make(), nullptr);
    ParameterSet set(info.parameters);
    for (const Parameter& parameter : info.parameters) {
      EXPECT_FALSE(parameter.help.empty()) << parameter.name;
      // A default is accepted, and no name is declared twice.
      set.set(parameter.name, parameter.default_value);
      EXPECT_EQ(std::ranges::count(info.parameters, parameter.name, &Parameter::name), 1);
    }
  }
  EXPECT_EQ(names, (std::vector<std::string>{"rtdo", "ssao", "s3ho", "ssdo", "ssbn", "s3hogi",
                                             "ssdogi", "shadow_maps", "instant_radiosity",
                                             "rtgi_unoccluded", "rtgi_shaded"}));
  expect_refused([] { find_method("s3h0"); }, {"unknown method 's3h0'", "'s3ho'", "rtdo, ssao"});
}

}  // namespace
}  // namespace occlab
