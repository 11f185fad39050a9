#include "harness/history/dashboard.h"

#include <fmt/format.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "harness/files.h"
#include "harness/history/change_points.h"
#include "harness/history/store.h"
#include "harness/report/page.h"
#include "renderers/scene/error.h"
#include "renderers/scene/parallel.h"

namespace occlab::history {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr float missing = std::numeric_limits<float>::quiet_NaN();

std::string base64(const std::vector<std::uint8_t>& bytes) {
  constexpr std::string_view letters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t bits = 0;
    for (std::size_t b = 0; b < 3; ++b) bits = bits << 8 | (b < count ? bytes[i + b] : 0u);
    for (std::size_t c = 0; c < 4; ++c) {
      text += c <= count ? letters[bits >> (18 - 6 * c) & 63u] : '=';
    }
  }
  return text;
}

/// Little endian floats, deflated, as text.
std::string packed(const std::vector<float>& values) {
  std::vector<std::uint8_t> raw;
  raw.reserve(4 * values.size());
  for (const float value : values) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    for (int byte = 0; byte < 4; ++byte) raw.push_back(std::uint8_t(bits >> (8 * byte)));
  }
  uLongf size = compressBound(uLong(raw.size()));
  std::vector<std::uint8_t> deflated(size);
  if (compress2(deflated.data(), &size, raw.data(), uLong(raw.size()), 6) != Z_OK) {
    throw DeviceError("zlib: out of memory");
  }
  deflated.resize(size);
  return base64(deflated);
}

json parameters_json(const std::vector<std::pair<std::string, std::string>>& parameters) {
  json object = json::object();
  for (const auto& [name, value] : parameters) object[name] = value;
  return object;
}

std::string shell_quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

struct Line {
  Series series;
  std::string key;
  std::vector<double> values;  ///< by run; NaN: not there
};

class Dashboard {
 public:
  Dashboard(const Sqlite& database, const DashboardOptions& options)
      : database_(database), options_(options), runs_(list_runs(database)) {
    if (runs_.empty()) {
      throw InputError(
          fmt::format("{}: no runs yet; 'occlab history add' adds one", database.path().string()));
    }
    for (std::size_t i = 0; i < runs_.size(); ++i) places_[runs_[i].id] = i;
    read_lines();
    read_values();
  }

  json data(const fs::path& folder, WrittenDashboard& written) {
    json steps = steps_json(written);
    written.runs = runs_.size();
    written.series = lines_.size();
    return {{"format", 1},
            {"written", now_utc()},
            {"project", options_.project},
            {"level", ChangePointSettings{}.level},
            {"minimum_effect", options_.minimum.error},
            {"accept_command", fmt::format("occlab history accept --db {}",
                                           shell_quoted(fs::absolute(database_.path()).string()))},
            {"runs", runs_json()},
            {"series", series_json()},
            {"values",
             {{"encoding", "float32 little endian, series by series, deflate (zlib), base64"},
              {"value", packed(value_)},
              {"lower", packed(lower_)},
              {"upper", packed(upper_)}}},
            {"steps", std::move(steps)},
            {"images", images_json(folder)}};
  }

 private:
  void read_lines() {
    Statement rows(database_,
                   "SELECT id, key, experiment, scene, view, resolution, probe, method, "
                   "parameters, stage, metric, unit, device FROM series ORDER BY id");
    while (rows.step()) {
      Line line;
      line.key = rows.text(1);
      line.series = {rows.text(2),  rows.text(3),  rows.text(4), rows.text(5),
                     rows.text(6),  rows.text(7),  {},           rows.text(9),
                     rows.text(10), rows.text(11), rows.text(12)};
      line.series.parameters = parameters_of(rows.text(8));
      line.values.assign(runs_.size(), std::numeric_limits<double>::quiet_NaN());
      series_places_[rows.integer(0)] = lines_.size();
      lines_.push_back(std::move(line));
    }
  }

  void read_values() {
    for (auto* values : {&value_, &lower_, &upper_}) {
      values->assign(lines_.size() * runs_.size(), missing);
    }
    Statement rows(database_, "SELECT series, run, value, lower, upper FROM over_seeds");
    while (rows.step()) {
      const auto line = series_places_.find(rows.integer(0));
      const auto run = places_.find(rows.integer(1));
      const std::optional<double> value = rows.number(2);
      // A run that another process adds meanwhile is in the next page.
      if (!value || line == series_places_.end() || run == places_.end()) continue;
      const std::size_t place = line->second * runs_.size() + run->second;
      lines_[line->second].values[run->second] = *value;
      value_[place] = float(*value);
      if (const auto lower = rows.number(3)) lower_[place] = float(*lower);
      if (const auto upper = rows.number(4)) upper_[place] = float(*upper);
      floors_.add(lines_[line->second].series, value);
    }
  }

  json runs_json() const {
    std::set<std::int64_t> accepted;
    std::map<std::pair<std::string, std::string>, std::int64_t> current;
    for (const Baseline& baseline : list_baselines(database_)) {
      current[{baseline.name, baseline.experiment}] = baseline.run;
    }
    for (const auto& [name, run] : current) accepted.insert(run);
    json all = json::array();
    for (const StoredRun& run : runs_) {
      all.push_back({{"id", run.id},
                     {"commit", run.commit},
                     {"subject", run.subject},
                     {"commit_time", run.commit_time},
                     {"added", run.added},
                     {"experiment", run.experiment},
                     {"device", run.device},
                     {"baseline", accepted.contains(run.id)}});
    }
    return all;
  }

  json series_json() const {
    json all = json::array();
    for (const Line& line : lines_) {
      const Series& series = line.series;
      const std::optional<double> floor = floors_.of(series);
      all.push_back({{"key", line.key},
                     {"experiment", series.experiment},
                     {"scene", series.scene},
                     {"view", series.view},
                     {"resolution", series.resolution},
                     {"probe", series.probe},
                     {"method", series.method},
                     {"parameters", parameters_json(series.parameters)},
                     {"stage", series.stage},
                     {"metric", series.metric},
                     {"unit", series.unit},
                     {"device", series.device},
                     {"better", to_string(direction_of(series.metric))},
                     {"noise_floor", floor ? json(*floor) : json()}});
    }
    return all;
  }

  /// Steps that are at least the minimum effect, in the order of the series.
  json steps_json(WrittenDashboard& written) const {
    std::vector<json> by_line(lines_.size());
    parallel_for(lines_.size(), [&](std::size_t i) { by_line[i] = steps_of(i); });
    mark_intended(by_line);
    json all = json::array();
    for (const json& steps : by_line) {
      for (const json& step : steps) {
        written.worse += step["verdict"] == "WORSE" && step["intended"].is_null() ? 1 : 0;
        all.push_back(step);
      }
    }
    written.steps = all.size();
    return all;
  }

  json steps_of(std::size_t index) const {
    const Line& line = lines_[index];
    json all = json::array();
    // Absolute times drift with the machine: they are no independent values around a level.
    if (line.series.metric.starts_with("time_ms.")) return all;
    std::vector<double> values;
    std::vector<std::size_t> runs;
    for (std::size_t run = 0; run < runs_.size(); ++run) {
      if (!std::isfinite(line.values[run])) continue;
      values.push_back(line.values[run]);
      runs.push_back(run);
    }
    const MetricClass metric_class = class_of(line.series.metric);
    for (const ChangePoint& step : find_change_points(values)) {
      const double difference = step.after - step.before;
      const double effect =
          is_relative(metric_class) ? difference / std::abs(step.before) : difference;
      if (!(std::abs(effect) >= options_.minimum.of(metric_class))) continue;
      all.push_back({{"series", index},
                     {"run", runs[step.first]},
                     {"before_run", runs[step.first - 1]},
                     {"before", step.before},
                     {"after", step.after},
                     {"lower", std::isfinite(step.ratio.low) ? json(step.ratio.low) : json()},
                     {"upper", std::isfinite(step.ratio.high) ? json(step.ratio.high) : json()},
                     {"p", step.p_value > 0.0 ? json(step.p_value) : json()},
                     {"verdict", verdict_of(line.series, difference)},
                     {"intended", nullptr}});
    }
    return all;
  }

  static const char* verdict_of(const Series& series, double difference) {
    const Direction direction = direction_of(series.metric);
    if (direction == Direction::none) return "CHANGED";
    return (difference > 0.0) == (direction == Direction::lower) ? "WORSE" : "BETTER";
  }

  /// A mark is of a series and a commit: it holds for the step that this commit may have caused.
  void mark_intended(std::vector<json>& by_line) const {
    std::map<std::string, std::size_t> lines;
    for (std::size_t i = 0; i < lines_.size(); ++i) lines[lines_[i].key] = i;
    for (const Intended& mark : list_intended(database_)) {
      const auto line = lines.find(mark.series);
      if (line == lines.end()) continue;
      for (json& step : by_line[line->second]) {
        const std::size_t last = step["run"].get<std::size_t>();
        for (std::size_t run = step["before_run"].get<std::size_t>() + 1; run <= last; ++run) {
          if (runs_[run].commit != mark.commit) continue;
          step["intended"] = {{"who", mark.who}, {"when", mark.accepted}, {"why", mark.why}};
        }
      }
    }
  }

  json images_json(const fs::path& folder) const {
    create_folder(folder / "images");
    Statement images(database_, "SELECT hash, png FROM images");
    while (images.step()) {
      const auto png = images.bytes(1);
      write_text_atomically(folder / image_file(images.text(0)),
                            {reinterpret_cast<const char*>(png.data()), png.size()});
    }
    json all = json::array();
    Statement rows(database_,
                   "SELECT run, scene, view, method, parameters, stage, hash FROM run_images");
    while (rows.step()) {
      const auto run = places_.find(rows.integer(0));
      if (run == places_.end()) continue;
      all.push_back({{"run", run->second},
                     {"scene", rows.text(1)},
                     {"view", rows.text(2)},
                     {"method", rows.text(3)},
                     {"parameters", parameters_json(parameters_of(rows.text(4)))},
                     {"stage", rows.text(5)},
                     {"file", image_file(rows.text(6))}});
    }
    return all;
  }

  /// In the page's folder and nowhere else, whatever the file of the history holds.
  std::string image_file(const std::string& hash) const {
    if (hash.size() != 64 || hash.find_first_not_of("0123456789abcdef") != std::string::npos) {
      throw InputError(
          fmt::format("{}: table 'images': found the hash '{}'; accepted are 64 hex "
                      "digits: the file is damaged",
                      database_.path().string(), hash));
    }
    return fmt::format("images/{}.png", hash);
  }

  const Sqlite& database_;
  const DashboardOptions& options_;
  std::vector<StoredRun> runs_;
  std::vector<Line> lines_;
  std::map<std::int64_t, std::size_t> places_;
  std::map<std::int64_t, std::size_t> series_places_;
  std::vector<float> value_, lower_, upper_;
  NoiseFloors floors_;
};

void require_ours(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder, error) || (fs::is_directory(folder) && fs::is_empty(folder))) return;
  const fs::path index = folder / "index.html";
  if (fs::is_regular_file(index, error) && fs::is_regular_file(folder / "history.js", error))
    return;
  throw InputError(
      fmt::format("{}: is there and is not the page of a history; name another folder or move it "
                  "away",
                  folder.string()));
}

}  // namespace

WrittenDashboard write_dashboard(const Sqlite& database, const DashboardOptions& options) {
  const fs::path target =
      options.folder.has_filename() ? options.folder : options.folder.parent_path();
  require_ours(target);
  WrittenDashboard written;
  const fs::path temporary =
      target.parent_path() / fmt::format(".{}-{}", target.filename().string(), ::getpid());
  Dashboard dashboard(database, options);
  try {
    create_folder(temporary);
    const std::string page = report::history_page(dashboard.data(temporary, written));
    write_text_atomically(temporary / "history.js", report::history_script);
    write_text_atomically(temporary / "style.css", report::page_style);
    write_text_atomically(temporary / "index.html", page);
    for (const auto& entry : fs::recursive_directory_iterator(temporary)) {
      if (entry.is_regular_file()) written.bytes += entry.file_size();
    }
    fs::remove_all(target);
    fs::rename(temporary, target);
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(temporary, ignored);
    throw;
  }
  written.index = target / "index.html";
  return written;
}

}  // namespace occlab::history
