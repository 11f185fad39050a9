#include "harness/report/figure_files.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "harness/files.h"
#include "renderers/scene/error.h"

namespace occlab::report {
namespace fs = std::filesystem;
namespace {

constexpr int widest = 1600;  ///< pixels

/// Writes the smaller picture; returns why it cannot, "" if it did.
std::string copy_figure(const fs::path& source, const fs::path& target, nlohmann::json& figure) {
  std::error_code error;
  if (!fs::is_regular_file(source, error)) return "the run has not drawn it";
  OIIO::ImageBuf picture(source.string());
  if (!picture.read(0, 0, true, OIIO::TypeDesc::FLOAT)) return picture.geterror();
  const OIIO::ImageSpec& spec = picture.spec();
  const int width = std::min(widest, spec.width);
  const int height = std::max(1, int(std::lround(double(spec.height) * width / spec.width)));
  OIIO::ImageBuf page =
      width == spec.width
          ? picture
          : OIIO::ImageBufAlgo::resize(picture, "", 0.0f, OIIO::ROI(0, width, 0, height));
  page.specmod().attribute("Compression", "jpeg:88");
  if (page.has_error() || !page.write(target.string(), OIIO::TypeDesc::UINT8, "jpeg")) {
    throw DeviceError(fmt::format("{}: cannot be written: {}", target.string(), page.geterror()));
  }
  figure["file"] = "figures/" + target.filename().string();
  figure["width"] = width;
  figure["height"] = height;
  return "";
}

}  // namespace

void copy_figures(nlohmann::json& figures, const fs::path& results, const fs::path& folder) {
  create_folder(folder / "figures");
  for (nlohmann::json& figure : figures) {
    const std::string name = figure["name"];
    const std::string missing = copy_figure(results / "figures" / (name + ".png"),
                                            folder / "figures" / (name + ".jpg"), figure);
    if (!missing.empty()) figure["missing"] = missing;
  }
}

}  // namespace occlab::report
