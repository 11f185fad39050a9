#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace occlab {

/// The directions and march offsets that every screen-space method shares: one set of N directions,
/// turned about the normal 16 ways for a 4x4 interleaved pattern [Keller and Heidrich 2001]. A
/// pixel's set is (x & 3) + 4 (y & 3).
///
/// Heights are stratified, z_i = (i + 1/2)/N, so that sum z = N/2 and an open plane has an ambient
/// occlusion of exactly 1; azimuths are a golden-ratio sequence. A seed draws the azimuths' shift,
/// the order of the 16 turns and the march offsets: over seeds every azimuth and every offset is
/// uniform.
struct SampleSet {
  /// xyz: unit direction in the tangent frame (z along the normal); w: march offset in [0, 1).
  std::vector<glm::vec4> directions;
  /// cos and sin of the set's turn; z: added to the march offsets, modulo 1.
  std::array<glm::vec4, 16> sets;
};

SampleSet make_sample_set(int sample_count, std::uint64_t seed);

}  // namespace occlab
