#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "renderers/gl/program.h"
#include "renderers/gl/texture.h"
#include "renderers/scene/view.h"

namespace occlab {

/// Precision of the position and normal targets; 16 is the paper's [S3HO sec. 3] and self-occludes.
enum class GBufferBits { float32, float16 };

void delete_vertex_array(GLuint id);

/// A scene's triangles and textures on the device.
class GpuScene {
 public:
  explicit GpuScene(const Scene& scene);

  struct Draw {
    GlObject<delete_vertex_array> vertex_array;
    Buffer vertices;
    Buffer indices;
    GLsizei index_count = 0;
  };
  const std::vector<Draw>& draws() const { return draws_; }  ///< one a Scene::meshes entry
  const std::vector<Texture>& textures() const { return textures_; }

 private:
  std::vector<Draw> draws_;
  std::vector<Texture> textures_;
};

/// What the first surface seen through each pixel's centre is, in view space. Texel (x, y) is the
/// image's pixel (x, y), row 0 at the top.
struct GBuffer {
  Framebuffer targets;

  /// xyz: position in scene units; w: 1 where a surface is seen, 0 on the background.
  const Texture& position_view() const { return targets.colors()[0]; }
  /// xyz: unit shading normal, on the viewer's side of the surface.
  const Texture& normal_view() const { return targets.colors()[1]; }
  /// xyz: unit geometric normal, on the viewer's side.
  const Texture& geometric_normal_view() const { return targets.colors()[2]; }
  /// rgb: reflectance rho.
  const Texture& albedo() const { return targets.colors()[3]; }
};

inline constexpr std::string_view gbuffer_shader = "renderers/gl/gbuffer.frag";

/// How a pass differs from others with its fragment shader.
struct SurfaceVariant {
  std::string defines = {};
  std::function<void(const Program&)> set = {};  ///< uniforms and textures that these ask for
};

/// Draws the scene's surfaces into the framebuffer that is bound, with gbuffer.vert and a fragment
/// shader that takes what that gives. Depth test, blending and culling are as they stand.
/// gl_FrontFacing is true where triangles are counter-clockwise.
void draw_surfaces(const Scene& scene, const GpuScene& gpu_scene, const glm::mat4& view_from_world,
                   const glm::mat4& clip_from_view, std::string_view fragment_shader,
                   ProgramCache& programs, const SurfaceVariant& variant = {});

/// Clears the framebuffer that is bound; tests depth, and blends and culls nothing.
void clear_for_surfaces();

/// The view's perspective with the image's top row at texel row 0 (clip y points down).
glm::mat4 clip_from_view(const View& view);

/// Draws the scene into a G-buffer's targets.
void draw_gbuffer(const Framebuffer& targets, const Scene& scene, const GpuScene& gpu_scene,
                  const View& view, ProgramCache& programs);

GBuffer render_gbuffer(const Scene& scene, const GpuScene& gpu_scene, const View& view,
                       GBufferBits bits, ProgramCache& programs);

/// The G-buffer read back for the ray tracer and the metrics; one image a target, 3 channels, and
/// the validity as a mask (1 channel, 0 or 1).
struct GBufferImages {
  Image position_view;
  Image normal_view;
  Image geometric_normal_view;
  Image albedo;
  Image mask;
};
GBufferImages download(const GBuffer& gbuffer);

/// The same of targets read back, each with 4 channels or empty; `format` is that of the normals.
/// Throws DeviceError where a surface's
/// position or normal is not finite.
GBufferImages gbuffer_images(const Image& position, const Image& normal,
                             const Image& geometric_normal, const Image& albedo, GLenum format);

}  // namespace occlab
