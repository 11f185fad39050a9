#pragma once

#include <map>
#include <memory>
#include <vector>

#include "harness/verify/analytic_cases.h"
#include "renderers/methods/frame.h"
#include "renderers/scene/image_io.h"

namespace occlab {

/// The world of a scene file as it is, turned or mirrored with camera, lights and sky, or seen by a
/// camera that is rolled by 180 degrees.
enum class World { plain, turned, rolled, mirrored };

/// Renders the cases of one scene file. Needs a current graphics context.
class AnalyticBench {
 public:
  explicit AnalyticBench(const AnalyticFile& file, ProgramCache& programs);
  AnalyticBench(const AnalyticBench&) = delete;
  AnalyticBench& operator=(const AnalyticBench&) = delete;
  ~AnalyticBench();

  /// The layer within the case's region, one image a seed from `first_seed` on. Vectors and
  /// harmonics are in world space; a picture that is mirrored or upside down is put right. Throws
  /// InputError where the region shows background.
  std::vector<Image> render(const AnalyticCase& one, const AnalyticQuantity& quantity, World world,
                            int first_seed, int seeds);

 private:
  struct Place;  ///< a world's scene on the device
  const Place& place(World world);
  Frame& frame(const AnalyticCase& one, World world);
  std::vector<Layers> render_layers(const AnalyticCase& one, const AnalyticQuantity& quantity,
                                    World world, int first_seed, int seeds);

  std::filesystem::path path_;
  Scene scene_;
  ProgramCache& programs_;
  std::map<World, std::unique_ptr<Place>> places_;
  std::map<std::string, std::unique_ptr<Frame>> frames_;
  /// Of one view: its cases look at several layers and regions of one rendering.
  std::map<std::string, std::vector<Layers>> rendered_;
  std::string rendered_view_;
};

/// Coefficients of one function, turned: 16 channels in the space whose axes are the columns'
/// images under `view_from_world`, given back in world space.
Image sh_in_world(const Image& sh_view, const glm::mat3& view_from_world);

}  // namespace occlab
