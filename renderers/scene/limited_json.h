#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace occlab {

/// JSON that somebody else may have written. Its depth and the number of its values are checked
/// before a tree is built, which takes ten times the text's memory and which copies and prints by
/// recursion. Throws InputError "WHERE: the reason" for what is no JSON or beyond the limits
/// `nesting` and `json_values`.
nlohmann::json parse_limited_json(std::string_view text, const std::string& where);

/// The same, with nlohmann's discarded value in place of errors.
nlohmann::json parse_limited_json_or_discard(std::string_view text);

}  // namespace occlab
