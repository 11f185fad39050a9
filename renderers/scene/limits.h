#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace occlab {

/// What a file may ask for. Files come from anywhere and may claim anything: what goes beyond a
/// limit is refused before memory is taken for it. The declarations are in limits.cpp.
enum class Limit {
  file_bytes,
  config_bytes,
  nesting,
  json_values,
  name_bytes,
  instances,
  triangles,
  vertices,
  cameras,
  lights,
  texture_pixels,
  texture_bytes,
  probe_pixels,
  image_pixels,
  image_channels,
  image_bytes,
  image_expansion,
};

struct LimitInfo {
  Limit limit;
  std::string_view name;
  std::uint64_t default_value;
  std::string_view what;  ///< one sentence, with its unit
};

/// All limits, in the order of Limit.
std::span<const LimitInfo> limits();

/// The value in force: that of set_limits(), else of the environment variable OCCLAB_LIMITS
/// ("instances=5000000,texture_bytes=4294967296"), else the default. A malformed OCCLAB_LIMITS
/// throws InputError at the first use.
std::uint64_t limit(Limit which);

/// Replaces OCCLAB_LIMITS for the whole process; limits that `text` does not name get their
/// defaults. Not to be called while another thread loads something. Throws InputError.
void set_limits(std::string_view text);

/// Throws InputError "WHERE: FOUND WHAT; accepted: up to N (limit NAME, see OCCLAB_LIMITS)" if
/// `found` is beyond the limit.
void require_within(Limit which, std::uint64_t found, std::string_view what,
                    const std::string& where);

/// The sum, or the largest integer where it would wrap around.
std::uint64_t saturating_add(std::uint64_t a, std::uint64_t b);
/// The product, likewise.
std::uint64_t saturating_multiply(std::uint64_t a, std::uint64_t b);

}  // namespace occlab
