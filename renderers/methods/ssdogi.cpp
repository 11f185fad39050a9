#include <algorithm>
#include <iterator>

#include "renderers/methods/bounce.h"
#include "renderers/methods/screen_space.h"
#include "renderers/methods/ssdo.h"

namespace occlab {
namespace {

using Values = Bounce::Values;

constexpr Bounce sent_light = {
    .channels = 3,
    .reads_lit = true,
    .accumulate =
        [](Values& sums, const Sender& sender, float factor) {
          for (std::size_t c = 0; c < 3; ++c) sums[c] += factor * sender.lit[int(c)];
        },
    .irradiance = [](const Values& E, const ShadedPoint&,
                     const CpuLighting&) { return glm::vec3(E[0], E[1], E[2]); },
};

const Representation& representation() {
  static const Representation with_bounce = [] {
    Representation made = ssdo_representation();
    made.bounce = &sent_light;
    return made;
  }();
  return with_bounce;
}

/// Senders are pixels of the lit framebuffer: what only a ray meets has none.
std::vector<Parameter> parameters() {
  std::vector<Parameter> all = screen_space_parameters();
  Parameter& visibility = *std::ranges::find(all, "visibility", &Parameter::name);
  std::erase(visibility.choices, "traced");
  visibility.help =
      "what tells whether a direction is blocked: the march through the depth buffer, through "
      "several layers of it, or through those of several cameras [SSDO sec. 4]; their pixels are "
      "what sends light";
  std::ranges::move(bounce_parameters("patch"), std::back_inserter(all));
  return all;
}

}  // namespace

MethodInfo ssdogi() {
  const ScreenSpacePasses passes{
      .occlusion_shader = "renderers/methods/ssdo.frag",
      .lighting_shader = "renderers/methods/ssdo_lighting.frag",
      .representation_formats = {GL_RGBA32F},
      .representation = &representation(),
      .off_screen_shader = {},
      .direct_lighting_shader = "renderers/methods/ssdo_lighting.frag",
      .bounce_shader = "renderers/methods/ssdogi_bounce.frag",
  };
  return screen_space_method(
      {.name = "ssdogi",
       .title = "SSDO + 1 bounce",
       .paper = "Ritschel, Grosch, Seidel 2009, section 3",
       .parameters = parameters(),
       .layers = {"irradiance", "radiance_indirect", "radiance_indirect_unfiltered"},
       .truth = "rtgi_shaded"},
      passes);
}

}  // namespace occlab
