#pragma once

#include <optional>
#include <string>
#include <vector>

#include "renderers/gl/shadow_map.h"
#include "renderers/methods/frame.h"
#include "renderers/methods/mapped_lights.h"
#include "renderers/methods/method.h"

namespace occlab {

/// The parameters of lights with shadow maps, and of the screen-space correction.
std::vector<Parameter> shadow_map_parameters();

/// The scene's lights, and the environment's, as the parameters have them. Throws InputError where
/// nothing is left to light the scene.
struct DirectLights {
  std::vector<MappedLight> punctual;
  std::vector<MappedLight> environment;
};
DirectLights direct_lights(const Frame& frame, const ParameterSet& parameters);

/// Uses a program of screen_space.glsl for a full-screen pass over a frame's G-buffer.
const Program& use_frame_program(const Frame& frame, const ParameterSet& parameters,
                                 const std::string& shader, const std::string& preamble);

/// GLSL, for use_frame_program(): in the march of screen_space.glsl any blocker means shadow.
std::string binary_march(const ParameterSet& parameters);

/// The light of lights whose shadow maps tell where it is blocked, with screen space telling what
/// the maps' bias hides [SSDO sec. 5].
class MappedLighting {
 public:
  /// Draws each light's maps, and adds its irradiance to the first of the target's textures.
  void add(const Frame& frame, const ParameterSet& parameters,
           const std::vector<MappedLight>& lights, const Framebuffer& target);

 private:
  const ShadowMaps& maps(int side, int faces);
  std::optional<ShadowMaps> maps_;
};

/// Draws what the correction looks at behind the first surfaces, if it does: once more for every
/// frame, as a renderer whose scene moves has to.
void draw_layers(const Frame& frame, const ParameterSet& parameters);
/// How many lights of each kind there are, and what the layers turned out to be.
void add_shadow_map_facts(const Frame& frame, const ParameterSet& parameters, Metadata& facts);

/// L_o = (rho/pi) E of a texture of irradiance: replaces what the target holds, or is added to it.
enum class Into { replaced, added };
void light_surfaces(const Frame& frame, const ParameterSet& parameters, const Texture& irradiance,
                    const Framebuffer& target, Into into);

/// Zeroes a float target.
void clear_light(const Framebuffer& target);

/// A float target of the view's size, kept from frame to frame.
const Framebuffer& light_target(std::optional<Framebuffer>& target, const View& view);

inline constexpr const char* mapped_light_shader = "renderers/methods/shadow_maps.frag";
inline constexpr const char* surface_lighting_shader = "renderers/methods/ssdo_lighting.frag";

}  // namespace occlab
