#pragma once

#include <toml++/toml.h>

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "renderers/methods/parameters.h"

namespace occlab {

/// Parses a TOML file and applies the overrides "KEY=VALUE" to it: KEY is dotted and indexed
/// ("run[0].seeds"), VALUE is TOML or a bare word. Every node remembers its line, or the override
/// it came from. Throws InputError with the file and line, or with `--set KEY=VALUE`.
toml::table parse_toml(const std::filesystem::path& path,
                       const std::vector<std::string>& overrides);

/// A strict reader of one TOML table: it remembers which keys it was asked for, and every error
/// names the file and line (or the override), the whole key, what was found and what is accepted.
/// Accessors without a fallback require their key.
class TomlTable {
 public:
  /// `key` is the table's own key, empty for the root; `file` begins the errors.
  TomlTable(const toml::table& table, std::string key, std::string file);

  bool has(const std::string& name);
  std::string text(const std::string& name);
  std::string text(const std::string& name, const std::string& fallback);
  /// A text of [a-z0-9_-]+, as it becomes part of a file's name.
  std::string identifier(const std::string& name);
  std::string one_of(const std::string& name, const std::vector<std::string>& accepted,
                     const std::string& fallback);
  long integer(const std::string& name, long minimum, long maximum, std::optional<long> fallback);
  /// Integers are taken for reals.
  double real(const std::string& name, double minimum, double maximum,
              std::optional<double> fallback);
  /// A list of texts that is not empty and has no text twice.
  std::vector<std::string> words(const std::string& name);
  /// A list of `count` numbers; whole says that all are TOML integers (the other case is mixed or
  /// all TOML floats).
  struct Numbers {
    std::vector<double> values;
    bool whole = false;
  };
  Numbers numbers(const std::string& name, std::size_t count);
  /// One parameter value; where `list` is set also a list of them, which are different unless
  /// `repeats` is set, or a range {from, to, step} or {from, to, factor} (toml_ranges.cpp).
  std::vector<ParameterValue> values(const std::string& name, bool list, bool repeats = false);
  /// A text that may be a path (is_path): then absolute, relative paths being relative to the
  /// file's folder, or to the current folder where an override gave it.
  std::string name_or_path(const std::string& name);
  /// The same of a text or a list of them, which are different unless `repeats` is set.
  std::vector<std::string> names_or_paths(const std::string& name, bool repeats);
  /// Whether the key has a list or a table: more than one value.
  bool is_list(const std::string& name);
  /// A list of lists of at least two texts, none of which is there twice; empty where the key is
  /// absent.
  std::vector<std::vector<std::string>> word_lists(const std::string& name);

  TomlTable table(const std::string& name);
  /// A list of tables that is not empty.
  std::vector<TomlTable> tables(const std::string& name);

  /// Keys that were not asked for yet, in file order.
  std::vector<std::string> others() const;
  /// Throws for the first of others(); `more` is accepted besides the keys asked for.
  void refuse_others(const std::vector<std::string>& more = {}) const;
  [[noreturn]] void refuse_unknown(const std::string& name,
                                   const std::vector<std::string>& more) const;

  /// Throws InputError at the key's place, or at the table's where the key is absent.
  [[noreturn]] void fail(const std::string& name, const std::string& message) const;

 private:
  const toml::node* find(const std::string& name);
  const toml::node& require(const std::string& name, std::string_view what);
  std::string full_key(const std::string& name) const;
  std::string where(const toml::node& node) const;
  [[noreturn]] void wrong_type(const std::string& name, const toml::node& found,
                               std::string_view accepted) const;
  ParameterValue parameter_value(const std::string& name, const toml::node& node) const;
  std::string name_or_path(const toml::node& node) const;
  std::vector<ParameterValue> range(const std::string& name);

  const toml::table* table_;
  std::string key_;
  std::string file_;
  std::vector<std::string> known_;
};

}  // namespace occlab
