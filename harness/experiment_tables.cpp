#include "harness/experiment_tables.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "harness/budget_tables.h"
#include "harness/certification.h"
#include "harness/files.h"
#include "harness/measure.h"
#include "harness/table_formats.h"

namespace occlab {

TimingTableSettings timing_table_settings(const Experiment& experiment,
                                          const nlohmann::json& timing_context) {
  if (!experiment.timing) return {};
  TimingTableSettings settings{experiment.timing->baseline, experiment.timing->published, {}};
  if (!experiment.timing->note.empty()) settings.notes.push_back(experiment.timing->note);
  if (timing_context.is_object()) {
    for (std::string& note : timing_context.value("notes", std::vector<std::string>())) {
      settings.notes.push_back(std::move(note));
    }
  }
  return settings;
}

nlohmann::json to_json(const TimingTableSettings& settings) {
  return {{"baseline", settings.baseline},
          {"published", settings.published},
          {"notes", settings.notes}};
}

TimingTableSettings stored_timing_table_settings(const nlohmann::json& stored) {
  return {stored.value("baseline", ""), stored.value("published", ""),
          stored.value("notes", std::vector<std::string>())};
}

std::vector<Table> make_timing_tables(const std::vector<Measurement>& measurements,
                                      const TimingTableSettings& timing) {
  if (timing.baseline.empty()) return {};
  std::optional<PublishedTimes> published;
  if (!timing.published.empty()) {
    published = read_published_times(published_path(timing.published));
  }
  std::vector<Table> tables;
  if (published && published->frame_rates) {
    tables.push_back(frame_rate_table(measurements, timing, *published));
    published.reset();
  }
  tables.push_back(timing_table(measurements, timing, published));
  tables.push_back(scaling_table(measurements));
  std::erase_if(tables, [](const Table& table) { return table.rows.empty(); });
  return tables;
}

std::vector<Table> make_tables(const std::vector<Measurement>& measurements,
                               const TimingTableSettings& timing) {
  std::vector<Measurement> whole_view;
  std::vector<Measurement> closeups;
  std::ranges::partition_copy(measurements, std::back_inserter(closeups),
                              std::back_inserter(whole_view), is_region);
  std::vector<Table> tables;
  const auto add = [&](Table table) {
    if (!table.rows.empty()) tables.push_back(std::move(table));
  };
  for (Table& table : make_timing_tables(measurements, timing)) add(std::move(table));
  const std::array<std::string, 2> stages = {"unfiltered", "filtered"};
  std::vector<Table> comparison_tables;
  for (const std::string& stage : stages) {
    const Comparisons comparisons = compare_noise(whole_view, stage);
    add(noise_table(whole_view, stage, comparisons));
    comparison_tables.push_back(comparisons_table(comparisons, "noise_comparisons_" + stage,
                                                  "Noise and bias compared, " + stage));
  }
  for (const std::string& stage : stages) {
    const Comparisons comparisons = compare_accuracy(whole_view, stage);
    add(accuracy_table(whole_view, stage, comparisons));
    comparison_tables.push_back(
        comparisons_table(comparisons, "comparisons_" + stage, "Accuracy compared, " + stage));
  }
  for (const std::string& stage : stages) {
    Table table = accuracy_table(closeups, stage, compare_accuracy(closeups, stage));
    table.name = "closeups_" + stage;
    table.title = "Accuracy in the closeups, " + stage;
    add(std::move(table));
  }
  for (const std::string& stage : stages) add(brightness_table(closeups, stage));
  add(reference_table(measurements));
  for (const std::string& stage : stages) add(budget_table(measurements, stage));
  add(failure_table(measurements));
  for (Table& table : comparison_tables) add(std::move(table));
  add(orderings_table(measurements));
  return tables;
}

void write_tables(const std::vector<Table>& tables, const std::filesystem::path& folder) {
  create_folder(folder);
  for (const Table& table : tables) {
    for (const std::string& format : table_formats()) {
      write_text_atomically(folder / (table.name + table_extension(format)),
                            format_table(table, format));
    }
  }
}

std::string format_tables(const std::vector<Table>& tables, const std::string& format) {
  const bool json = format == "json";
  std::string text;
  for (const Table& table : tables) {
    if (!text.empty()) text += json ? ",\n" : "\n";
    std::string one = format_table(table, format);
    if (json && one.ends_with('\n')) one.pop_back();
    text += one;
  }
  return json ? "[\n" + text + "\n]\n" : text;
}

}  // namespace occlab
