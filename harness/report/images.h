#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "harness/report/cells.h"

namespace occlab::report {

/// What the images of a report share.
struct Frame {
  int width = 0;
  int height = 0;
  Image reference;              ///< radiance; empty if there is none
  Image mask;                   ///< the reference's; 1 everywhere without one
  double mean_luminance = 1.0;  ///< of the reference over the mask
  double exposure = 1.0;        ///< of the figures (figures/tone_map.h)
};

/// From the reference's layers; where they are null, from any layers of the run and with a mean
/// luminance and an exposure of 1.
Frame make_frame(const Layers* reference, const Layers* some);

/// A layer of one image that the page shows.
struct PackedLayer {
  std::string id;     ///< "g3-radiance": names its file
  std::string owner;  ///< "g3": the group of that index; "march": the failure classes
  std::string name;
  std::string kind;  ///< radiance, share, direction, signed, positive or coefficients
  std::string cell;  ///< id; "" for what is of all seeds
  int width = 0;     ///< of what is stored: every step-th pixel
  int height = 0;
  int channels = 0;
  int step = 1;
  std::string note;       ///< "" or what is to be said of it
  std::size_t bytes = 0;  ///< of its file
  std::string preview;    ///< a PNG in the report's folder, "" if there is none
};

struct PackedImages {
  std::vector<PackedLayer> layers;
  std::vector<std::string> left_out;  ///< what did not fit
};

/// Packs layers into FOLDER/data and FOLDER/previews by what a reader needs first, as far as they
/// fit into `limit` bytes: the reference; the final images of every method's first group; their
/// occlusion, coefficients, bent normals and maps (maps.h); the final images of the other groups,
/// those that `closeups` select first; the images before the filter. Such a set fits as a whole or
/// is left out. All but radiance and occlusion are decimated to a width of about 480 pixels,
/// coefficients to 270. Cells that cannot be read get their `problem`.
PackedImages pack_images(std::vector<Cell>& cells, const std::vector<Group>& groups,
                         const nlohmann::json& closeups, const Frame& frame, std::size_t limit,
                         const std::filesystem::path& folder);

}  // namespace occlab::report
