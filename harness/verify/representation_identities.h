#pragma once

#include "harness/verify/layer_agreement.h"

namespace occlab {

// What the representations must be of one another and of the visibility they are made from: exact
// but for the rounding of floats. Computed on the CPU, per pixel, with the parameters' samples,
// visibility source and weight; `parameters` are those of any screen-space method.

/// The identities' layers. With V and the N directions s of each pixel, measured against expected:
///   - `s3ho_radiance`: L_o = (rho/pi) c . c[Lin], not clamped, against
///     (rho/pi)(2 pi/N) sum V L4(s) (n.s), L4 being the order-4 reconstruction of the light: the
///     probe's, and every punctual light's windowed lobe [S3HO eq. 2 to 4];
///   - `s3ho_ambient_occlusion`: (2/sqrt pi) c_0 against SSAO's k_A;
///   - `ssbn_bent_normal`, `ssbn_uniform_occlusion`: against sum V s / sum V and sum V / N;
///   - `ssdo_irradiance`: E under a constant probe L, no lights, against pi k_A L.
/// The sums that are expected are of doubles. Bounds: half a float's last place, 2^-24, for every
/// operation that a term of the measured sum goes through, times the sum of the terms' magnitudes.
LayerAgreement representation_identities(const Frame& frame, const ParameterSet& parameters);

}  // namespace occlab
