#include "harness/results_folder.h"

#include <fmt/format.h>

#include <string_view>
#include <system_error>

#include "harness/files.h"
#include "renderers/scene/limited_json.h"

namespace occlab {
namespace fs = std::filesystem;

void remove_results(const fs::path& folder) {
  for (const char* name : {"cells", "locks", "damaged", "progress", "tables", "figures", "report",
                           "measurements.csv", "run.json"}) {
    fs::remove_all(folder / name);
  }
}

nlohmann::json ResultsFolder::read_report(const std::function<void(std::string)>& warn) const {
  if (!fs::exists(report()) || !fs::exists(measurements())) return nlohmann::json::object();
  nlohmann::json stored = parse_limited_json_or_discard(read_text(report()));
  if (stored.is_object() &&
      stored.value("measurements_sha256", nlohmann::json()) == sha256_file(measurements())) {
    return stored;
  }
  warn(fmt::format("{} is not the one that {} describes: measured and timed again",
                   measurements().string(), report().string()));
  return nlohmann::json::object();
}

std::vector<Measurement> ResultsFolder::rows(bool times) const {
  std::vector<Measurement> rows = read_measurements(measurements());
  std::erase_if(rows,
                [&](const Measurement& row) { return row.metric.starts_with("time_") != times; });
  return rows;
}

bool ResultsFolder::has_outputs(bool figures) const {
  return fs::exists(measurements()) && fs::exists(folder_ / "tables") &&
         (!figures || fs::exists(folder_ / "figures"));
}

void ResultsFolder::remove_left_overs() const {
  const auto remove = [](const fs::path& folder, std::string_view prefix) {
    std::error_code error;
    std::vector<fs::path> found;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
      if (entry.path().filename().string().starts_with(prefix)) found.push_back(entry.path());
    }
    for (const fs::path& path : found) fs::remove(path, error);
  };
  // Temporaries' names are those of the outputs with a dot in front and the process behind.
  for (const char* outputs : {"tables", "figures"}) remove(folder_ / outputs, ".");
  for (const fs::path& output : {measurements(), report()}) {
    remove(folder_, "." + output.filename().string() + ".");
  }
}

}  // namespace occlab
