// What run_data.h has of results folders and files of measurements.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <set>
#include <unordered_map>

#include "harness/files.h"
#include "harness/history/run_data.h"
#include "harness/report/data.h"
#include "renderers/scene/error.h"

namespace occlab::history {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

long seed_number(const std::string& seed, const std::string& place) {
  long number = 0;
  const auto [rest, error] = std::from_chars(seed.data(), seed.data() + seed.size(), number);
  if (error != std::errc() || rest != seed.data() + seed.size()) {
    throw InputError(fmt::format("{}: seed {} is too large for a history", place, seed));
  }
  return number;
}

RunData read_measurements_file(const fs::path& path) {
  RunData data;
  data.name = path.string();
  const std::vector<Measurement> rows = read_measurements(path);
  data.content = sha256_file(path);
  data.series = collect_series(rows, "", data.left_out);
  if (!rows.empty()) {
    data.facts.experiment = rows.front().experiment;
    data.facts.device = rows.front().device;
  }
  return data;
}

}  // namespace

std::vector<SeriesValues> collect_series(const std::vector<Measurement>& rows,
                                         const std::string& machine,
                                         std::vector<std::string>& left_out) {
  std::vector<SeriesValues> all;
  std::unordered_map<std::string, std::size_t> places;
  std::vector<bool> summed;  // has its row over all seeds
  std::set<std::size_t> ambiguous;
  for (const Measurement& row : rows) {
    if (!has_history(row)) continue;
    Series series = series_of(row, machine);
    const auto [place, added] = places.try_emplace(series_key(series), all.size());
    if (added) {
      all.emplace_back();
      all.back().series = std::move(series);
      summed.push_back(false);
    }
    SeriesValues& values = all[place->second];
    if (row.seed != "all") {
      const long seed = seed_number(row.seed, row.metric + " of " + row.method);
      if (!values.by_seed.emplace(seed, row.value).second) ambiguous.insert(place->second);
      if (!row.value && values.reason.empty()) values.reason = row.reason;
      continue;
    }
    if (summed[place->second]) ambiguous.insert(place->second);
    summed[place->second] = true;
    values.value = row.value;
    values.lower = row.lower;
    values.upper = row.upper;
    values.n = row.n;
    values.reason = row.reason;
  }
  if (!ambiguous.empty()) {
    const Series& first = all[*ambiguous.begin()].series;
    left_out.push_back(
        fmt::format("{} series are left out, as two rows of theirs have the same "
                    "seed: the first is {}",
                    ambiguous.size(), series_label(first, {})));
    for (auto index = ambiguous.rbegin(); index != ambiguous.rend(); ++index) {
      all.erase(all.begin() + std::ptrdiff_t(*index));
    }
  }
  for (SeriesValues& values : all) {
    // One seed stands for all: so it is with what is said of the reference.
    if (!values.value && values.by_seed.size() == 1 && values.by_seed.begin()->second) {
      values.value = values.by_seed.begin()->second;
      values.n = 1;
    }
    if (!values.value && values.reason.empty()) values.reason = "no row over all seeds";
  }
  return all;
}

bool is_results(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

RunData read_results(const fs::path& path) {
  std::error_code error;
  if (fs::is_regular_file(path, error)) return read_measurements_file(path);
  if (!fs::is_directory(path, error)) {
    throw InputError(fmt::format(
        "{}: is not there; the folder of an 'occlab run' or 'occlab time', or its measurements.csv "
        "is expected",
        path.string()));
  }
  RunData data;
  data.name = path.string();
  data.facts.run = report::read_any_run(path);
  const json& run = data.facts.run;
  if (!run.is_object() || !fs::exists(path / "measurements.csv", error)) {
    throw InputError(fmt::format(
        "{}: {} is missing: the run has not finished; the same 'occlab run' goes on from there",
        path.string(), run.is_object() ? "measurements.csv" : "run.json"));
  }
  data.content = sha256_file(path / "measurements.csv");
  if (run.value("measurements_sha256", json()) != json(data.content)) {
    throw InputError(
        fmt::format("{}: is not the one that run.json describes: it was edited, or a run was "
                    "killed between writing the two. The same 'occlab run' writes both again",
                    (path / "measurements.csv").string()));
  }
  const std::vector<Measurement> rows = read_measurements(path / "measurements.csv");
  if (rows.empty()) throw InputError(fmt::format("{}: no measurements", path.string()));
  data.series = collect_series(rows, machine_of(run), data.left_out);
  data.facts.commit = run.value("commit", "");
  if (data.facts.commit == "unknown") data.facts.commit.clear();
  data.facts.experiment = run.value("experiment", rows.front().experiment);
  data.facts.device = rows.front().device;
  return data;
}

std::vector<RunData> read_each_once(const std::vector<std::string>& paths) {
  std::vector<RunData> all;
  for (const std::string& path : paths) {
    RunData data = read_results(path);
    const auto twin = std::ranges::find_if(all, [&](const RunData& other) {
      return other.content == data.content && other.facts.run == data.facts.run;
    });
    if (twin != all.end()) {
      throw InputError(fmt::format(
          "{}: is the same run as {}; accepted are runs of their own, as a run does not repeat "
          "itself",
          path, twin->name));
    }
    all.push_back(std::move(data));
  }
  return all;
}

}  // namespace occlab::history
