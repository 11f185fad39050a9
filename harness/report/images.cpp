#include "harness/report/images.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "harness/figures/shrink.h"
#include "harness/figures/tone_map.h"
#include "harness/files.h"
#include "harness/metrics/colour.h"
#include "harness/report/maps.h"
#include "harness/report/plane_codec.h"
#include "renderers/scene/error.h"
#include "renderers/scene/parallel.h"

namespace occlab::report {
namespace {

constexpr int widest_map = 480;           ///< pixels; of wider frames some are left out
constexpr int widest_coefficients = 270;  ///< pixels, 16 values each
constexpr int preview_width = 480;

/// Every how many-th pixel makes a picture at most about `widest` wide. Odd, so that all sample
/// sets of the 4x4 interleaved pattern are kept alike.
int odd_step(int width, int widest) {
  const int step = (width + widest - 1) / widest;
  return step % 2 == 0 ? step + 1 : step;
}

/// A layer before it is packed.
struct Candidate {
  PackedLayer layer;
  Image image;
};

/// Layers that are packed together or not at all.
struct Set {
  std::string title;
  std::vector<Candidate> candidates;
};

std::string kind_of(const std::string& name, int channels) {
  if (name == "bent_normal") return "direction";
  if (channels == 16) return "coefficients";
  return channels == 3 ? "radiance" : "share";
}

bool selects(const nlohmann::json& select, const Group& group) {
  for (const auto& [name, value] : select.items()) {
    const std::string* own = find_text(group.parameters, name);
    if (own && value != *own) return false;
  }
  return true;
}

std::size_t beyond_half(const Image& image) {
  return std::size_t(std::ranges::count_if(image.values(), [](float value) {
    return std::isfinite(value) && (half_bits(value) & 0x7fff) == 0x7c00;
  }));
}

class Packer {
 public:
  Packer(std::vector<Cell>& cells, const std::vector<Group>& groups, const Frame& frame,
         std::size_t limit, const std::filesystem::path& folder)
      : cells_(cells), groups_(groups), frame_(frame), limit_(limit), folder_(folder) {
    create_folder(folder / "data");
    create_folder(folder / "previews");
  }

  void pack(Set set) {
    std::size_t raw = 0;
    for (const Candidate& candidate : set.candidates) raw += candidate.image.values().size();
    if (raw == 0) return;
    // What is larger than something that did not fit does not fit either.
    if (raw >= too_large_ || !try_to_pack(set)) {
      too_large_ = std::min(too_large_, raw);
      packed_.left_out.push_back(set.title);
    }
  }

  /// The first seed of a group that can be read, and its layers.
  struct Shown {
    const Cell* cell = nullptr;
    Layers layers;
  };
  Shown read(std::size_t group) {
    for (const std::size_t index : groups_[group].cells) {
      auto layers = read_layers(cells_[index]);
      if (!layers || layers->all().empty()) continue;
      if (!layers->all().front().image.same_size(frame_.mask)) {
        cells_[index].problem = "its images have another size than the reference";
        continue;
      }
      return {&cells_[index], std::move(*layers)};
    }
    return {};
  }

  Candidate candidate(std::size_t group, const Cell& cell, const std::string& name,
                      const Image& image) const {
    Candidate made;
    const std::string kind = kind_of(name, image.channels());
    const bool whole = name.starts_with("radiance") || kind == "share";
    const int widest = kind == "coefficients" ? widest_coefficients : widest_map;
    const int step = whole ? 1 : odd_step(frame_.width, widest);
    made.layer = describe("g" + std::to_string(group), name, kind, step);
    made.layer.cell = cell.id;
    made.image = decimate(image, step);
    return made;
  }

  Candidate candidate(const std::string& owner, const NamedMap& map) const {
    const int step = odd_step(frame_.width, widest_map);
    Candidate made{describe(owner, map.name, map.kind, step), decimate(map.map, step)};
    made.layer.note = map.note;
    return made;
  }

  PackedImages take() { return std::move(packed_); }

 private:
  static PackedLayer describe(const std::string& owner, const std::string& name,
                              const std::string& kind, int step) {
    PackedLayer layer;
    layer.id = owner + "-" + name;
    layer.owner = owner;
    layer.name = name;
    layer.kind = kind;
    layer.step = step;
    return layer;
  }

  bool try_to_pack(Set& set) {
    std::vector<std::string> files(set.candidates.size());
    parallel_for(files.size(), [&](std::size_t i) {
      const Candidate& made = set.candidates[i];
      files[i] = layer_script(made.layer.id, encode_layer(made.image));
    });
    std::size_t bytes = 0;
    for (const std::string& file : files) bytes += file.size();
    if (used_ + bytes > limit_) return false;
    for (std::size_t i = 0; i < files.size(); ++i) write(set.candidates[i], files[i]);
    return true;
  }

  void write(Candidate& made, const std::string& file) {
    PackedLayer& layer = made.layer;
    layer.width = made.image.width();
    layer.height = made.image.height();
    layer.channels = made.image.channels();
    layer.bytes = file.size();
    if (const std::size_t count = beyond_half(made.image)) {
      layer.note = fmt::format("{} values beyond 65504 are shown as infinite", count);
    }
    write_text_atomically(folder_ / "data" / (layer.id + ".js"), file);
    used_ += file.size();
    if (layer.name == "radiance") write_preview(made);
    packed_.layers.push_back(layer);
  }

  void write_preview(Candidate& made) {
    const int factor = (made.image.width() + preview_width - 1) / preview_width;
    made.layer.preview = "previews/" + made.layer.id + ".png";
    const std::filesystem::path path = folder_ / made.layer.preview;
    write_png(path, shrink(tone_map(made.image, frame_.exposure, frame_.mask), factor));
    used_ += std::filesystem::file_size(path);
  }

  std::vector<Cell>& cells_;
  const std::vector<Group>& groups_;
  const Frame& frame_;
  std::size_t limit_;
  std::filesystem::path folder_;
  std::size_t used_ = 0;
  std::size_t too_large_ = std::numeric_limits<std::size_t>::max();
  PackedImages packed_;
};

bool is_own_layer(const std::string& name) {
  return name != "mask" && !name.starts_with("radiance");
}

void pack_reference(Packer& packer, std::size_t group, const Frame& frame) {
  const Packer::Shown shown = packer.read(group);
  if (!shown.cell) return;
  Set set{"the reference", {}};
  for (const char* name : {"radiance", "ambient_occlusion"}) {
    if (const Image* image = shown.layers.find(name)) {
      set.candidates.push_back(packer.candidate(group, *shown.cell, name, *image));
    }
  }
  const bool masks = std::ranges::any_of(frame.mask.values(), [](float m) { return m <= 0.5f; });
  if (masks) set.candidates.push_back(packer.candidate(group, *shown.cell, "mask", frame.mask));
  packer.pack(std::move(set));
}

Set image_set(Packer& packer, const std::vector<std::size_t>& groups, const std::string& title,
              const std::string& name) {
  Set set{title, {}};
  for (const std::size_t group : groups) {
    const Packer::Shown shown = packer.read(group);
    const Image* image = shown.cell ? shown.layers.find(name) : nullptr;
    if (image) set.candidates.push_back(packer.candidate(group, *shown.cell, name, *image));
  }
  return set;
}

void pack_own_layers(Packer& packer, const std::vector<std::size_t>& groups) {
  Set shares{"occlusion", {}};
  Set others{"visibility coefficients, bent normals and irradiance", {}};
  for (const std::size_t group : groups) {
    const Packer::Shown shown = packer.read(group);
    if (!shown.cell) continue;
    for (const Layers::Layer& layer : shown.layers.all()) {
      const int channels = layer.image.channels();
      if (!is_own_layer(layer.name) || (channels != 1 && channels != 3 && channels != 16)) continue;
      Candidate made = packer.candidate(group, *shown.cell, layer.name, layer.image);
      Set& set = made.layer.kind == "share" ? shares : others;
      set.candidates.push_back(std::move(made));
    }
  }
  packer.pack(std::move(shares));
  packer.pack(std::move(others));
}

/// What a group is compared with; empty if there is nothing.
Image truth_of(std::vector<Cell>& cells, const std::vector<Group>& groups, std::size_t group,
               const Frame& frame) {
  const std::size_t truth = groups[group].truth;
  if (truth == 0) return frame.reference;
  const std::optional<Layers> layers = read_layers(cells[groups[truth].cells.front()]);
  const Image* radiance = layers ? layers->find("radiance") : nullptr;
  return radiance && radiance->same_size(frame.mask) ? *radiance : Image();
}

void pack_maps(Packer& packer, std::vector<Cell>& cells, const std::vector<Group>& groups,
               const std::vector<std::size_t>& chosen, const Frame& frame) {
  Set noise{"noise and bias maps", {}};
  const Image* reference = frame.reference.empty() ? nullptr : &frame.reference;
  for (const std::size_t group : chosen) {
    const Image truth = truth_of(cells, groups, group, frame);
    for (const NamedMap& map :
         seed_maps(cells, groups[group], truth.empty() ? nullptr : &truth, frame.mean_luminance)) {
      noise.candidates.push_back(packer.candidate("g" + std::to_string(group), map));
    }
  }
  packer.pack(std::move(noise));
  Set budgets{"error budget maps", {}};
  Set failures{"maps of the failure classes", {}};
  for (Cell& cell : cells) {
    if (!cell.method.empty() || !reference) continue;
    const std::optional<Layers> budget = read_layers(cell);
    if (!budget) continue;
    for (const std::size_t group : chosen) {
      const Packer::Shown shown = packer.read(group);
      for (const NamedMap& map : budget_maps(cell.facts, *budget, groups[group], shown.layers,
                                             frame.reference, frame.mean_luminance)) {
        budgets.candidates.push_back(packer.candidate("g" + std::to_string(group), map));
      }
    }
    if (!failures.candidates.empty()) continue;
    for (const NamedMap& map : failure_maps(*budget)) {
      failures.candidates.push_back(packer.candidate("march", map));
      failures.candidates.back().layer.cell = cell.id;
    }
  }
  packer.pack(std::move(budgets));
  packer.pack(std::move(failures));
}

/// The test groups: the first of every method, those that closeups show besides, and the rest.
struct Priorities {
  std::vector<std::size_t> first, closeups, rest;
};

Priorities prioritise(const std::vector<Group>& groups, const nlohmann::json& closeups) {
  Priorities result;
  std::vector<std::string> methods;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (groups[i].reference) continue;
    const bool known = std::ranges::find(methods, groups[i].method) != methods.end();
    if (!known) methods.push_back(groups[i].method);
    const bool shown = std::ranges::any_of(
        closeups, [&](const auto& row) { return selects(row["select"], groups[i]); });
    (!known ? result.first : shown ? result.closeups : result.rest).push_back(i);
  }
  return result;
}

}  // namespace

Frame make_frame(const Layers* reference, const Layers* some) {
  Frame frame;
  const Layers* any = reference ? reference : some;
  if (!any) return frame;
  const Image& radiance = any->at("radiance");
  frame.width = radiance.width();
  frame.height = radiance.height();
  const Image* mask = any->find("mask");
  frame.mask = mask ? *mask : Image(frame.width, frame.height, 1, 1.0f);
  if (!reference) return frame;
  frame.reference = radiance;
  frame.exposure = shared_exposure(radiance, frame.mask);
  double sum = 0.0;
  std::size_t pixels = 0;
  for (std::size_t i = 0; i < radiance.pixel_count(); ++i) {
    if (frame.mask.values()[i] <= 0.5f) continue;
    const auto c = radiance.values().subspan(3 * i, 3);
    sum += luminance({c[0], c[1], c[2]});
    ++pixels;
  }
  frame.mean_luminance = sum / double(pixels);
  return frame;
}

PackedImages pack_images(std::vector<Cell>& cells, const std::vector<Group>& groups,
                         const nlohmann::json& closeups, const Frame& frame, std::size_t limit,
                         const std::filesystem::path& folder) {
  Packer packer(cells, groups, frame, limit, folder);
  const Priorities groups_by = prioritise(groups, closeups);
  if (!groups.empty() && groups.front().reference) pack_reference(packer, 0, frame);
  const auto pack = [&](const std::vector<std::size_t>& chosen, const char* title,
                        const char* name) { packer.pack(image_set(packer, chosen, title, name)); };
  pack(groups_by.first, "final images of every method's first parameters", "radiance");
  pack_own_layers(packer, groups_by.first);
  pack_maps(packer, cells, groups, groups_by.first, frame);
  pack(groups_by.closeups, "final images that closeups show", "radiance");
  pack(groups_by.first, "images before the filter", "radiance_unfiltered");
  pack(groups_by.rest, "final images of the other parameters", "radiance");
  pack(groups_by.closeups, "images before the filter that closeups show", "radiance_unfiltered");
  pack(groups_by.rest, "images before the filter of the other parameters", "radiance_unfiltered");
  return packer.take();
}

}  // namespace occlab::report
