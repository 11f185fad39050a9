#include "renderers/scene/limits.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>

#include "tests/unit/tiny_scenes.h"

namespace occlab {
namespace {

TEST(Limits, AreSetByName) {
  set_limits("instances=7,triangles=9");
  EXPECT_EQ(limit(Limit::instances), 7u);
  EXPECT_EQ(limit(Limit::triangles), 9u);
  EXPECT_NO_THROW(require_within(Limit::instances, 7, "instances", "a.glb"));
  test::expect_error<InputError>(
      [] { require_within(Limit::instances, 8, "instances", "a.glb: nodes[3]"); },
      {"a.glb: nodes[3]: 8 instances; accepted: up to 7 (limit instances, see OCCLAB_LIMITS)"});
  set_limits("");
  for (const LimitInfo& info : limits()) EXPECT_EQ(limit(info.limit), info.default_value);
}

TEST(Limits, RefuseWhatIsNoLimit) {
  test::expect_error<InputError>([] { set_limits("instnces=7"); },
                                 {"'instnces'", "did you mean 'instances'"});
  for (const char* text : {"instances", "instances=", "instances=-1", "instances=1e6", "=3",
                           "instances=99999999999999999999999", "instances=1 ", ",,"}) {
    test::expect_error<InputError>([&] { set_limits(text); }, {"limits: "});
  }
}

TEST(Limits, AreDocumentedAsDeclared) {
  const std::string text =
      test::read_bytes(std::filesystem::path(OCCLAB_SOURCE_DIR) / "docs" / "robustness.md");
  for (const LimitInfo& info : limits()) {
    const std::string row =
        fmt::format("| `{}` | {} | {} |\n", info.name, info.default_value, info.what);
    EXPECT_NE(text.find(row), std::string::npos) << row;
  }
}

TEST(Limits, ArithmeticDoesNotWrapAround) {
  constexpr std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
  EXPECT_EQ(saturating_add(most, 1), most);
  EXPECT_EQ(saturating_add(2, 3), 5u);
  EXPECT_EQ(saturating_multiply(1ull << 40, 1ull << 40), most);
  EXPECT_EQ(saturating_multiply(3, 5), 15u);
  EXPECT_EQ(saturating_multiply(0, most), 0u);
}

}  // namespace
}  // namespace occlab
