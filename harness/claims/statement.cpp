#include "harness/claims/statement.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

bool is_word_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '.';
}

struct Token {
  std::string text;
  std::size_t at = 0;    ///< of its first character
  bool quoted = false;   ///< a text in quotes, without them
  bool is_word = false;  ///< a name or a number
};

/// All functions throw InputError with the text and the place in it.
class Reader {
 public:
  Reader(const std::string& text, const ClaimVariables& variables, std::set<std::string>& used)
      : text_(text), variables_(variables), used_(used) {
    advance();
  }

  [[noreturn]] void fail(const std::string& accepted) const {
    const std::string found =
        next_.text.empty() && !next_.quoted ? "the end" : "'" + next_.text + "'";
    throw InputError(fmt::format("'{}', character {}: found {}; accepted: {}", text_, next_.at + 1,
                                 found, accepted));
  }

  const Token& next() const { return next_; }
  bool at_end() const { return next_.text.empty() && !next_.quoted; }
  bool is_sign(std::string_view sign) const {
    return !next_.quoted && !next_.is_word && next_.text == sign;
  }

  Token take() {
    Token token = next_;
    advance();
    return token;
  }
  bool take_sign(std::string_view sign) {
    if (!is_sign(sign)) return false;
    advance();
    return true;
  }
  void require_sign(std::string_view sign) {
    if (!take_sign(sign)) fail(fmt::format("'{}'", sign));
  }
  std::string word(const std::string& accepted) {
    if (!next_.is_word) fail(accepted);
    return take().text;
  }
  /// A word, a number or a text in quotes; a variable's value.
  std::string value() {
    if (!next_.is_word && !next_.quoted) fail("a value");
    Token token = take();
    const auto variable = variables_.find(token.text);
    if (token.quoted || variable == variables_.end()) return token.text;
    used_.insert(token.text);
    return variable->second;
  }
  /// A number above 0; nothing where the next word is none.
  std::optional<double> number() {
    if (!next_.is_word) return std::nullopt;
    double value = 0.0;
    const char* const end = next_.text.data() + next_.text.size();
    const auto [rest, error] = std::from_chars(next_.text.data(), end, value);
    if (error != std::errc() || rest != end) return std::nullopt;
    if (!(value > 0.0) || !std::isfinite(value)) fail("a number above 0");
    advance();
    return value;
  }
  double require_number() {
    const std::optional<double> value = number();
    if (!value) fail("a number above 0");
    return *value;
  }

 private:
  void advance() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
    next_ = {"", at_, false, false};
    if (at_ == text_.size()) return;
    if (text_[at_] == '\'') return advance_over_quotes();
    std::size_t end = at_;
    while (end < text_.size() && is_word_character(text_[end])) ++end;
    next_.is_word = end > at_;
    if (!next_.is_word) ++end;
    next_.text = text_.substr(at_, end - at_);
    at_ = end;
  }
  void advance_over_quotes() {
    const std::size_t end = text_.find('\'', at_ + 1);
    if (end == std::string::npos) {
      next_.text = text_.substr(at_);
      fail("a second quote");
    }
    next_.text = text_.substr(at_ + 1, end - at_ - 1);
    next_.quoted = true;
    at_ = end + 1;
  }

  const std::string& text_;
  const ClaimVariables& variables_;
  std::set<std::string>& used_;
  std::size_t at_ = 0;  // behind next_
  Token next_;
};

/// `time` and `time.PASS` are short for `time_ms.PASS`.
std::string full_metric(const std::string& name) {
  if (name == "time") return "time_ms.occlusion";
  if (name.starts_with("time.")) return "time_ms." + name.substr(5);
  return name;
}

void read_argument(Reader& reader, ClaimTerm& term) {
  const Token first = reader.next();
  std::string name = "samples";
  std::string value = reader.value();
  if (reader.is_sign("=")) {
    if (first.quoted) reader.fail("',' or ')'");
    reader.take();
    name = first.text;
    value = reader.value();
  }
  if (term.filter(name)) {
    throw InputError(fmt::format("'{}' is there twice in {}(...)", name, term.metric));
  }
  term.filters.emplace_back(name, value);
}

ClaimTerm read_term(Reader& reader) {
  ClaimTerm term;
  term.metric = full_metric(reader.word("a number above 0 or a metric, such as noise(ssdo, 32)"));
  reader.require_sign("(");
  if (reader.is_sign(")")) reader.fail("a method");
  term.method = reader.value();
  while (reader.take_sign(",")) read_argument(reader, term);
  if (!reader.take_sign(")")) reader.fail("',' or ')'");
  return term;
}

ClaimQuantity read_side(Reader& reader) {
  ClaimQuantity side;
  int power = 1;
  for (;;) {
    if (const std::optional<double> number = reader.number()) {
      side.number *= power > 0 ? *number : 1.0 / *number;
    } else {
      side.factors.push_back({read_term(reader), power});
    }
    if (reader.take_sign("*")) {
      power = 1;
    } else if (reader.take_sign("/")) {
      power = -1;
    } else {
      return side;
    }
  }
}

/// A term over itself says nothing, and would have no error.
void require_terms(const ClaimQuantity& quantity, const std::string& text) {
  if (quantity.factors.empty()) {
    throw InputError(fmt::format("'{}': no measurement in it, such as noise(ssdo, 32)", text));
  }
  for (const ClaimFactor& factor : quantity.factors) {
    const bool cancels = std::ranges::any_of(quantity.factors, [&](const ClaimFactor& other) {
      return other.power != factor.power && other.term == factor.term;
    });
    if (cancels) {
      throw InputError(fmt::format("'{}': {} is divided by itself", text, to_string(factor.term)));
    }
  }
}

/// Left over right; the numbers go to the bounds.
ClaimStatement relate(ClaimQuantity left, const ClaimQuantity& right, double low, double high) {
  const double scale = right.number / left.number;
  ClaimStatement statement{std::move(left), low * scale, high * scale};
  statement.quantity.number = 1.0;
  for (const ClaimFactor& factor : right.factors) {
    statement.quantity.factors.push_back({factor.term, -factor.power});
  }
  return statement;
}

ClaimStatement read_statement(Reader& reader) {
  ClaimQuantity left = read_side(reader);
  if (reader.take_sign(">")) return relate(std::move(left), read_side(reader), 1.0, infinity);
  if (reader.take_sign("<")) return relate(std::move(left), read_side(reader), 0.0, 1.0);
  if (reader.take_sign("~")) {
    const ClaimQuantity right = read_side(reader);
    if (reader.next().text != "within") reader.fail("'*', '/' or 'within'");
    reader.take();
    const double margin = 1.0 + reader.require_number() / 100.0;
    reader.require_sign("%");
    return relate(std::move(left), right, 1.0 / margin, margin);
  }
  if (reader.next().text != "in") reader.fail("'*', '/', '>', '<', '~' or 'in'");
  reader.take();
  reader.require_sign("[");
  const double low = reader.require_number();
  reader.require_sign(",");
  const double high = reader.require_number();
  if (!(low < high)) reader.fail(fmt::format("a number above {:g} before it", low));
  reader.require_sign("]");
  return relate(std::move(left), {}, low, high);
}

}  // namespace

const std::string* ClaimTerm::filter(std::string_view name) const {
  const auto found = std::ranges::find_if(filters, [&](const auto& f) { return f.first == name; });
  return found == filters.end() ? nullptr : &found->second;
}

std::string to_string(const ClaimTerm& term, const std::set<std::string>& shown) {
  std::string text =
      (term.metric.starts_with("time_ms.") ? "time." + term.metric.substr(8) : term.metric) + "(" +
      term.method;
  for (const auto& [name, value] : term.filters) {
    if (!shown.contains(name)) continue;
    text += name == "samples" ? ", " + value : fmt::format(", {}={}", name, value);
  }
  return text + ")";
}

std::string to_string(const ClaimQuantity& quantity) {
  // Filters that tell its terms apart are worth their place.
  std::set<std::string> shown = {"samples"};
  const auto add_differences = [&](const ClaimTerm& of, const ClaimTerm& from) {
    for (const auto& [name, value] : of.filters) {
      const std::string* const other = from.filter(name);
      if (other && *other != value) shown.insert(name);
    }
  };
  const ClaimTerm& first = quantity.factors.front().term;
  for (const ClaimFactor& factor : quantity.factors) add_differences(factor.term, first);
  std::string text;
  for (const int power : {1, -1}) {
    for (const ClaimFactor& factor : quantity.factors) {
      if (factor.power != power) continue;
      if (power < 0) {
        text += text.empty() ? "1 / " : " / ";
      } else if (!text.empty()) {
        text += " * ";
      }
      text += to_string(factor.term, shown);
    }
  }
  return text;
}

ClaimStatement parse_statement(const std::string& text, const ClaimVariables& variables,
                               std::set<std::string>& used) {
  Reader reader(text, variables, used);
  ClaimStatement statement = read_statement(reader);
  if (!reader.at_end()) reader.fail("'*', '/' or the end");
  require_terms(statement.quantity, text);
  return statement;
}

ClaimQuantity parse_quantity(const std::string& text, const ClaimVariables& variables,
                             std::set<std::string>& used) {
  Reader reader(text, variables, used);
  ClaimQuantity quantity = read_side(reader);
  if (!reader.at_end()) reader.fail("'*', '/' or the end");
  require_terms(quantity, text);
  if (quantity.number != 1.0) {
    throw InputError(fmt::format("'{}': found a number; accepted: measurements alone", text));
  }
  return quantity;
}

bool is_variable_name(std::string_view text) {
  const auto capital = [](char c) { return c >= 'A' && c <= 'Z'; };
  return !text.empty() && capital(text.front()) && std::ranges::all_of(text, [&](char c) {
    return capital(c) || (c >= '0' && c <= '9') || c == '_';
  });
}

}  // namespace occlab
