// parse_toml: the file, and what --set changes in it.

#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <variant>

#include "harness/files.h"
#include "harness/toml_limits.h"
#include "harness/toml_reader.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr std::string_view name_characters =
    "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";

/// A step of a dotted key: a table's key, or an index of a list.
using Step = std::variant<std::string, std::size_t>;

/// "run[0].seeds" -> "run", 0, "seeds"; nothing if it is not of that form.
std::optional<std::vector<Step>> parse_key(std::string_view key) {
  std::vector<Step> steps;
  for (;;) {
    const std::size_t length = std::min(key.find_first_not_of(name_characters), key.size());
    if (length == 0) return std::nullopt;
    steps.emplace_back(std::string(key.substr(0, length)));
    key.remove_prefix(length);
    while (key.starts_with('[')) {
      std::size_t index = 0;
      const auto [rest, error] = std::from_chars(key.data() + 1, key.data() + key.size(), index);
      if (error != std::errc() || rest == key.data() + key.size() || *rest != ']') {
        return std::nullopt;
      }
      steps.emplace_back(index);
      key.remove_prefix(std::size_t(rest - key.data()) + 1);
    }
    if (key.empty()) return steps;
    if (!key.starts_with('.')) return std::nullopt;
    key.remove_prefix(1);
  }
}

/// A table `value = ...` whose node carries the override as its source.
toml::table parse_value(std::string_view value, const std::string& origin) {
  const std::string text = fmt::format("value = {}", value);
  check_toml_text(text, origin);
  return toml::parse(text, origin);
}

class Override {
 public:
  explicit Override(const std::string& text) : origin_("--set " + text) {
    const std::size_t equals = text.find('=');
    const auto steps = equals == std::string::npos
                           ? std::nullopt
                           : parse_key(std::string_view(text).substr(0, equals));
    if (!steps) {
      fail(
          "accepted is KEY=VALUE with a dotted key, such as scene.resolution=[640,360] or "
          "run[0].seeds=2");
    }
    steps_ = *steps;
    value_ = value(text.substr(equals + 1));
  }

  void apply(toml::table& root) {
    toml::node* current = &root;
    std::string walked;
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      const bool last = i + 1 == steps_.size();
      if (const auto* name = std::get_if<std::string>(&steps_[i])) {
        toml::table* const table = current->as_table();
        if (!table) fail(fmt::format("'{}' is not a table", walked));
        if (last) {
          table->insert_or_assign(*name, std::move(*value_.get("value")));
          return;
        }
        // As in TOML itself, a dotted key makes the tables on its way.
        if (!table->contains(*name)) {
          table->insert_or_assign(*name, std::move(*parse_value("{}", origin_).get("value")));
        }
        current = table->get(*name);
        walked += (walked.empty() ? "" : ".") + *name;
      } else {
        const std::size_t index = std::get<std::size_t>(steps_[i]);
        toml::array* const array = current->as_array();
        if (!array) fail(fmt::format("'{}' is not a list", walked));
        if (index >= array->size()) {
          fail(fmt::format("'{}' has {} entries, counted from 0", walked, array->size()));
        }
        if (last) {
          array->replace(array->cbegin() + std::ptrdiff_t(index), std::move(*value_.get("value")));
          return;
        }
        current = array->get(index);
        walked += fmt::format("[{}]", index);
      }
    }
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    throw InputError(fmt::format("{}: {}", origin_, message));
  }

  /// The value as TOML; a word or path that is not TOML is a text, so that the shell needs no
  /// second pair of quotes.
  toml::table value(const std::string& text) const {
    std::string reason;
    try {
      toml::table parsed = parse_value(text, origin_);
      if (parsed.size() == 1) return parsed;
      reason = "it is more than one value";
    } catch (const toml::parse_error& error) {
      reason = error.description();
    }
    if (text.empty() || text.find_first_of("\"'[]{}=,#\\\n\r") != std::string::npos) {
      fail(fmt::format("the value is not TOML: {}", reason));
    }
    try {
      return parse_value(fmt::format("'{}'", text), origin_);
    } catch (const toml::parse_error& error) {
      fail(fmt::format("the value is no text: {}", error.description()));
    }
  }

  std::string origin_;
  std::vector<Step> steps_;
  toml::table value_;
};

}  // namespace

toml::table parse_toml(const std::filesystem::path& path,
                       const std::vector<std::string>& overrides) {
  toml::table root;
  try {
    const std::string text = read_text(path);
    check_toml_text(text, path.string());
    root = toml::parse(text, path.string());
  } catch (const toml::parse_error& error) {
    throw InputError(fmt::format("{}:{}: not TOML: {}", path.string(), error.source().begin.line,
                                 error.description()));
  }
  for (const std::string& text : overrides) Override(text).apply(root);
  return root;
}

}  // namespace occlab
