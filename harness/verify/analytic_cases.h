#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "renderers/methods/parameters.h"
#include "renderers/scene/environment.h"

namespace occlab {

/// A surface point to shade that no camera need see, world space. The normals are unit vectors.
struct AnalyticPoint {
  glm::vec3 position{0.0f};
  glm::vec3 normal{0.0f};
  glm::vec3 geometric_normal{0.0f};
};

/// Pixels of a view, all of which show a surface.
struct AnalyticRegion {
  std::string camera;
  int width = 0;  ///< of the image
  int height = 0;
  int x = 0;  ///< the region's first pixel; row 0 is the top
  int y = 0;
  int columns = 0;
  int rows = 0;
};

/// What a case must give: a value, a picture's own, or the same as before.
enum class Expectation {
  value,     ///< the mean over the region and over seeds is `expected`
  equals,    ///< pixel by pixel and with one seed, what `other` gives
  turned,    ///< block by block the same in a world that is turned and moved, camera and all
  rolled,    ///< block by block the same, upside down, for a camera that stands on its head
  mirrored,  ///< block by block the mirror image in a mirrored world
};

/// A method, its parameters and one of its layers. Vectors (`bent_normal`) and harmonics
/// (`sh_visibility`) are compared in world space.
struct AnalyticQuantity {
  std::string method;
  std::string layer;
  /// NAME=VALUE, as --set takes them; checked against the method's declarations.
  std::vector<std::string> settings;

  ParameterSet parameters() const;
  /// Whether the layer's channels belong to axes.
  bool is_directional() const { return layer == "bent_normal" || layer == "sh_visibility"; }
};

/// One thing that a scene file says about itself (scenes/FORMAT.md, "Scenes that carry their
/// expected values").
struct AnalyticCase {
  std::string place;   ///< "FILE: scenes[0].extras.occlab_verify.cases[3]", for messages
  std::string name;    ///< of the file and the case: "wall: kappa = .25"
  std::string source;  ///< the formula and whose it is
  AnalyticQuantity quantity;
  std::optional<AnalyticPoint> point;    ///< either this
  std::optional<AnalyticRegion> region;  ///< or this
  std::shared_ptr<const Environment> sky;
  int seeds = 0;  ///< independent repetitions, 1 for Expectation::equals
  Expectation expectation = Expectation::value;
  std::vector<double> expected;  ///< one a channel of the layer
  std::optional<AnalyticQuantity> other;
  double bound = 0.0;        ///< what is accepted beside chance
  std::string bound_source;  ///< where that comes from; "" if it is 0
};

/// A scene file with its cases, one for each of the methods a case names.
struct AnalyticFile {
  std::filesystem::path path;
  std::vector<AnalyticCase> cases;
};

/// Reads scenes[0].extras.occlab_verify of a .glb or .gltf. Throws InputError naming file and key
/// for what is missing, unknown, of the wrong type or out of range.
AnalyticFile read_analytic_file(const std::filesystem::path& path);

/// The .glb and .gltf files of a folder, sorted, or the one file. Throws InputError where there is
/// none.
std::vector<std::filesystem::path> analytic_files(const std::filesystem::path& folder_or_file);

}  // namespace occlab
