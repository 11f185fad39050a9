#pragma once

#include <functional>
#include <string>
#include <vector>

#include "harness/cells.h"
#include "harness/config.h"
#include "harness/store.h"

namespace occlab {

/// A cell and the name of what determines it.
struct KeyedCell {
  PlannedCell planned;
  CellKey key;
};

/// The weighted mean of two independent estimates of one image, from `rays_a` and `rays_b` rays a
/// pixel: weights in proportion to the rays for every layer, their squares for
/// `radiance_variance`; `mask` is that of `a`. Both have the same layers.
Layers merge_references(const Layers& a, long rays_a, const Layers& b, long rays_b);

/// A reference that grows: parts of its own seeds and rays are rendered one after the other, each a
/// cell, and the mean of the first n is a cell too. Nothing that was traced is lost.
class ReferenceChain {
 public:
  /// Reads a cell, rendering it where it is missing or damaged.
  using ReadPart = std::function<Layers(const KeyedCell&)>;

  /// What the EXR of a mean says of itself.
  using Describe = std::function<Metadata(const PlannedCell&, const Metadata& facts)>;

  ReferenceChain(BenchFacts bench, CellStore& store, KeyedCell first, ReadPart read,
                 Describe describe);

  /// Plans another part of that many rays a pixel.
  void extend(long rays_per_pixel);
  /// Rays a pixel of each part, the first included.
  const std::vector<long>& parts() const { return rays_; }
  long rays_per_pixel() const;

  /// The mean of all parts as a cell, with all its rays; the first part itself while it is alone.
  const KeyedCell& mean() const { return means_.back(); }
  /// All other cells: the parts and the means of fewer. None while the first part is alone.
  std::vector<KeyedCell> steps() const;
  /// Whether the mean is in the store.
  bool finished() const { return store_.has(mean().key); }
  /// Its layers; what is missing is rendered and stored.
  Layers read() { return read(means_.size() - 1); }

 private:
  Layers read(std::size_t index);

  BenchFacts bench_;
  CellStore& store_;
  ReadPart read_part_;
  Describe describe_;
  std::vector<KeyedCell> parts_;
  std::vector<KeyedCell> means_;  ///< means_[i] is of parts_[0] to parts_[i]
  std::vector<long> rays_;
};

}  // namespace occlab
