#include "harness/reference_chain.h"

#include <fmt/format.h>

#include <cassert>
#include <numeric>

#include "harness/cells.h"

namespace occlab {
namespace {

/// Far apart, so that no seed of a run is one of a part.
constexpr long seed_step = 7'654'321;
constexpr long seed_count = 1'000'000'001;

Image weighted_sum(const Image& a, double weight_a, const Image& b, double weight_b) {
  assert(a.values().size() == b.values().size());
  Image sum(a.width(), a.height(), a.channels());
  for (std::size_t i = 0; i < a.values().size(); ++i) {
    sum.values()[i] = float(weight_a * double(a.values()[i]) + weight_b * double(b.values()[i]));
  }
  return sum;
}

}  // namespace

Layers merge_references(const Layers& a, long rays_a, const Layers& b, long rays_b) {
  const double weight_a = double(rays_a) / double(rays_a + rays_b);
  const double weight_b = 1.0 - weight_a;
  Layers merged;
  for (const Layers::Layer& layer : a.all()) {
    if (layer.name == "mask") {
      merged.add(layer.name, layer.image);
    } else if (layer.name == "radiance_variance") {
      merged.add(layer.name, weighted_sum(layer.image, weight_a * weight_a, b.at(layer.name),
                                          weight_b * weight_b));
    } else {
      merged.add(layer.name, weighted_sum(layer.image, weight_a, b.at(layer.name), weight_b));
    }
  }
  return merged;
}

ReferenceChain::ReferenceChain(BenchFacts bench, CellStore& store, KeyedCell first, ReadPart read,
                               Describe describe)
    : bench_(std::move(bench)),
      store_(store),
      read_part_(std::move(read)),
      describe_(std::move(describe)) {
  const ParameterSet& parameters = first.planned.parameters;
  rays_.push_back(parameters.has("rays_per_pixel") ? parameters.integer("rays_per_pixel") : 0);
  parts_.push_back(first);
  means_.push_back(std::move(first));
}

void ReferenceChain::extend(long rays_per_pixel) {
  const KeyedCell& first = parts_.front();
  PlannedCell part = first.planned;
  const long seed = part.parameters.integer("seed") + seed_step * long(parts_.size());
  part.parameters.set("seed", seed % seed_count);
  part.parameters.set("rays_per_pixel", rays_per_pixel);
  CellKey part_key = cell_key(bench_, part);

  PlannedCell mean = first.planned;
  rays_.push_back(rays_per_pixel);
  mean.parameters.set("rays_per_pixel", this->rays_per_pixel());
  CellKey mean_key = cell_key(bench_, mean);
  mean_key.add("mean_of", means_.back().key.hash() + " " + part_key.hash());

  parts_.push_back({std::move(part), std::move(part_key)});
  means_.push_back({std::move(mean), std::move(mean_key)});
}

long ReferenceChain::rays_per_pixel() const {
  return std::accumulate(rays_.begin(), rays_.end(), 0L);
}

std::vector<KeyedCell> ReferenceChain::steps() const {
  if (parts_.size() == 1) return {};
  std::vector<KeyedCell> cells = parts_;
  cells.insert(cells.end(), means_.begin() + 1, means_.end() - 1);
  return cells;
}

Layers ReferenceChain::read(std::size_t index) {
  if (index == 0) return read_part_(parts_.front());
  const KeyedCell& mean = means_[index];
  ReadCell stored = store_.read(mean.key);
  if (stored.cell) return std::move(stored.cell->layers);
  if (!stored.warning.empty()) fmt::print(stderr, "occlab: {}; made again\n", stored.warning);
  const long before = std::accumulate(rays_.begin(), rays_.begin() + long(index), 0L);
  Layers merged =
      merge_references(read(index - 1), before, read_part_(parts_[index]), rays_[index]);
  const Metadata facts = {{"mean_of", means_[index - 1].key.id() + " " + parts_[index].key.id()}};
  store_.write(mean.key, merged, describe_(mean.planned, facts), nlohmann::json(facts));
  return merged;
}

}  // namespace occlab
