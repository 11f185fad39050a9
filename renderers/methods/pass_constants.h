#pragma once

#include <optional>
#include <vector>

#include "renderers/gl/hidden_surfaces.h"
#include "renderers/methods/parameters.h"
#include "renderers/trace/packet_visibility.h"

namespace occlab {

/// `weight` and its two constants: what a blocker lets through at its distance
/// (shared/visibility.h). The screen-space methods and the reference declare the same ones.
std::vector<Parameter> weight_parameters();

/// The parameters of sampling, visibility, G-buffer, filter and lighting that all screen-space
/// methods share.
std::vector<Parameter> screen_space_parameters();

/// What a blocker's light counts for in a bounce (shared/bounce.h); `form_factor` is the default.
std::vector<Parameter> bounce_parameters(const std::string& form_factor);

/// weight_parameters() and d_max_world, for code that runs per ray on the CPU.
BlockerWeight blocker_weight(const ParameterSet& parameters);

/// The values of screen_space_parameters(), for code that runs per pixel on the CPU; the shaders
/// have theirs as uniforms and constants.
struct PassConstants {
  int samples = 0;  ///< N
  int steps = 0;    ///< S
  float d_max_world = 0.0f;
  float bias_world = 0.0f;
  float epsilon_world = 0.0f;
  BlockerWeight blocker;
  float filter_power = 0.0f;
  float filter_scale = 0.0f;
  float hanning_width = 0.0f;
  int cone_angle = 0;  ///< shared/representation_bent_cone.h; 0 where a method does not declare it
  /// bounce_parameters(), where a method declares them.
  int form_factor = 0;
  int distance_clamp = 0;
  float sender_area = 0.0f;
};
PassConstants pass_constants(const ParameterSet& parameters);

/// The filter's power if it is a whole number that whole_power() of shared/filter.h takes, else -1.
int whole_filter_power(const PassConstants& constants);

/// Whether the representation is filtered, and whether its visibility is traced.
bool filters(const ParameterSet& parameters);
bool traces(const ParameterSet& parameters);

/// The G-buffer that the parameters ask for (`gbuffer_bits`).
GBufferBits gbuffer_bits(const ParameterSet& parameters);

/// What the march has beside the first surfaces; none where `visibility` asks for nothing more.
/// Complete where there is a bounce.
std::optional<HiddenSettings> hidden_settings(const ParameterSet& parameters);

/// The index of a choice's word in the declared order, as the shaders have it.
int choice_index(const ParameterSet& parameters, std::string_view name);

}  // namespace occlab
