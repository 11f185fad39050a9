// read_benches of config_parts.h.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "harness/config_parts.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

// The axes, the first varying slowest: what is costly to change is changed seldom.
constexpr const char* scene_axis = "scene.source";
constexpr const char* view_axis = "scene.view";
constexpr const char* size_axis = "scene.resolution";
constexpr const char* probe_axis = "probe.source";
struct RealAxis {
  const char* name;
  const char* key;
  double minimum;
  double maximum;
};
constexpr RealAxis probe_axes[] = {{"probe.prefilter_degrees", "prefilter_degrees", 0.0, 90.0},
                                   {"probe.exposure_stops", "exposure_stops", -32.0, 32.0},
                                   {"probe.rotation_degrees", "rotation_degrees", -360.0, 360.0}};

/// What is read of [scene] and [probe]: an axis, of one value or more, for every key.
class BenchReader {
 public:
  explicit BenchReader(TomlTable& root) : root_(root) {
    if (root.has("sweep")) {
      sweep_.emplace(root.table("sweep"));
      grid_.zips = sweep_->word_lists("zip");
      if (sweep_->has("exclude")) exclusions_ = sweep_->tables("exclude");
      sweep_->refuse_others();
    }
  }

  std::vector<BenchSettings> read() {
    read_scene();
    if (root_.has("probe")) read_probe();
    if (sweep_) {
      check_zips(*sweep_, grid_);
      check_count(*sweep_, "zip", count_crossed(grid_), "[scene] and [probe]");
      for (TomlTable& entry : exclusions_) grid_.exclusions.push_back(read_exclusion(entry));
      check_exclusions(exclusions_, grid_, {});
    }
    check_count(root_, "scene", count_crossed(grid_), "[scene] and [probe]");
    std::vector<BenchSettings> benches;
    std::vector<NamedValues> known;
    for (const NamedValues& point : points(grid_)) {
      if (std::ranges::find(known, point) != known.end()) {
        sweep_->fail("zip", "two points of [scene] and [probe] are the same");
      }
      if (!grid_.zips.empty()) known.push_back(point);
      benches.push_back(bench_of(point));
    }
    return benches;
  }

 private:
  bool zipped(const std::string& name) const {
    return std::ranges::any_of(
        grid_.zips, [&](const auto& zip) { return std::ranges::find(zip, name) != zip.end(); });
  }

  void add_texts(const char* axis, const std::vector<std::string>& texts) {
    grid_.axes.push_back({axis, {texts.begin(), texts.end()}});
  }

  void read_scene() {
    TomlTable table = root_.table("scene");
    add_texts(scene_axis, table.names_or_paths("source", zipped(scene_axis)));
    if (table.is_list("view")) {
      add_texts(view_axis, text_list(table, "view", zipped(view_axis)));
    } else {
      add_texts(view_axis, {table.text("view", "")});
    }
    read_resolution(table);
    table.refuse_others();
  }

  /// A list of texts that may be there twice.
  static std::vector<std::string> text_list(TomlTable& table, const char* key, bool repeats) {
    std::vector<std::string> texts;
    for (const ParameterValue& value : table.values(key, true, repeats)) {
      const auto* const text = std::get_if<std::string>(&value);
      if (!text || text->empty()) {
        table.fail(
            key, fmt::format("found {}; accepted are texts that are not empty", to_string(value)));
      }
      texts.push_back(*text);
    }
    return texts;
  }

  void read_resolution(TomlTable& table) {
    constexpr const char* key = "resolution";
    if (!table.has(key)) return add_texts(size_axis, {"1280x720"});
    const auto is_sizes = [&] {
      if (!table.is_list(key)) return false;
      const std::vector<ParameterValue> values = table.values(key, true, true);
      return std::holds_alternative<std::string>(values.front());
    };
    if (is_sizes()) {
      const std::vector<std::string> sizes = text_list(table, key, zipped(size_axis));
      for (const std::string& text : sizes) {
        if (parse_resolution(text)) continue;
        table.fail(key, fmt::format("found '{}'; accepted are a width and a height from {} to {}, "
                                    "such as '1280x720'",
                                    text, shortest_side, longest_side));
      }
      return add_texts(size_axis, sizes);
    }
    const TomlTable::Numbers size = table.numbers(key, 2);
    const auto accepted = [](double length) {
      return length >= shortest_side && length <= longest_side;
    };
    if (!size.whole || !std::ranges::all_of(size.values, accepted)) {
      table.fail(key,
                 "accepted are two integers in [16, 16384], width and height, or a list of texts "
                 "such as '1280x720'");
    }
    add_texts(size_axis, {fmt::format("{:.0f}x{:.0f}", size.values[0], size.values[1])});
  }

  void read_probe() {
    TomlTable table = root_.table("probe");
    add_texts(probe_axis, table.names_or_paths("source", zipped(probe_axis)));
    for (const RealAxis& axis : probe_axes) {
      Axis values{axis.name, {}};
      if (table.is_list(axis.key)) {
        values.values = table.values(axis.key, true, zipped(axis.name));
        for (ParameterValue& value : values.values) {
          if (const auto* integer = std::get_if<long>(&value)) value = double(*integer);
          const auto* const number = std::get_if<double>(&value);
          if (!number || !(*number >= axis.minimum && *number <= axis.maximum)) {
            table.fail(axis.key, fmt::format("found {}; accepted are numbers in [{:g}, {:g}]",
                                             to_string(value), axis.minimum, axis.maximum));
          }
        }
      } else {
        values.values.emplace_back(table.real(axis.key, axis.minimum, axis.maximum, 0.0));
      }
      grid_.axes.push_back(std::move(values));
    }
    table.refuse_others();
  }

  /// {scene.view = "main", probe.rotation_degrees = [0, 90]}.
  static std::vector<Axis> read_exclusion(TomlTable& entry) {
    for (const std::string& table_name : entry.others()) {
      if (table_name != "scene" && table_name != "probe") {
        entry.refuse_unknown(table_name, {"scene", "probe"});
      }
    }
    return read_bench_values(entry);
  }

  static BenchSettings bench_of(const NamedValues& point) {
    BenchSettings bench;
    bench.point = point;
    ProbeSettings probe;
    const auto text = [](const ParameterValue& value) { return std::get<std::string>(value); };
    for (const auto& [name, value] : point) {
      if (name == scene_axis) bench.scene.source = text(value);
      if (name == view_axis) bench.scene.view = text(value);
      if (name == size_axis) {
        const Resolution size = *parse_resolution(text(value));
        bench.scene.width = size.width;
        bench.scene.height = size.height;
      }
      if (name == probe_axis) probe.source = text(value);
      if (name == probe_axes[0].name) probe.prefilter_degrees = float(std::get<double>(value));
      if (name == probe_axes[1].name) probe.exposure_stops = float(std::get<double>(value));
      if (name == probe_axes[2].name) probe.rotation_degrees = float(std::get<double>(value));
    }
    if (!probe.source.empty()) bench.probe = probe;
    return bench;
  }

  TomlTable& root_;
  std::optional<TomlTable> sweep_;
  std::vector<TomlTable> exclusions_;
  Grid grid_;
};

}  // namespace

std::optional<Resolution> parse_resolution(const std::string& text) {
  Resolution size;
  const char* const end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width);
  if (width.ec != std::errc() || width.ptr == end || *width.ptr != 'x') return std::nullopt;
  const auto height = std::from_chars(width.ptr + 1, end, size.height);
  if (height.ec != std::errc() || height.ptr != end) return std::nullopt;
  const auto accepted = [](int side) { return side >= shortest_side && side <= longest_side; };
  if (!accepted(size.width) || !accepted(size.height)) return std::nullopt;
  return size;
}

std::vector<Axis> read_bench_values(TomlTable& table) {
  std::vector<Axis> axes;
  for (const char* name : {"scene", "probe"}) {
    if (!table.has(name)) continue;
    TomlTable part = table.table(name);
    for (const std::string& key : part.others()) {
      Axis axis{fmt::format("{}.{}", name, key), {}};
      if (key == "source") {
        const std::vector<std::string> sources = part.names_or_paths(key, false);
        axis.values = {sources.begin(), sources.end()};
      } else {
        axis.values = part.values(key, true);
      }
      axes.push_back(std::move(axis));
    }
  }
  return axes;
}

namespace {

/// "scene.view is 'frame1', 'frame2'": the axes in which the benches differ.
std::string differences(const std::vector<BenchSettings>& benches) {
  std::string text;
  for (const auto& [name, unused] : benches.front().point) {
    std::vector<std::string> values;
    for (const BenchSettings& bench : benches) {
      const auto found = std::ranges::find(bench.point, name, &NamedValues::value_type::first);
      const std::string value = fmt::format("'{}'", to_string(found->second));
      if (std::ranges::find(values, value) == values.end()) values.push_back(value);
    }
    if (values.size() < 2) continue;
    text += fmt::format("{}{} is {}", text.empty() ? "" : "; ", name, fmt::join(values, ", "));
  }
  return text;
}

}  // namespace

std::size_t select_bench(const TomlTable& table, const std::string& key,
                         const std::vector<BenchSettings>& benches,
                         const std::vector<Axis>& values) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < benches.size(); ++i) {
    if (has_values(benches[i].point, values)) found.push_back(i);
  }
  if (found.size() == 1) return found.front();
  if (benches.size() == 1) {
    table.fail(key, "[scene] and [probe] do not have these values");
  }
  table.fail(key, fmt::format("{} of the scenes, views, resolutions and probes fit; accepted is a "
                              "choice of one, such as by scene.view: {}",
                              found.empty() ? "none" : std::to_string(found.size()),
                              differences(benches)));
}

std::vector<BenchSettings> read_benches(TomlTable& root) { return BenchReader(root).read(); }

}  // namespace occlab
