#pragma once

#include "renderers/scene/scene.h"

namespace occlab {

/// How many parts every edge has to be cut into so that the number of triangles, `triangles` times
/// its square, comes closest to `wanted` (in ratio). Throws InputError where the scene has more
/// triangles than are wanted.
int split_factor(std::size_t triangles, std::size_t wanted);

/// The same surfaces made of parts^2 as many triangles: every triangle becomes a grid of its own
/// shape. Positions and uvs are on the old triangles, normals are interpolated between theirs.
/// Two triangles that share an edge get the same points on it, to the last bit.
Scene split_triangles(const Scene& scene, int parts);

}  // namespace occlab
