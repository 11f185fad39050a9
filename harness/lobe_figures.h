#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "harness/config.h"
#include "harness/figures/colour_maps.h"
#include "renderers/scene/image_io.h"

namespace occlab {

/// What a figure of lobes is drawn of.
struct LobeSource {
  const Experiment& experiment;
  const PlannedCell& cell;
  const Layers& layers;  ///< of the cell: `radiance` and `sh_visibility`
  const Image& mask;
  double exposure = 1.0;
  DisplayColour colour = {};
};

struct DrawnLobes {
  Image image;
  nlohmann::json
      numbers;  ///< of the points: coefficients, irradiance, and how well relighting fits
};

/// Figs. 3 and 5 of the S3HO paper: the picture with one or two points marked, their visibility
/// coefficients as lobes, the incoming light as a sphere, and, where two lights change their
/// places, the picture under the other light. That is not rendered again: S3HO keeps visibility
/// apart from light, so the stored coefficients are lit by other ones, E = c[Lin] . c[S3HO] (its
/// eq. 3).
///
/// Before, the same is done with the lights as they are, which must give the stored picture: an RMS
/// difference of more than 1% of its mean luminance is an InputError. So are lights at points,
/// whose direction varies, lights that the scene does not have, and, where the picture is to be lit
/// again, surfaces of several albedos.
DrawnLobes draw_lobes(const FigureSettings& settings, const LobeSource& source);

}  // namespace occlab
