#pragma once

#include <string>

namespace occlab {

/// GLSL that declares `sample_direction[N]` as constants, where that pays: loops over them unroll,
/// and products with them are folded. Otherwise `#define SAMPLES_IN_BUFFER`, and the shader
/// declares them in a uniform buffer (screen_space.glsl). Either way the values are the same.
std::string sample_constants(int samples, int steps);

/// Whether sample_constants() leaves them to the buffer.
bool samples_in_buffer(int samples, int steps);

/// GLSL of
///     void project_visibility(uint visible[(N + 31) / 32], out vec4 c0, ..., out vec4 c3),
/// c_i = (4 pi / (2 N)) sum_j V_j y_i(s_j) s_j.z [S3HO eq. 2] over the directions of the sample set
/// in its own frame, V_j being bit j. The products are constants; directions of a ring share
/// theirs, up to a sign, and so need one for each sum or difference of their bits.
std::string sh_projection(int samples);

}  // namespace occlab
