#include "harness/toml_reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>
#include <tuple>

#include "renderers/scene/confined_path.h"
#include "renderers/scene/data_root.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view override_prefix = "--set ";

bool is_override(const toml::node& node) {
  return node.source().path && node.source().path->starts_with(override_prefix);
}

/// "'fast' (a text)", "a table": what was found, for messages.
std::string describe(const toml::node& node) {
  if (node.is_table()) return "a table";
  if (node.is_array_of_tables()) return "a list of tables";
  std::ostringstream text;
  node.visit([&](const auto& value) { text << toml::node_view<const toml::node>(&value); });
  switch (node.type()) {
    case toml::node_type::array:
      return text.str();
    case toml::node_type::string:
      return text.str() + " (a text)";
    case toml::node_type::integer:
      return text.str() + " (an integer)";
    case toml::node_type::floating_point:
      return text.str() + " (a real)";
    case toml::node_type::boolean:
      return text.str() + " (a truth value)";
    default:
      return text.str() + " (a date or time)";
  }
}

}  // namespace

TomlTable::TomlTable(const toml::table& table, std::string key, std::string file)
    : table_(&table), key_(std::move(key)), file_(std::move(file)) {}

const toml::node* TomlTable::find(const std::string& name) {
  if (std::ranges::find(known_, name) == known_.end()) known_.push_back(name);
  return table_->get(name);
}

const toml::node& TomlTable::require(const std::string& name, std::string_view what) {
  const toml::node* const node = find(name);
  if (!node) fail(name, fmt::format("missing; {} is required", what));
  return *node;
}

std::string TomlTable::full_key(const std::string& name) const {
  return key_.empty() ? name : key_ + "." + name;
}

std::string TomlTable::where(const toml::node& node) const {
  if (is_override(node)) return *node.source().path;
  const auto line = node.source().begin.line;
  return line == 0 ? file_ : fmt::format("{}:{}", file_, line);
}

void TomlTable::fail(const std::string& name, const std::string& message) const {
  const toml::node* const node = table_->get(name);
  // A missing key of the root is nobody's line.
  const std::string place = node ? where(*node) : key_.empty() ? file_ : where(*table_);
  throw InputError(fmt::format("{}: key '{}': {}", place, full_key(name), message));
}

void TomlTable::wrong_type(const std::string& name, const toml::node& found,
                           std::string_view accepted) const {
  fail(name, fmt::format("found {}; accepted is {}", describe(found), accepted));
}

bool TomlTable::has(const std::string& name) { return find(name) != nullptr; }

std::string TomlTable::text(const std::string& name) {
  const toml::node& node = require(name, "a text");
  const auto* const value = node.as_string();
  if (!value || value->get().empty()) wrong_type(name, node, "a text that is not empty");
  return value->get();
}

std::string TomlTable::text(const std::string& name, const std::string& fallback) {
  return has(name) ? text(name) : fallback;
}

std::string TomlTable::identifier(const std::string& name) {
  const std::string value = text(name);
  if (value.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_-") != std::string::npos) {
    fail(name, fmt::format("found '{}'; accepted are the characters a-z, 0-9, _ and -", value));
  }
  return value;
}

std::string TomlTable::one_of(const std::string& name, const std::vector<std::string>& accepted,
                              const std::string& fallback) {
  const std::string value = fallback.empty() ? text(name) : text(name, fallback);
  if (std::ranges::find(accepted, value) == accepted.end()) {
    fail(name, fmt::format("unknown '{}'{}", value, accepted_words(value, accepted)));
  }
  return value;
}

long TomlTable::integer(const std::string& name, long minimum, long maximum,
                        std::optional<long> fallback) {
  if (fallback && !has(name)) return *fallback;
  const std::string accepted = fmt::format("an integer in [{}, {}]", minimum, maximum);
  const toml::node& node = require(name, accepted);
  const auto* const value = node.as_integer();
  if (!value || value->get() < minimum || value->get() > maximum) wrong_type(name, node, accepted);
  return value->get();
}

double TomlTable::real(const std::string& name, double minimum, double maximum,
                       std::optional<double> fallback) {
  if (fallback && !has(name)) return *fallback;
  const std::string accepted = fmt::format("a number in [{:g}, {:g}]", minimum, maximum);
  const toml::node& node = require(name, accepted);
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  if (!value || !(*value >= minimum && *value <= maximum)) wrong_type(name, node, accepted);
  return *value;
}

std::vector<std::string> TomlTable::words(const std::string& name) {
  constexpr std::string_view accepted = "a list of texts, not empty";
  const toml::node& node = require(name, accepted);
  const toml::array* const list = node.as_array();
  if (!list || list->empty() || !list->is_homogeneous<std::string>()) {
    wrong_type(name, node, accepted);
  }
  std::vector<std::string> result;
  for (const toml::node& entry : *list) {
    const std::string word = entry.as_string()->get();
    if (std::ranges::find(result, word) != result.end()) {
      fail(name, fmt::format("'{}' is listed twice", word));
    }
    result.push_back(word);
  }
  return result;
}

TomlTable::Numbers TomlTable::numbers(const std::string& name, std::size_t count) {
  const std::string accepted = fmt::format("a list of {} numbers", count);
  const toml::node& node = require(name, accepted);
  const toml::array* const list = node.as_array();
  const auto is_number = [](const toml::node& entry) { return entry.is_number(); };
  if (!list || list->size() != count || !std::ranges::all_of(*list, is_number)) {
    wrong_type(name, node, accepted);
  }
  Numbers result;
  for (const toml::node& entry : *list) result.values.push_back(*entry.value<double>());
  result.whole = list->is_homogeneous<std::int64_t>();
  return result;
}

ParameterValue TomlTable::parameter_value(const std::string& name, const toml::node& node) const {
  if (const auto* value = node.as_integer()) return long(value->get());
  if (const auto* value = node.as_floating_point()) return value->get();
  if (const auto* value = node.as_string()) return value->get();
  wrong_type(name, node, "a number or a text");
}

std::vector<ParameterValue> TomlTable::values(const std::string& name, bool list, bool repeats) {
  const toml::node& node = require(name, "a value");
  if (list && node.is_table()) return range(name);
  const toml::array* const array = node.as_array();
  if (!array) return {parameter_value(name, node)};
  if (!list) wrong_type(name, node, "one value; lists are for [[run]] and [timing]");
  if (array->empty()) wrong_type(name, node, "a list that is not empty");
  std::vector<ParameterValue> result;
  for (const toml::node& entry : *array) {
    ParameterValue value = parameter_value(name, entry);
    if (!repeats && std::ranges::find(result, value) != result.end()) {
      fail(name, fmt::format("{} is listed twice", to_string(value)));
    }
    result.push_back(std::move(value));
  }
  return result;
}

std::string TomlTable::name_or_path(const toml::node& node) const {
  const std::string value = node.as_string()->get();
  if (!is_path(value)) return value;
  // What the command line says is the user's own word; a file may come from anywhere.
  if (is_override(node)) return (fs::current_path() / value).lexically_normal().string();
  return confined_path(fs::absolute(file_).parent_path(), value, where(node)).string();
}

std::string TomlTable::name_or_path(const std::string& name) {
  text(name);
  return name_or_path(*find(name));
}

bool TomlTable::is_list(const std::string& name) {
  const toml::node* const node = find(name);
  return node && (node->is_array() || node->is_table());
}

std::vector<std::string> TomlTable::names_or_paths(const std::string& name, bool repeats) {
  if (!is_list(name)) return {name_or_path(name)};
  const toml::node& node = *find(name);
  const toml::array* const list = node.as_array();
  const auto is_text = [](const toml::node& entry) {
    return entry.is_string() && !entry.as_string()->get().empty();
  };
  if (!list || list->empty() || !std::ranges::all_of(*list, is_text)) {
    wrong_type(name, node, "a text or a list of texts, none of them empty");
  }
  std::vector<std::string> result;
  for (const toml::node& entry : *list) {
    std::string word = name_or_path(entry);
    if (!repeats && std::ranges::find(result, word) != result.end()) {
      fail(name, fmt::format("'{}' is listed twice", word));
    }
    result.push_back(std::move(word));
  }
  return result;
}

std::vector<std::vector<std::string>> TomlTable::word_lists(const std::string& name) {
  std::vector<std::vector<std::string>> result;
  if (!has(name)) return result;
  const toml::node& node = *find(name);
  const toml::array* const lists = node.as_array();
  const auto is_pair = [](const toml::node& entry) {
    const toml::array* const words = entry.as_array();
    return words && words->size() >= 2 && words->is_homogeneous<std::string>();
  };
  if (!lists || lists->empty() || !std::ranges::all_of(*lists, is_pair)) {
    wrong_type(name, node, "a list of lists of at least two texts");
  }
  std::set<std::string> seen;
  for (const toml::node& words : *lists) {
    result.emplace_back();
    for (const toml::node& word : *words.as_array()) {
      result.back().push_back(word.as_string()->get());
      if (!seen.insert(result.back().back()).second) {
        fail(name, fmt::format("'{}' is there twice", result.back().back()));
      }
    }
  }
  return result;
}

TomlTable TomlTable::table(const std::string& name) {
  const toml::node& node = require(name, fmt::format("a table [{}]", full_key(name)));
  if (!node.is_table()) wrong_type(name, node, fmt::format("a table [{}]", full_key(name)));
  return {*node.as_table(), full_key(name), file_};
}

std::vector<TomlTable> TomlTable::tables(const std::string& name) {
  const std::string accepted = fmt::format("a list of tables [[{}]], not empty", full_key(name));
  const toml::node& node = require(name, accepted);
  const toml::array* const list = node.as_array();
  const auto is_table = [](const toml::node& entry) { return entry.is_table(); };
  if (!list || list->empty() || !std::ranges::all_of(*list, is_table)) {
    wrong_type(name, node, accepted);
  }
  std::vector<TomlTable> result;
  for (std::size_t i = 0; i < list->size(); ++i) {
    result.emplace_back(*list->get_as<toml::table>(i), fmt::format("{}[{}]", full_key(name), i),
                        file_);
  }
  return result;
}

std::vector<std::string> TomlTable::others() const {
  // toml++ sorts the keys; their places tell the order of the file. Overrides' new keys have none
  // and come last.
  std::vector<std::tuple<bool, toml::source_index, toml::source_index, std::string>> places;
  for (const auto& [key, node] : *table_) {
    const std::string name(key.str());
    if (std::ranges::find(known_, name) != known_.end()) continue;
    const toml::source_position begin = key.source().begin;
    places.emplace_back(begin.line == 0, begin.line, begin.column, name);
  }
  std::ranges::sort(places);
  std::vector<std::string> names;
  for (const auto& place : places) names.push_back(std::get<3>(place));
  return names;
}

void TomlTable::refuse_others(const std::vector<std::string>& more) const {
  const std::vector<std::string> unknown = others();
  if (!unknown.empty()) refuse_unknown(unknown.front(), more);
}

void TomlTable::refuse_unknown(const std::string& name,
                               const std::vector<std::string>& more) const {
  std::vector<std::string> accepted = known_;
  for (const std::string& word : more) {
    if (std::ranges::find(accepted, word) == accepted.end()) accepted.push_back(word);
  }
  fail(name, "unknown" + accepted_words(name, accepted));
}

}  // namespace occlab
