#include "renderers/methods/pass_constants.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace occlab {

std::vector<Parameter> weight_parameters() {
  return of_factor(
      Factor::visibility,
      {
          choice_parameter(
              "weight", {"binary", "lambda", "smoothstep"},
              "what a blocker lets through at its distance [S3HO sec. 2.1; SSDO sec. 4]"),
          real_parameter("lambda_per_world", 1.0, 0.0, 1e6, "1/scene units",
                         "lambda of 1 - 1/(1 + lambda d); unstated in the paper"),
          real_parameter("fade_start", 0.75, 0.0, 1.0, "d_max",
                         "where smoothstep begins to let light through; unstated in the paper"),
      });
}

namespace {

std::vector<Parameter> sample_parameters() {
  return of_factor(Factor::samples, {
                                        integer_parameter("samples", 32, 1, 256, "",
                                                          "N, directions a pixel [S3HO sec. 3]"),
                                        seed_parameter("draws the sample set"),
                                    });
}

std::vector<Parameter> march_parameters() {
  std::vector<Parameter> parameters = {
      choice_parameter("visibility", {"depth", "peeled", "multiview", "traced"},
                       "what tells whether a direction is blocked: the march through the depth "
                       "buffer, through several layers of it, or through those of several cameras "
                       "[SSDO sec. 4]; or rays through the whole scene, on the CPU"),
      integer_parameter("layers", 2, 2, 8, "",
                        "peeled: depth layers, each two of which are the front and back of a solid "
                        "[SSDO sec. 4]"),
      integer_parameter("cameras", 4, 1, 8, "", "multiview: cameras beside the view's own"),
      real_parameter("camera_offset", 1.0, 1e-3, 100.0, "bounding radii",
                     "multiview: from the view's camera to the others; of the scene's bounding "
                     "sphere [SSDO sec. 4]"),
      real_parameter("camera_scale", 0.5, 0.05, 2.0, "",
                     "multiview: their width and height, as a share of the view's; unstated in the "
                     "paper [SSDO sec. 4]"),
      integer_parameter("steps", 2, 1, 64, "", "S, march steps a direction [S3HO sec. 4]"),
      real_parameter("d_max_world", 1.0, 1e-6, 1e6, "scene units",
                     "farthest blocker that counts [S3HO eq. 2]; unstated in the paper"),
      real_parameter("bias_world", 1e-3, 0.0, 1e6, "scene units",
                     "a blocker must be this much nearer to the camera than the sample"),
      real_parameter("epsilon_world", 1e-3, 0.0, 1e6, "scene units",
                     "a blocker must rise this far above the tangent plane"),
      choice_parameter("gbuffer_bits", {"32", "16"},
                       "float size of positions and normals; the paper has 16 [S3HO sec. 3]"),
  };
  // Only the CPU chooses between the sources; shaders hear of what they have to look up.
  for (std::size_t i = 0; i < 5; ++i) parameters[i].in_shaders = false;
  return of_factor(Factor::visibility, parameters);
}

std::vector<Parameter> filter_parameters() {
  return of_factor(Factor::filter,
                   {
                       choice_parameter("filter", {"bilateral", "none"},
                                        "8x8 geometry-aware filter of the representation [S3HO "
                                        "sec. 3]"),
                       real_parameter("filter_power", 32.0, 0.0, 1000.0, "",
                                      "power of the orientation weight; Klehm et al. have 5, "
                                      "which leaks 3% round a 90-degree corner"),
                       real_parameter("filter_scale", 1.0, 1e-6, 1e6, "d_max",
                                      "distance at which the distance weight is 1/4"),
                   });
}

std::vector<Parameter> lighting_parameters() {
  return of_factor(Factor::lighting,
                   {real_parameter("hanning_width", 4.0, 0.0, 100.0, "bands",
                                   "w of the Hanning window on punctual lights' SH, 0 for none; "
                                   "unstated in the paper [S3HO sec. 2.2]")});
}

}  // namespace

std::vector<Parameter> screen_space_parameters() {
  std::vector<Parameter> all;
  for (std::vector<Parameter>& part :
       std::array{sample_parameters(), march_parameters(), weight_parameters(), filter_parameters(),
                  lighting_parameters()}) {
    std::ranges::move(part, std::back_inserter(all));
  }
  return all;
}

std::vector<Parameter> bounce_parameters(const std::string& form_factor) {
  Parameter factor =
      choice_parameter("form_factor", {"solid_angle", "patch"},
                       "what a blocker's light counts for: the solid angle that its direction "
                       "stands for, or a patch "
                       "of `sender_area` [SSDO sec. 3]; the S3HO paper does not say");
  factor.default_value = form_factor;
  return of_factor(
      Factor::representation,
      {factor,
       choice_parameter("distance_clamp", {"unit", "patch_radius", "none"},
                        "least distance to a patch: 1 scene unit, as the paper has it [SSDO sec. "
                        "3], d_max/sqrt(N), or 0"),
       real_parameter("sender_area", 1.0, 0.0, 1e6, "pi d_max^2/N",
                      "A_s, the area of a patch, which scales the bounce [SSDO sec. 3]")});
}

bool filters(const ParameterSet& parameters) { return parameters.choice("filter") != "none"; }
bool traces(const ParameterSet& parameters) { return parameters.choice("visibility") == "traced"; }

GBufferBits gbuffer_bits(const ParameterSet& parameters) {
  return parameters.choice("gbuffer_bits") == "32" ? GBufferBits::float32 : GBufferBits::float16;
}

std::optional<HiddenSettings> hidden_settings(const ParameterSet& parameters) {
  const std::string& source = parameters.choice("visibility");
  HiddenSettings settings;
  settings.bits = gbuffer_bits(parameters);
  settings.complete = parameters.has("form_factor");
  if (source == "peeled") {
    settings.kind = HiddenKind::layers;
    settings.count = int(parameters.integer("layers")) - 1;
    return settings;
  }
  if (source != "multiview") return std::nullopt;
  settings.kind = HiddenKind::cameras;
  settings.count = int(parameters.integer("cameras"));
  settings.camera_offset = parameters.real32("camera_offset");
  settings.camera_scale = parameters.real32("camera_scale");
  return settings;
}

int choice_index(const ParameterSet& parameters, std::string_view name) {
  const auto parameter = std::ranges::find(parameters.declared(), name, &Parameter::name);
  const auto word = std::ranges::find(parameter->choices, parameters.choice(name));
  return int(word - parameter->choices.begin());
}

BlockerWeight blocker_weight(const ParameterSet& parameters) {
  return {.weight = choice_index(parameters, "weight"),
          .d_max_world = parameters.real32("d_max_world"),
          .lambda_per_world = parameters.real32("lambda_per_world"),
          .fade_start = parameters.real32("fade_start")};
}

PassConstants pass_constants(const ParameterSet& parameters) {
  const bool bounces = parameters.has("form_factor");
  return {.samples = int(parameters.integer("samples")),
          .steps = int(parameters.integer("steps")),
          .d_max_world = parameters.real32("d_max_world"),
          .bias_world = parameters.real32("bias_world"),
          .epsilon_world = parameters.real32("epsilon_world"),
          .blocker = blocker_weight(parameters),
          .filter_power = parameters.real32("filter_power"),
          .filter_scale = parameters.real32("filter_scale"),
          .hanning_width = parameters.real32("hanning_width"),
          .cone_angle = parameters.has("cone_angle") ? choice_index(parameters, "cone_angle") : 0,
          .form_factor = bounces ? choice_index(parameters, "form_factor") : 0,
          .distance_clamp = bounces ? choice_index(parameters, "distance_clamp") : 0,
          .sender_area = bounces ? parameters.real32("sender_area") : 0.0f};
}

int whole_filter_power(const PassConstants& constants) {
  const float power = constants.filter_power;
  return power == std::floor(power) && power < 1024.0f ? int(power) : -1;
}

}  // namespace occlab
