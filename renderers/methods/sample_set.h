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
/// Directions and offsets depend on N alone, so that shaders hold them as constants. They come in
/// rings of one height, evenly spaced in azimuth; heights are stratified and weighted so that
/// sum z = N/2, and an open plane has an ambient occlusion of exactly 1; rings are turned against
/// each other by the golden ratio. A seed draws the 16 turns, over what the rings need to come back
/// to themselves, and the shifts of the march offsets, each stratified, and their order: over seeds
/// the azimuths of every ring and every offset are uniform.
struct SampleSet {
  /// xyz: unit direction in the tangent frame (z along the normal); w: march offset in [0, 1).
  std::vector<glm::vec4> directions;
  /// cos and sin of the set's turn; z: added to the march offsets, modulo 1.
  std::array<glm::vec4, 16> sets;
};

SampleSet make_sample_set(int sample_count, std::uint64_t seed);

/// Directions of one height, one after the other in a set: of `count` directions, direction k is at
/// the azimuth of the first plus k/count turns.
struct SampleRing {
  int first;
  int count;
};
/// The rings of a set of N directions. Of 16 directions each has 2, of 32 it has 4, which leaves at
/// least 8 heights: S3HO's projection needs fewer products for them, and its error is no larger. Of
/// fewer or more directions, each has a height of its own. The last ring has what is left.
std::vector<SampleRing> sample_rings(int sample_count);

}  // namespace occlab
