#include "harness/report/maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "harness/metrics/colour.h"
#include "renderers/methods/failure_classes.h"

namespace occlab::report {
namespace {

/// Welford's running mean and sum of squares, pixel by pixel.
class RunningMap {
 public:
  void add(const Image& map) {
    if (mean_.empty()) {
      width_ = map.width();
      height_ = map.height();
      mean_.resize(map.pixel_count());
      squares_.resize(map.pixel_count());
    }
    ++count_;
    for (std::size_t i = 0; i < mean_.size(); ++i) {
      const double value = map.values()[i];
      const double from_old = value - mean_[i];
      mean_[i] += from_old / count_;
      squares_[i] += from_old * (value - mean_[i]);
    }
  }
  int count() const { return count_; }
  Image deviation() const {
    return make([&](std::size_t i) { return std::sqrt(squares_[i] / (count_ - 1)); });
  }
  Image mean_minus(const Image& reference) const {
    return make([&](std::size_t i) { return mean_[i] - double(reference.values()[i]); });
  }

 private:
  template <typename Value>
  Image make(const Value& value) const {
    Image map(width_, height_, 1);
    for (std::size_t i = 0; i < mean_.size(); ++i) map.values()[i] = float(value(i));
    return map;
  }

  int width_ = 0;
  int height_ = 0;
  int count_ = 0;
  std::vector<double> mean_;
  std::vector<double> squares_;
};

NamedMap difference(const std::string& name, const Image& minuend, const Image& subtrahend) {
  Image map(minuend.width(), minuend.height(), 1);
  for (std::size_t i = 0; i < map.pixel_count(); ++i) {
    map.values()[i] = minuend.values()[i] - subtrahend.values()[i];
  }
  return {name, "signed", std::move(map), ""};
}

/// The budget's name of the group ("ssbn", "ssbn_2"), "" if the budget is not of it: the parameters
/// that the fact lists are those that the budget depends on.
std::string variant_of(const NamedTexts& facts, const Group& group) {
  constexpr std::string_view prefix = "budget of ";
  for (const auto& [name, value] : facts) {
    if (!name.starts_with(prefix) || value.substr(0, value.find(' ')) != group.method) continue;
    const bool fits = std::ranges::all_of(parse_parameters(value), [&](const auto& parameter) {
      const std::string* own = find_text(group.parameters, parameter.first);
      return own && *own == parameter.second;
    });
    if (fits) return name.substr(prefix.size());
  }
  return "";
}

}  // namespace

Image relative_luminance(const Image& rgb, double mean_luminance) {
  Image map(rgb.width(), rgb.height(), 1);
  for (std::size_t i = 0; i < map.pixel_count(); ++i) {
    const auto c = rgb.values().subspan(3 * i, 3);
    map.values()[i] = float(luminance({c[0], c[1], c[2]}) / mean_luminance);
  }
  return map;
}

std::vector<NamedMap> seed_maps(std::vector<Cell>& cells, const Group& group,
                                const Image* reference, double mean_luminance) {
  RunningMap final_runs;
  RunningMap unfiltered_runs;
  for (const std::size_t index : group.cells) {
    const std::optional<Layers> layers = read_layers(cells[index]);
    if (!layers || !layers->find("radiance")) continue;
    final_runs.add(relative_luminance(layers->at("radiance"), mean_luminance));
    if (const Image* unfiltered = layers->find("radiance_unfiltered")) {
      unfiltered_runs.add(relative_luminance(*unfiltered, mean_luminance));
    }
  }
  const std::string note = fmt::format("over {} seeds", final_runs.count());
  std::vector<NamedMap> maps;
  if (final_runs.count() < 2) return maps;
  maps.push_back({"noise", "positive", final_runs.deviation(), note});
  if (unfiltered_runs.count() == final_runs.count()) {
    maps.push_back({"noise_unfiltered", "positive", unfiltered_runs.deviation(), note});
  }
  if (reference) {
    maps.push_back({"bias", "signed",
                    final_runs.mean_minus(relative_luminance(*reference, mean_luminance)),
                    note + ", whose noise it still holds"});
  }
  return maps;
}

std::vector<NamedMap> budget_maps(const NamedTexts& budget_facts, const Layers& budget,
                                  const Group& group, const Layers& layers, const Image& reference,
                                  double mean_luminance) {
  const std::string variant = variant_of(budget_facts, group);
  const Image* traced = variant.empty() ? nullptr : budget.find(variant + "_traced");
  const Image* depth = variant.empty() ? nullptr : budget.find(variant + "_depth");
  const Image* final_image = layers.find("radiance");
  if (!traced || !depth || !final_image) return {};
  const Image* unfiltered = layers.find("radiance_unfiltered");
  const auto map = [&](const Image& image) { return relative_luminance(image, mean_luminance); };
  const Image T = map(*traced);
  const Image D = map(*depth);
  const Image X = map(unfiltered ? *unfiltered : *final_image);
  std::vector<NamedMap> maps;
  maps.push_back(difference("budget_representation", T, map(reference)));
  maps.push_back(difference("budget_visibility", D, T));
  maps.push_back(difference("budget_sampling", X, D));
  if (unfiltered) maps.push_back(difference("budget_filter", map(*final_image), X));
  return maps;
}

std::vector<NamedMap> failure_maps(const Layers& budget) {
  std::vector<NamedMap> maps;
  for (const std::string_view name : failure_class_names) {
    const std::string layer = std::string(name) + "_occlusion";
    if (const Image* map = budget.find(layer)) {
      maps.push_back({"failure_" + std::string(name), "signed", *map, ""});
    }
  }
  return maps;
}

}  // namespace occlab::report
