#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "renderers/scene/image.h"
#include "renderers/scene/limits.h"

namespace occlab {

/// Named images of one size that belong together, in display order: what a method returns and what
/// one EXR file holds. A layer's name is the field's term, such as `radiance`.
class Layers {
 public:
  struct Layer {
    std::string name;
    Image image;
  };

  /// Adds a layer; the name is new and every layer has the same width and height.
  void add(std::string name, Image image);
  /// nullptr if there is no such layer.
  const Image* find(const std::string& name) const;
  /// Throws InputError naming the layers there are.
  const Image& at(const std::string& name) const;
  const std::vector<Layer>& all() const { return layers_; }

 private:
  std::vector<Layer> layers_;
};

/// Facts stored with an image: keys such as `occlab:method`, values as text.
using Metadata = std::map<std::string, std::string>;

/// Writes one EXR part, float, ZIP. A layer `radiance` with three channels becomes the channels
/// radiance.R, .G, .B; one channel becomes .V, four .R .G .B .A, any other number .c0, .c1, ...
/// The file is complete or absent: it is written beside `path` and renamed. Throws DeviceError.
void write_exr(const std::filesystem::path& path, const Layers& layers, const Metadata& metadata);

struct ExrFile {
  Layers layers;
  Metadata metadata;  ///< only the keys that start with "occlab:"
};

/// Reads what write_exr wrote, and any other EXR: channels without a layer prefix become the layer
/// "" (R, G, B first). Throws InputError naming the file and the reason.
ExrFile read_exr(const std::filesystem::path& path);

/// Reads the first three channels of an OpenEXR, Radiance HDR or PNG file, as linear RGB; a
/// one-channel image is repeated. Sizes of zero, sizes beyond `most_pixels` and the other limits of
/// images, and unreadable files throw InputError; values are not judged.
Image read_rgb(const std::filesystem::path& path, Limit most_pixels = Limit::image_pixels);

/// Writes `image` (display-referred sRGB in [0, 1], 1 or 3 channels) as an 8-bit PNG, atomically.
void write_png(const std::filesystem::path& path, const Image& image);

/// OpenImageIO's version, for run.json.
std::string image_library_version();

}  // namespace occlab
