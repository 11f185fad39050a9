#include "renderers/trace/tile_visibility.h"

namespace occlab {
namespace {

constexpr float miss = std::numeric_limits<float>::infinity();
/// Deeper than Embree's builder makes a tree.
constexpr int stack_size = 64;

/// Eight rays of a tile, and how far each is still of interest: to its nearest hit, below 0 if it
/// is settled.
class HalfPacket {
 public:
  HalfPacket(const TriangleTree& tree, const Lanes3& origin, const Lanes3& direction, int half,
             Float8 limit, bool any_hit)
      : ox_(load8(origin.x, half)),
        oy_(load8(origin.y, half)),
        oz_(load8(origin.z, half)),
        dx_(load8(direction.x, half)),
        dy_(load8(direction.y, half)),
        dz_(load8(direction.z, half)),
        ix_(inverse(dx_)),
        iy_(inverse(dy_)),
        iz_(inverse(dz_)),
        limit_(limit),
        nearest_(all8(miss)),
        tree_(tree),
        any_hit_(any_hit) {}

  void test(TileCandidates::Entry entry) {
    if (entry.node) {
      traverse(entry.index);
    } else {
      test(tree_.triangles()[entry.index]);
    }
  }

  bool settled() const { return _mm256_movemask_ps(limit_) == 0xff; }
  Float8 nearest() const { return nearest_; }

 private:
  static Float8 inverse(Float8 d) {
    const Float8 least = d < 0.0f ? all8(-1e-18f) : all8(1e-18f);
    return 1.0f / (abs8(d) > 1e-18f ? d : least);
  }

  /// Slabs [Kay and Kajiya 1986]; the far end is widened by more than the rounding.
  bool meets(const TriangleTree::Node& node) const {
    const Float8 x0 = (node.lower.x - ox_) * ix_;
    const Float8 x1 = (node.upper.x - ox_) * ix_;
    const Float8 y0 = (node.lower.y - oy_) * iy_;
    const Float8 y1 = (node.upper.y - oy_) * iy_;
    const Float8 z0 = (node.lower.z - oz_) * iz_;
    const Float8 z1 = (node.upper.z - oz_) * iz_;
    const __m256 near = _mm256_max_ps(_mm256_max_ps(_mm256_min_ps(x0, x1), _mm256_min_ps(y0, y1)),
                                      _mm256_max_ps(_mm256_min_ps(z0, z1), _mm256_setzero_ps()));
    const __m256 far = _mm256_min_ps(_mm256_min_ps(_mm256_max_ps(x0, x1), _mm256_max_ps(y0, y1)),
                                     _mm256_min_ps(_mm256_max_ps(z0, z1), limit_));
    const Float8 wide = Float8(far) * 1.000001f;
    return _mm256_movemask_ps(_mm256_cmp_ps(near, wide, _CMP_LE_OQ)) != 0;
  }

  void traverse(std::uint32_t root) {
    std::array<std::uint32_t, stack_size> stack;
    int depth = 0;
    stack[0] = root;
    while (depth >= 0) {
      const std::uint32_t index = stack[std::size_t(depth--)];
      const TriangleTree::Node& node = tree_.nodes()[index];
      if (!meets(node)) continue;
      if (!node.leaf) {
        stack[std::size_t(++depth)] = node.link;
        stack[std::size_t(++depth)] = index + 1;
        continue;
      }
      for (std::uint32_t i = 0; i < node.count; ++i) test(tree_.triangles()[node.link + i]);
      if (settled()) return;
    }
  }

  /// [Moeller and Trumbore 1997], not divided by the determinant before it is a hit.
  void test(const TriangleTree::Triangle& t) {
    const glm::vec3 normal = t.normal();
    const Float8 px = ox_ - t.corner.x;
    const Float8 py = oy_ - t.corner.y;
    const Float8 pz = oz_ - t.corner.z;
    const Float8 rx = py * dz_ - pz * dy_;
    const Float8 ry = pz * dx_ - px * dz_;
    const Float8 rz = px * dy_ - py * dx_;
    const Float8 determinant = -(normal.x * dx_ + normal.y * dy_ + normal.z * dz_);
    const Float8 sign = determinant < 0.0f ? all8(-1.0f) : all8(1.0f);
    const Float8 size = sign * determinant;
    const Float8 u = sign * (t.edge2.x * rx + t.edge2.y * ry + t.edge2.z * rz);
    const Float8 v = -sign * (t.edge1.x * rx + t.edge1.y * ry + t.edge1.z * rz);
    const Float8 height = sign * (normal.x * px + normal.y * py + normal.z * pz);
    const Int8 hit = (size > 0.0f) & (u >= 0.0f) & (v >= 0.0f) & (u + v <= size) & (height > 0.0f) &
                     (height <= limit_ * size);
    if (_mm256_testz_si256(__m256i(hit), __m256i(hit))) return;
    nearest_ = hit ? height / size : nearest_;
    limit_ = hit ? (any_hit_ ? all8(-1.0f) : nearest_) : limit_;
  }

  Float8 ox_, oy_, oz_, dx_, dy_, dz_, ix_, iy_, iz_;
  Float8 limit_;
  Float8 nearest_;
  const TriangleTree& tree_;
  bool any_hit_;
};

}  // namespace

Lanes TileVisibility::test(const LaneMask& active, const Lanes3& direction,
                           const TileCandidates::List& list) const {
  const bool binary = weight_.weight == weight_binary;
  Lanes nearest;
  for (const int half : half_lanes) {
    const Int8 asked = *reinterpret_cast<const Int8*>(&active.v[std::size_t(half)]);
    HalfPacket rays(tree_, tile_->origin, direction, half,
                    asked < 0 ? load8(reach_, half) : all8(-1.0f), binary);
    for (int k = 0; k < list.count && !rays.settled(); ++k) rays.test(list.entries[k]);
    store8(nearest, half, rays.nearest());
  }
  Lanes visible;
  for (int i = 0; i < lane_count; ++i) {
    if (nearest[i] == miss) {
      visible[i] = 1.0f;
    } else if (binary) {
      visible[i] = 0.0f;
    } else {
      visible[i] = blocked_visibility(weight_.weight, nearest[i], weight_.d_max_world,
                                      weight_.lambda_per_world, weight_.fade_start);
    }
  }
  return visible;
}

}  // namespace occlab
