#include "renderers/trace/tile_visibility.h"

namespace occlab {

/// Nearest hits with the listed triangles [Moeller and Trumbore 1997], determinant not divided by.
Lanes TileVisibility::test(const Lanes3& direction, const TileCandidates::List& list) const {
  constexpr float miss = std::numeric_limits<float>::infinity();
  const float reach = weight_.d_max_world;
  Lanes nearest;
  for (const int half : half_lanes) {
    const Float8 ox = load8(tile_->origin.x, half);
    const Float8 oy = load8(tile_->origin.y, half);
    const Float8 oz = load8(tile_->origin.z, half);
    const Float8 dx = load8(direction.x, half);
    const Float8 dy = load8(direction.y, half);
    const Float8 dz = load8(direction.z, half);
    Float8 found = all8(miss);
    for (int k = 0; k < list.count; ++k) {
      const TileCandidates::Triangle& t = candidates_.triangle(list.triangles[k]);
      const Float8 px = ox - t.corner.x;
      const Float8 py = oy - t.corner.y;
      const Float8 pz = oz - t.corner.z;
      const Float8 rx = py * dz - pz * dy;
      const Float8 ry = pz * dx - px * dz;
      const Float8 rz = px * dy - py * dx;
      const Float8 determinant = -(t.normal.x * dx + t.normal.y * dy + t.normal.z * dz);
      const Float8 sign = determinant < 0.0f ? all8(-1.0f) : all8(1.0f);
      const Float8 size = sign * determinant;
      const Float8 u = sign * (t.edge2.x * rx + t.edge2.y * ry + t.edge2.z * rz);
      const Float8 v = -sign * (t.edge1.x * rx + t.edge1.y * ry + t.edge1.z * rz);
      const Float8 height = sign * (t.normal.x * px + t.normal.y * py + t.normal.z * pz);
      const Int8 hit = (size > 0.0f) & (u >= 0.0f) & (v >= 0.0f) & (u + v <= size) &
                       (height > 0.0f) & (height <= reach * size);
      const Float8 distance = hit ? height / size : all8(miss);
      found = distance < found ? distance : found;
    }
    store8(nearest, half, found);
  }
  Lanes visible;
  for (int i = 0; i < lane_count; ++i) {
    if (nearest[i] == miss) {
      visible[i] = 1.0f;
    } else if (weight_.weight == weight_binary) {
      visible[i] = 0.0f;
    } else {
      visible[i] = blocked_visibility(weight_.weight, nearest[i], weight_.d_max_world,
                                      weight_.lambda_per_world, weight_.fade_start);
    }
  }
  return visible;
}

}  // namespace occlab
