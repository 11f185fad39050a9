#include "harness/report/planned.h"

#include <nlohmann/json.hpp>
#include <optional>

#include "harness/files.h"
#include "renderers/scene/limited_json.h"

namespace occlab::report {
namespace fs = std::filesystem;

std::set<std::string> planned_cells(const fs::path& results) {
  std::error_code error;
  std::optional<fs::path> newest;
  fs::file_time_type time;
  for (const auto& entry : fs::directory_iterator(results / "progress", error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("plan-") || !name.ends_with(".json")) continue;
    const auto written = entry.last_write_time(error);
    if (error || (newest && written <= time)) continue;
    newest = entry.path();
    time = written;
  }
  if (!newest) return {};
  const auto plan = parse_limited_json_or_discard(read_text(*newest));
  if (!plan.is_object() || plan.value("format", nlohmann::json()) != 1) return {};
  std::set<std::string> ids;
  for (const auto& work : plan.value("work", nlohmann::json::array())) {
    if (!work.is_object() || !work.contains("id") || !work["id"].is_string()) return {};
    ids.insert(work["id"].get<std::string>());
  }
  return ids;
}

}  // namespace occlab::report
