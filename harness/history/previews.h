#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace occlab::history {

inline constexpr int preview_width = 480;  ///< pixels, at most

/// A small picture of what a method made, tone-mapped with the exposure of the run's figures.
struct Preview {
  std::string scene;
  std::string view;
  std::string method;
  std::vector<std::pair<std::string, std::string>> parameters;  ///< without `seed`
  std::string stage;
  std::string hash;  ///< SHA-256 of `png`
  std::vector<std::uint8_t> png;
};

/// The reference's final image and that of every method's first cell: PNGs of at most
/// preview_width. Cells that are missing or damaged have none, and `problems` says so.
std::vector<Preview> make_previews(const std::filesystem::path& results, const nlohmann::json& run,
                                   std::vector<std::string>& problems);

}  // namespace occlab::history
