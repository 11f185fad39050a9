#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "renderers/gl/gbuffer.h"

namespace occlab {

/// Where more than the first surface of each pixel comes from [SSDO sec. 4].
enum class HiddenKind {
  layers,   ///< depth peeling: what lies behind it, in the order of depth
  cameras,  ///< what other cameras see first
};

struct HiddenSettings {
  HiddenKind kind = HiddenKind::layers;
  int count = 1;  ///< layers beside the first, or cameras beside the view's own
  GBufferBits bits = GBufferBits::float32;
  bool complete = false;       ///< with normals and albedo, not positions alone
  float camera_offset = 1.0f;  ///< from the view's camera, in radii of the scene's bounding sphere
  float camera_scale = 0.5f;   ///< resolution, as a share of the view's
  bool operator==(const HiddenSettings&) const = default;
};

/// A camera beside the view's own.
struct HiddenCamera {
  View view;
  glm::mat4 camera_from_view{1.0f};  ///< from the space of the view's own camera into this one's
};

/// The cameras beside the view's own: all look at `center_view`, from where the view's camera would
/// be if it were moved by camera_offset bounding radii toward cos(a) right + sin(a) up,
/// a = pi (i + 1/2) / count: below the view's camera a floor would be seen from below.
std::vector<HiddenCamera> hidden_cameras(const View& view, const HiddenSettings& settings,
                                         float bounding_radius, glm::vec3 center_view);

/// The center of interest: the surface that is seen in the middle of the view; without one the
/// point of the view's axis that is nearest to the middle of the scene's bounds, at least one near
/// distance away. View space.
glm::vec3 center_of_interest(const GBuffer& first, const View& view, const Scene& scene);

/// Surfaces beside the first ones of a view, as arrays of as many layers as HiddenSettings::count.
/// Everything is in the space of the view's own camera. Layers have the view's pixels, cameras
/// those of their own views.
class HiddenSurfaces {
 public:
  /// Allocates, and places the cameras by the first surfaces.
  HiddenSurfaces(const Scene& scene, const View& view, const GBuffer& first,
                 const HiddenSettings& settings);

  /// xyz: position; w: 1 where a triangle is seen from its front (counter-clockwise), 2 from its
  /// back, 0 where none is seen.
  const Texture& position_view() const { return arrays_[0]; }
  /// With HiddenSettings::complete only, as in GBuffer; but what layers show from its back has its
  /// normals on the side away from the viewer, who is inside of it.
  const Texture& normal_view() const { return arrays_[1]; }
  const Texture& geometric_normal_view() const { return arrays_[2]; }
  const Texture& albedo() const { return arrays_[3]; }

  const HiddenSettings& settings() const { return settings_; }
  int width() const { return arrays_.front().width(); }
  int height() const { return arrays_.front().height(); }
  const std::vector<HiddenCamera>& cameras() const { return cameras_; }  ///< empty with layers

  /// Draws all of them. `first` has just been drawn: layers begin behind its depth.
  void draw(const Scene& scene, const GpuScene& gpu_scene, const View& view, const GBuffer& first,
            ProgramCache& programs) const;

 private:
  HiddenSettings settings_;
  std::vector<HiddenCamera> cameras_;
  std::vector<Texture> arrays_;
  std::vector<Texture> depths_;  ///< two in turn
  std::vector<LayerFramebuffer> targets_;
};

/// Hidden surfaces read back: an image of each layer or camera. `mask` is position_view's w.
/// Without HiddenSettings::complete there is nothing but `position_view` and `mask`.
struct HiddenImages {
  std::vector<GBufferImages> images;
  std::vector<HiddenCamera> cameras;  ///< empty with layers
};
HiddenImages download(const HiddenSurfaces& hidden);

/// Which side the first surfaces' triangles are seen from, as position_view()'s w; one channel.
Image sides_of_first(const Scene& scene, const GpuScene& gpu_scene, const View& view,
                     ProgramCache& programs);

}  // namespace occlab
