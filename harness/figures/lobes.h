#pragma once

#include "renderers/scene/image.h"
#include "renderers/shared/sh.h"

namespace occlab {

// Functions on the sphere, drawn on the CPU as the S3HO paper's Figures 3 to 5 have them: seen
// along -Z from +Z, +X to the right and +Y up, which in view space is as the camera sees them.
// Images are square, display-referred, three channels, on white paper. Throw InputError for a size
// below 16 and a reach or white that is not above 0.

/// The largest |f(d)| over 4096 directions, evenly spread.
double lobe_reach(const Sh4& f);

/// The surface whose distance from the middle is |f(d)|: red where f is positive, blue where it is
/// negative, shaded. `reach` is the distance that the grey circle stands for, 5% within the image's
/// edge; one reach for several lobes makes them comparable.
Image draw_lobe(const Sh4& f, double reach, int size);

/// The same of three functions, those of red, green and blue: the surface's distance is the largest
/// |f(d)| of them, its colour their positive parts over the largest of them.
Image draw_colour_lobe(const ShRgb& f, double reach, int size);
double colour_lobe_reach(const ShRgb& f);

/// A sphere with, at every point, the light that comes from there: its radiance over `white`,
/// clamped to [0, 1] and sRGB-encoded.
Image draw_light_sphere(const ShRgb& light, double white, int size);

/// The largest channel of the light over 4096 directions.
double light_reach(const ShRgb& light);

}  // namespace occlab
