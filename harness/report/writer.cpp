#include "harness/report/writer.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <set>

#include "harness/files.h"
#include "harness/report/configuration.h"
#include "harness/report/data.h"
#include "harness/report/figure_files.h"
#include "harness/report/page.h"
#include "harness/report/planned.h"
#include "harness/version.h"
#include "renderers/scene/error.h"

namespace occlab::report {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

std::size_t folder_bytes(const fs::path& folder) {
  std::size_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) bytes += entry.file_size();
  }
  return bytes;
}

bool is_report(const fs::path& folder) {
  std::error_code error;
  return fs::is_empty(folder, error) ||
         (fs::is_regular_file(folder / "index.html", error) &&
          read_text(folder / "index.html").find("id=\"occlab-data\"") != std::string::npos);
}

/// run.json without what the page does not show.
json shown_facts(json run) {
  if (!run.is_object()) return nullptr;
  run.erase("cells");
  return run;
}

/// "12 of 40 cells are there", as far as the plan is known.
std::string how_many(const std::vector<Cell>& cells, const fs::path& results) {
  const std::set<std::string> planned = planned_cells(results);
  const auto there = std::ranges::count_if(cells, [&](const Cell& cell) {
    return cell.problem.empty() && (planned.empty() || planned.contains(cell.id));
  });
  if (planned.empty()) return fmt::format("{} finished cells are there", there);
  return fmt::format("{} of {} cells are there", there, planned.size());
}

void judge_cells(const std::vector<Cell>& cells, const json& run, const fs::path& results,
                 Verdict& verdict) {
  const auto bad =
      std::ranges::count_if(cells, [](const Cell& cell) { return !cell.problem.empty(); });
  if (bad > 0) {
    verdict.incomplete(
        fmt::format("{} of {} cells are missing or damaged: see Cells", bad, cells.size()));
  }
  if (run.is_null()) {
    verdict.incomplete(
        fmt::format("run.json is missing: the run has not finished; {}. The same 'occlab run' goes "
                    "on from there",
                    how_many(cells, results)));
  }
}

/// Reads some image of the run for its size, where there is no reference.
std::optional<Layers> some_layers(std::vector<Cell>& cells, const std::vector<Group>& groups) {
  for (const Group& group : groups) {
    for (const std::size_t index : group.cells) {
      auto layers = read_layers(cells[index]);
      if (layers && layers->find("radiance")) return layers;
    }
  }
  return std::nullopt;
}

Frame read_frame(std::vector<Cell>& cells, const std::vector<Group>& groups, Verdict& verdict) {
  std::optional<Layers> reference;
  if (!groups.empty() && groups.front().reference) {
    reference = read_layers(cells[groups.front().cells.front()]);
  }
  try {
    if (reference && reference->find("radiance")) return make_frame(&*reference, nullptr);
  } catch (const InputError& error) {
    verdict.problems.push_back(fmt::format("the reference cannot be shown: {}", error.what()));
  }
  const auto some = some_layers(cells, groups);
  if (some) {
    verdict.problems.emplace_back(
        "without a reference: radiance is not in mean luminances, and exposure 1 is white");
  }
  return make_frame(nullptr, some ? &*some : nullptr);
}

json light_json(const json& run, const std::vector<Cell>& cells) {
  if (!run.is_object()) return {{"missing", "run.json is missing, which names the probe"}};
  const auto cell = std::ranges::find(cells, "", &Cell::problem);
  if (cell == cells.end()) return {{"missing", "there is no intact cell"}};
  return light_of(run.value("configuration", ""), cell->facts);
}

json figures_json(const json& run, const fs::path& results, const fs::path& folder) {
  json figures = figures_of(run.is_object() ? run.value("configuration", "") : "");
  copy_figures(figures, results, folder);
  return figures;
}

/// All of the page's data; writes its images into `folder`.
json make_data(const ReportOptions& options, const fs::path& folder, Verdict& verdict,
               WrittenReport& report) {
  const json run = read_run(options.results);
  const std::string configuration = run.is_object() ? run.value("configuration", "") : "";
  std::vector<Cell> cells = inspect_cells(options.results, run);
  const std::vector<Group> groups = group_cells(cells, run);
  const std::vector<Measurement> rows = read_rows(options.results, run, verdict);
  json data = {{"format", 1},
               {"occlab", build_commit},
               {"run", shown_facts(run)},
               {"tables", tables_json(rows, run, verdict)},
               {"plots", plots_json(rows)},
               {"published", published_json(run, verdict)},
               {"metrics", metrics_json()},
               {"colourMaps", colour_maps_json()},
               {"light", light_json(run, cells)}};
  data["figures"] = figures_json(run, options.results, folder);
  data["methods"] = methods_json(groups, data["figures"]);
  const Frame frame = read_frame(cells, groups, verdict);
  data["closeups"] = closeups_of(configuration, frame.width, frame.height);
  const std::size_t rest = folder_bytes(folder) + inline_json(data).size() + page_script.size() +
                           page_style.size() + 100'000;  // the lists of cells and layers
  const auto limit = std::size_t(options.megabytes * 1e6);
  const PackedImages images =
      pack_images(cells, groups, data["closeups"], frame, limit > rest ? limit - rest : 0, folder);
  judge_cells(cells, run, options.results, verdict);  // what could not be read is known now
  data["frame"] = {{"width", frame.width},
                   {"height", frame.height},
                   {"meanLuminance", frame.mean_luminance},
                   {"exposure", frame.exposure}};
  data["groups"] = groups_json(cells, groups);
  data["otherCells"] = other_cells_json(cells, groups);
  data["layers"] = layers_json(images);
  data["leftOut"] = images.left_out;
  data["complete"] = verdict.complete;
  data["problems"] = verdict.problems;
  report.left_out = images.left_out;
  report.problems = verdict.problems;
  return data;
}

/// The finished folder takes the place of an older report.
void publish(const fs::path& finished, const fs::path& target) {
  std::error_code error;
  fs::remove_all(target, error);
  if (!error) fs::rename(finished, target, error);
  if (error) {
    throw DeviceError(
        fmt::format("{}: cannot be put in its place: {}", target.string(), error.message()));
  }
}

}  // namespace

WrittenReport write_report(const ReportOptions& options) {
  const fs::path target = options.results / "report";
  std::error_code error;
  if (fs::exists(target, error) && !is_report(target)) {
    throw InputError(fmt::format("{}: is not a report of occlab; move it away", target.string()));
  }
  read_run(options.results);  // refuses before anything is written
  const fs::path temporary = options.results / fmt::format(".report-{}", ::getpid());
  WrittenReport report;
  report.index = target / "index.html";
  try {
    create_folder(temporary);
    Verdict verdict;
    const json data = make_data(options, temporary, verdict, report);
    write_text_atomically(temporary / "app.js", page_script);
    write_text_atomically(temporary / "style.css", page_style);
    write_text_atomically(temporary / "index.html", report_page(data));
    report.bytes = folder_bytes(temporary);
    publish(temporary, target);
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(temporary, ignored);
    throw;
  }
  return report;
}

}  // namespace occlab::report
