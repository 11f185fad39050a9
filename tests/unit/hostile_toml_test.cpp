// TOML that is small and would take the stack or the memory.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "harness/toml_limits.h"
#include "harness/toml_reader.h"
#include "renderers/scene/error.h"
#include "tests/unit/tiny_scenes.h"

namespace occlab {
namespace {

std::string times(std::size_t count, std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < count; ++i) result += text;
  return result;
}

class HostileToml : public testing::Test {
 protected:
  void expect_refused(const std::string& text, const std::string& part) {
    test::write_bytes(folder_ / "a.toml", text);
    test::expect_error<InputError>([&] { parse_toml(folder_ / "a.toml", {}); }, {"a.toml", part});
  }
  TemporaryFolder folder_;
};

TEST_F(HostileToml, DeepNestingIsRefusedHoweverItIsHidden) {
  const std::string part = "nested TOML; accepted: up to 64 (limit nesting";
  expect_refused("a = " + times(100000, "["), part);
  expect_refused("a = " + times(100000, "{a="), part);
  const std::string key = "a" + times(100000, ".a");
  expect_refused(key + " = 1", part);
  expect_refused("[" + key + "]", part);
  expect_refused("a = [1, {" + key + " = 1}]", part);
  expect_refused("a" + times(100000, ".\"a.\"") + " = 1", part);
  // Behind what looks like a comment, in or after strings of several lines.
  expect_refused("a = [\"\"\"\n#\"\"\", {" + key + " = 1}]", part);
  expect_refused("a = [\"\"\"\n#\"\"\"\"\", {" + key + " = 1}]", part);
  expect_refused("a = ['''\n\\''', {" + key + " = 1}]", part);
  expect_refused("a = [\"\\\"#\", {" + key + " = 1}]", part);
}

TEST_F(HostileToml, DotsElsewhereAreNoLevels) {
  const std::string text = "a = \"" + times(1000, "...") + "\" # " + times(1000, ".[{") +
                           "\nb = [" + times(1000, "0.5, ") + "]\nc = '''\n" + times(1000, ".[\n") +
                           "'''\nd = 1.5\n";
  test::write_bytes(folder_ / "a.toml", text);
  EXPECT_EQ(parse_toml(folder_ / "a.toml", {}).size(), 4u);
}

TEST_F(HostileToml, HugeFilesAreRefused) {
  expect_refused("a = 1\n" + std::string(17u << 20, ' '), "limit config_bytes");
}

TEST_F(HostileToml, OverridesThatAreNoTextFailAsOverrides) {
  test::write_bytes(folder_ / "a.toml", "a = 1");
  for (const std::string& value : {std::string("\xff\xfe"), std::string("a\0b", 3)}) {
    test::expect_error<InputError>([&] { parse_toml(folder_ / "a.toml", {"a=" + value}); },
                                   {"--set a="});
  }
  test::expect_error<InputError>(
      [&] { parse_toml(folder_ / "a.toml", {"a=" + times(1000, "[") + times(1000, "]")}); },
      {"--set a=", "limit nesting"});
}

}  // namespace
}  // namespace occlab
