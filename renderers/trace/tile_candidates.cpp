#include "renderers/trace/tile_candidates.h"

#include <immintrin.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "renderers/shared/glsl.h"

namespace occlab {
namespace {

/// Balls of triangles that are seen within this angle are not looked at more closely.
constexpr float narrow_cosine = 0.7f;
/// Of half the angle between two pixels' frames: with more, cells would tell little.
constexpr float max_half_sine = 0.25f;
/// Added to every cell's angle, rad: rounding, and what the sampled outlines miss.
constexpr double cell_margin = 2e-3;
static_assert(tangent_cells % 8 == 0 && cube_cells % 8 == 0);

glm::dvec3 tangent_direction(double u, double v) {
  const double phi = 2.0 * double(pi) * v;
  return {std::sqrt(u) * std::cos(phi), std::sqrt(u) * std::sin(phi), std::sqrt(1.0 - u)};
}

glm::dvec3 cube_direction(int face, double s, double t) {
  const int axis = face / 2;
  glm::dvec3 d;
  d[axis] = face % 2 ? -1.0 : 1.0;
  d[(axis + 1) % 3] = s;
  d[(axis + 2) % 3] = t;
  return normalize(d);
}

/// The cone about the middle of a cell of which `direction` maps [0, 1]^2 to directions.
template <typename Direction>
glm::dvec4 cone_of_cell(const Direction& direction) {
  const glm::dvec3 axis = direction(0.5, 0.5);
  double angle = 0.0;
  constexpr int steps = 16;
  for (int j = 0; j <= steps; ++j) {
    for (int i = 0; i <= steps; ++i) {
      const glm::dvec3 d = direction(double(i) / steps, double(j) / steps);
      angle = std::max(angle, std::acos(std::clamp(dot(axis, d), -1.0, 1.0)));
    }
  }
  return {axis, angle + cell_margin};
}

}  // namespace

int tangent_cell(const glm::vec3& d) {
  const float u = std::min(d.x * d.x + d.y * d.y, 0.999999f);
  const float turns = std::atan2(d.y, d.x) / (2.0f * pi);
  return tangent_cell(u, std::min(turns < 0.0f ? turns + 1.0f : turns, 0.999999f));
}

int cube_cell(const glm::vec3& d) {
  const glm::vec3 size = abs(d);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto column = [&](int other) {
    const float s = 0.5f + 0.5f * d[other] / size[axis];
    return std::clamp(int(s * cube_cells_across), 0, cube_cells_across - 1);
  };
  const int face = 2 * axis + (d[axis] < 0.0f ? 1 : 0);
  return tangent_cells + (face * cube_cells_across + column((axis + 2) % 3)) * cube_cells_across +
         column((axis + 1) % 3);
}

DirectionCones local_cones() {
  DirectionCones cones;
  const auto set = [&](int cell, const glm::dvec4& cone) {
    const auto c = std::size_t(cell);
    cones.x[c] = float(cone.x);
    cones.y[c] = float(cone.y);
    cones.z[c] = float(cone.z);
    cones.cosine[c] = float(std::cos(cone.w));
    cones.sine[c] = float(std::sin(cone.w));
  };
  for (int cell = 0; cell < tangent_cells; ++cell) {
    const int ring = cell / tangent_sectors;
    const int sector = cell % tangent_sectors;
    set(cell, cone_of_cell([&](double s, double t) {
          return tangent_direction((ring + s) / tangent_rings, (sector + t) / tangent_sectors);
        }));
  }
  for (int cell = 0; cell < cube_cells; ++cell) {
    const int column = cell % cube_cells_across;
    const int row = cell / cube_cells_across % cube_cells_across;
    const int face = cell / (cube_cells_across * cube_cells_across);
    set(tangent_cells + cell, cone_of_cell([&](double s, double t) {
          return cube_direction(face, 2.0 * (column + s) / cube_cells_across - 1.0,
                                2.0 * (row + t) / cube_cells_across - 1.0);
        }));
  }
  return cones;
}

TileCandidates::TileCandidates(const TriangleTree& tree)
    : tree_(tree), lists_(std::size_t(direction_cells) * list_capacity) {
  static const DirectionCones cones = local_cones();
  local_ = &cones;
  world_ = cones;
  const TriangleTree::Node& root = tree.nodes().front();
  scene_center_ = 0.5f * (root.lower + root.upper);
  scene_radius_ = 0.5f * length(root.upper - root.lower);
}

/// False if the pixels differ so much that cells would tell little.
bool TileCandidates::set_tile(const TileFrame& tile, float reach, float tolerance) {
  glm::vec3 lower(std::numeric_limits<float>::infinity());
  glm::vec3 upper(-lower);
  int middle = -1;  // the active lane nearest the tile's middle
  for (const int lane : {5, 6, 9, 10, 1, 2, 4, 7, 8, 11, 13, 14, 0, 3, 12, 15}) {
    if (!tile.active[lane]) continue;
    if (middle < 0) middle = lane;
    lower = min(lower, at(tile.origin, lane));
    upper = max(upper, at(tile.origin, lane));
  }
  center_ = 0.5f * (lower + upper);
  normal_ = at(tile.normal, middle);
  const glm::mat3 frame(at(tile.tangent, middle), at(tile.bitangent, middle), normal_);
  radius_ = 0.0f;
  float turn = 0.0f;  // largest squared Frobenius distance of two frames
  spread_ = 0.0f;
  float lowest = -std::numeric_limits<float>::infinity();
  for (int i = 0; i < lane_count; ++i) {
    if (!tile.active[i]) continue;
    const glm::vec3 n = at(tile.normal, i);
    const glm::vec3 t = at(tile.tangent, i) - frame[0];
    const glm::vec3 b = at(tile.bitangent, i) - frame[1];
    turn = std::max(turn, dot(t, t) + dot(b, b) + dot(n - normal_, n - normal_));
    spread_ = std::max(spread_, length(n - normal_));
    radius_ = std::max(radius_, length(at(tile.origin, i) - center_));
    lowest = std::max(lowest, dot(center_ - at(tile.origin, i), n));
  }
  radius_ += tolerance;
  reach_ = std::min(reach, length(center_ - scene_center_) + scene_radius_ + radius_);
  // |dot(x - c, n_i) - dot(x - c, n)| <= |x - c| |n_i - n|, and hits are no farther than that.
  horizon_ = lowest + (reach_ + radius_) * spread_ + tolerance;
  // Two rotations that differ by the angle a have a Frobenius distance of sqrt(8) sin(a/2).
  const float half_sine = std::sqrt(turn / 8.0f) + 1e-6f;
  if (half_sine > max_half_sine) return false;
  const float half_cosine = std::sqrt(1.0f - half_sine * half_sine);
  const float sine = 2.0f * half_sine * half_cosine;
  const float cosine = 1.0f - 2.0f * half_sine * half_sine;
  for (std::size_t c = 0; c < tangent_cells; ++c) {
    world_.x[c] = frame[0].x * local_->x[c] + frame[1].x * local_->y[c] + frame[2].x * local_->z[c];
    world_.y[c] = frame[0].y * local_->x[c] + frame[1].y * local_->y[c] + frame[2].y * local_->z[c];
    world_.z[c] = frame[0].z * local_->x[c] + frame[1].z * local_->y[c] + frame[2].z * local_->z[c];
    world_.cosine[c] = local_->cosine[c] * cosine - local_->sine[c] * sine;
    world_.sine[c] = local_->sine[c] * cosine + local_->cosine[c] * sine;
  }
  return true;
}

namespace {

/// A cap, ready to be compared with eight cells at a time.
struct WideCap {
  __m256 x, y, z, cosine, sine;

  WideCap(const glm::vec3& axis, float cap_cosine, float cap_sine)
      : x(_mm256_set1_ps(axis.x)),
        y(_mm256_set1_ps(axis.y)),
        z(_mm256_set1_ps(axis.z)),
        cosine(_mm256_set1_ps(cap_cosine)),
        sine(_mm256_set1_ps(cap_sine)) {}

  /// Which of the eight cells from `c` on have directions within the cap.
  __m256 meets(const DirectionCones& cells, std::size_t c) const {
    const __m256 along =
        _mm256_fmadd_ps(x, _mm256_load_ps(&cells.x[c]),
                        _mm256_fmadd_ps(y, _mm256_load_ps(&cells.y[c]),
                                        _mm256_mul_ps(z, _mm256_load_ps(&cells.z[c]))));
    // cos(a + b), of the cap's and the cell's angle.
    const __m256 least = _mm256_fmsub_ps(cosine, _mm256_load_ps(&cells.cosine[c]),
                                         _mm256_mul_ps(sine, _mm256_load_ps(&cells.sine[c])));
    return _mm256_cmp_ps(along, least, _CMP_GE_OQ);
  }
};

}  // namespace

/// Drops the cells none of whose directions are within the caps.
template <typename... Caps>
void TileCandidates::restrict(CellMask& mask, const Caps&... caps) const {
  const auto drop = [&](const auto&... wide) {
    for (std::size_t w = first_cell_ / 64; w * 64 < last_cell_; ++w) {
      if (mask[w] == 0) continue;
      std::uint64_t meeting = 0;
      for (std::size_t bit = 0; bit < 64 && w * 64 + bit < direction_cells; bit += 8) {
        __m256 meets = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
        ((meets = _mm256_and_ps(meets, wide.meets(world_, w * 64 + bit))), ...);
        meeting |= std::uint64_t(unsigned(_mm256_movemask_ps(meets))) << bit;
      }
      mask[w] &= meeting;
    }
  };
  drop(WideCap(caps.axis, caps.cosine, caps.sine)...);
}

TileCandidates::CellMask TileCandidates::cells_above_horizon() const {
  CellMask mask{};
  for (std::size_t c = first_cell_; c < last_cell_; ++c) {
    mask[c / 64] |= std::uint64_t(1) << (c % 64);
  }
  // The directions of the cube's cells that are above no horizon are never asked for.
  const float sine = spread_;
  restrict(mask, Cap{normal_, -sine, std::sqrt(std::max(1.0f - sine * sine, 0.0f))});
  return mask;
}

int TileCandidates::count(const CellMask& mask) const {
  int sum = 0;
  for (const std::uint64_t word : mask) sum += std::popcount(word);
  return sum;
}

/// Whether nothing within `extent`, measured along the normal, of the point is above a horizon.
bool TileCandidates::below_horizon(const glm::vec3& offset, float extent) const {
  return dot(offset, normal_) + extent < -horizon_;
}

/// Directions from the origins to a ball at `offset` from their centre.
TileCandidates::Cap TileCandidates::cap_of_ball(const glm::vec3& offset, float distance,
                                                float radius) const {
  const float reached = radius + radius_;
  if (distance <= reached) return {};
  const float sine = reached / distance;
  return {offset / distance, std::sqrt(1.0f - sine * sine), sine};
}

void TileCandidates::mark_many(const CellMask& mask) {
  for (std::size_t w = 0; w < words; ++w) many_[w] |= mask[w];
}

/// Drops the cells that are full; whether any is left.
bool TileCandidates::open(CellMask& mask) const {
  std::uint64_t any = 0;
  for (std::size_t w = 0; w < words; ++w) {
    mask[w] &= ~many_[w];
    any |= mask[w];
  }
  return any != 0;
}

void TileCandidates::add_triangle(std::uint32_t index, CellMask mask) {
  const TriangleTree::Triangle& triangle = tree_.triangles()[index];
  const glm::vec3 a = triangle.corner - center_;
  const glm::vec3 b = a + triangle.edge1;
  const glm::vec3 c = a + triangle.edge2;
  if (std::max({dot(a, normal_), dot(b, normal_), dot(c, normal_)}) < -horizon_) return;

  const glm::vec3 normal = triangle.normal();
  const float size = length(normal);
  if (!(size > 0.0f)) return;
  Cap plane;
  const glm::vec3 nearest = max(max(min(a, min(b, c)), -max(a, max(b, c))), glm::vec3(0.0f));
  float distance = length(nearest);
  const float height = std::fabs(dot(a, normal)) / size;
  distance = std::max(distance, height);
  // Rays have to descend to the triangle's plane, by height - radius at least.
  const float descent = (height - radius_) / reach_;
  if (descent > 1.0f) return;
  if (descent > 0.0f) {
    const glm::vec3 towards = (dot(a, normal) > 0.0f ? normal : -normal) / size;
    plane = {towards, descent, std::sqrt(1.0f - descent * descent)};
  }
  if (distance > reach_ + radius_) return;
  // The triangle is within the cap about its middle that holds its corners, if that is less than a
  // half space; seen from the other origins, within asin(radius/distance) of it.
  const glm::vec3 axis = normalize(a + b + c);
  const float cap =
      std::min({dot(axis, normalize(a)), dot(axis, normalize(b)), dot(axis, normalize(c))});
  Cap outline;
  if (distance > radius_ && cap > 0.0f) {
    const float cap_sine = std::sqrt(std::max(1.0f - cap * cap, 0.0f));
    const float shift = radius_ / distance;
    const float shift_cosine = std::sqrt(1.0f - shift * shift);
    const float cosine = cap * shift_cosine - cap_sine * shift;
    if (cosine > 0.2f) outline = {axis, cosine, cap_sine * shift_cosine + cap * shift};
  }
  restrict(mask, plane, outline);
  list({index & 0x7fffffffu, 0}, mask);
}

void TileCandidates::list(Entry entry, CellMask mask) {
  if (!open(mask)) return;
  for (std::size_t w = 0; w < words; ++w) {
    for (std::uint64_t rest = mask[w]; rest; rest &= rest - 1) {
      const int bit = std::countr_zero(rest);
      const std::size_t cell = w * 64 + std::size_t(bit);
      if (counts_[cell] < list_capacity) {
        lists_[cell * list_capacity + std::size_t(counts_[cell])] = entry;
      } else {
        many_[w] |= std::uint64_t(1) << bit;
      }
      ++counts_[cell];
    }
  }
}

void TileCandidates::visit(std::uint32_t index, CellMask mask) {
  const TriangleTree::Node& node = tree_.nodes()[index];
  const glm::vec3 offset = 0.5f * (node.lower + node.upper) - center_;
  const glm::vec3 half = 0.5f * (node.upper - node.lower);
  const glm::vec3 gap = max(abs(offset) - half, glm::vec3(0.0f));
  const float farthest = reach_ + radius_;
  if (dot(gap, gap) > farthest * farthest) return;
  if (below_horizon(offset, dot(half, abs(normal_)))) return;
  const float distance = length(offset);
  const Cap cap = cap_of_ball(offset, distance, length(half));
  if (cap.cosine > 0.5f) restrict(mask, cap);  // wider ones tell little
  if (!open(mask)) return;
  // Not looked at more closely: their rays will be.
  if (cap.cosine > narrow_cosine) {
    return node.masked ? mark_many(mask) : list({index & 0x7fffffffu, 1}, mask);
  }
  if (node.leaf) {
    if (node.masked) return mark_many(mask);  // Embree asks the masks
    for (std::uint32_t i = 0; i < node.count; ++i) add_triangle(node.link + i, mask);
    return;
  }
  stack_.push_back({node.link, mask});
  stack_.push_back({index + 1, mask});
}

void TileCandidates::fill(const TileFrame& tile, float reach, float tolerance, CellKinds kinds,
                          int budget) {
  counts_.fill(0);
  many_.fill(0);
  stack_.clear();
  first_cell_ = kinds == CellKinds::cube ? tangent_cells : 0;
  last_cell_ = kinds == CellKinds::tangent ? tangent_cells : direction_cells;
  if (!set_tile(tile, reach, tolerance)) return many_.fill(~std::uint64_t(0));
  const CellMask asked = cells_above_horizon();
  // With most cells full, the rest would not repay the work.
  const int hopeless = count(asked) * 3 / 4;
  stack_.push_back({0, asked});
  for (int visits = 0; !stack_.empty(); ++visits) {
    if (visits == budget || (visits % 32 == 31 && count(many_) > hopeless)) break;
    const Visit next = stack_.back();
    stack_.pop_back();
    visit(next.node, next.mask);
  }
  for (const Visit& rest : stack_) mark_many(rest.mask);
}

}  // namespace occlab
