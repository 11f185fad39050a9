#pragma once

#include "renderers/methods/screen_space.h"

namespace occlab {

// What S3HO and S3HOGI share.

/// Visibility times the cosine lobe as 16 SH coefficients [S3HO eq. 2].
const Representation& s3ho_representation();

/// screen_space_parameters() and `projection`.
std::vector<Parameter> s3ho_parameters();

/// GLSL before s3ho_sampling.glsl.
std::string s3ho_preamble(const ParameterSet& parameters);

/// Says which way the projection went.
void add_s3ho_facts(const ParameterSet& parameters, Metadata& facts);

}  // namespace occlab
