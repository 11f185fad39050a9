#include "renderers/scene/limited_json.h"

#include <fmt/format.h>

#include <cstdint>

#include "renderers/scene/error.h"
#include "renderers/scene/limits.h"

namespace occlab {
namespace {

using nlohmann::json;

/// Counts, and keeps nothing.
class Counter : public nlohmann::json_sax<json> {
 public:
  explicit Counter(const std::string& where) : where_(&where) {}

  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool number_integer(number_integer_t) override { return value(); }
  bool number_unsigned(number_unsigned_t) override { return value(); }
  bool number_float(number_float_t, const string_t&) override { return value(); }
  bool string(string_t&) override { return value(); }
  bool binary(binary_t&) override { return value(); }
  bool key(string_t&) override { return true; }
  bool start_object(std::size_t) override { return open(); }
  bool start_array(std::size_t) override { return open(); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool parse_error(std::size_t, const std::string&, const json::exception& error) override {
    throw InputError(fmt::format("{}: {}", *where_, error.what()));
  }

 private:
  bool value() {
    require_within(Limit::json_values, ++values_, "or more JSON values", *where_);
    return true;
  }
  bool open() {
    require_within(Limit::nesting, ++depth_, "or more levels of nested JSON", *where_);
    return value();
  }
  bool close() {
    --depth_;
    return true;
  }

  const std::string* where_;
  std::uint64_t values_ = 0;
  std::uint64_t depth_ = 0;
};

}  // namespace

json parse_limited_json(std::string_view text, const std::string& where) {
  Counter counter(where);
  json::sax_parse(text, &counter);
  try {
    return json::parse(text);
  } catch (const json::exception& error) {
    throw InputError(fmt::format("{}: {}", where, error.what()));
  }
}

json parse_limited_json_or_discard(std::string_view text) {
  try {
    return parse_limited_json(text, "");
  } catch (const InputError&) {
    return json(json::value_t::discarded);
  }
}

}  // namespace occlab
