#include "harness/history/store.h"

#include <fmt/format.h>

#include <algorithm>

#include "harness/files.h"
#include "harness/history/git.h"
#include "harness/history/schema.h"
#include "renderers/scene/error.h"
#include "renderers/scene/limited_json.h"

namespace occlab::history {
namespace {

using nlohmann::json;

constexpr std::size_t least_digits = 4;

constexpr const char* run_columns =
    "id, commit_id, subject, commit_time, added, experiment, device";
constexpr const char* run_order = "ORDER BY coalesce(nullif(commit_time, ''), added), id";

StoredRun stored_run(const Statement& row) {
  return {row.integer(0), row.text(1), row.text(2), row.text(3),
          row.text(4),    row.text(5), row.text(6)};
}

/// Statements that are used once for every number of a run.
class RunWriter {
 public:
  RunWriter(const Sqlite& database, std::int64_t run)
      : database_(database),
        run_(run),
        find_(database, "SELECT id FROM series WHERE key = ?"),
        series_(database,
                "INSERT INTO series (key, experiment, scene, view, resolution, probe, method, "
                "parameters, stage, metric, unit, device) VALUES (?,?,?,?,?,?,?,?,?,?,?,?)"),
        over_seeds_(database, "INSERT INTO over_seeds VALUES (?,?,?,?,?,?,?)"),
        per_seed_(database, "INSERT INTO per_seed VALUES (?,?,?,?)") {}

  void write(const SeriesValues& values) {
    const std::int64_t series = id_of(values.series);
    over_seeds_.bind(series).bind(run_).bind(values.value).bind(values.lower).bind(values.upper);
    over_seeds_.bind(std::int64_t(values.n)).bind(values.reason).run();
    for (const auto& [seed, value] : values.by_seed) {
      per_seed_.bind(run_).bind(series).bind(std::int64_t(seed)).bind(value).run();
    }
  }

 private:
  std::int64_t id_of(const Series& s) {
    const std::string key = series_key(s);
    find_.bind(key);
    const bool known = find_.step();
    const std::int64_t id = known ? find_.integer(0) : 0;
    find_.reset();
    if (known) return id;
    series_.bind(key).bind(s.experiment).bind(s.scene).bind(s.view).bind(s.resolution);
    series_.bind(s.probe).bind(s.method).bind(parameters_text(s.parameters)).bind(s.stage);
    series_.bind(s.metric).bind(s.unit).bind(s.device).run();
    return database_.last_row();
  }

  const Sqlite& database_;
  std::int64_t run_;
  Statement find_;
  Statement series_;
  Statement over_seeds_;
  Statement per_seed_;
};

void write_previews(const Sqlite& database, std::int64_t run,
                    const std::vector<Preview>& previews) {
  Statement image(database, "INSERT OR IGNORE INTO images VALUES (?,?)");
  Statement use(database, "INSERT INTO run_images VALUES (?,?,?,?,?,?,?)");
  for (const Preview& preview : previews) {
    image.bind(preview.hash).bind(preview.png).run();
    use.bind(run).bind(preview.scene).bind(preview.view).bind(preview.method);
    use.bind(parameters_text(preview.parameters)).bind(preview.stage).bind(preview.hash).run();
  }
}

}  // namespace

std::string parameters_text(const std::vector<std::pair<std::string, std::string>>& parameters) {
  json pairs = json::array();
  for (const auto& [name, value] : parameters) pairs.push_back({name, value});
  return pairs.dump();
}

std::vector<std::pair<std::string, std::string>> parameters_of(const std::string& text) {
  std::vector<std::pair<std::string, std::string>> parameters;
  const json pairs = parse_limited_json_or_discard(text);
  for (const json& pair : pairs.is_array() ? pairs : json::array()) {
    if (!pair.is_array() || pair.size() != 2 || !pair[0].is_string() || !pair[1].is_string()) {
      throw InputError(fmt::format("history: parameters of a series are damaged: {}", text));
    }
    parameters.emplace_back(pair[0], pair[1]);
  }
  return parameters;
}

Added add_run(const Sqlite& database, const RunData& data, const std::vector<Preview>& previews) {
  const std::string facts = data.facts.run.dump();
  const std::string content = sha256_text(data.content + facts + data.facts.commit);
  Transaction transaction(database);
  Statement known(database, "SELECT id FROM runs WHERE content = ?");
  known.bind(content);
  if (known.step()) return {known.integer(0), false};
  Statement insert(database,
                   "INSERT INTO runs (content, commit_id, subject, commit_time, added, experiment, "
                   "device, facts) VALUES (?,?,?,?,?,?,?,?)");
  insert.bind(content).bind(data.facts.commit).bind(data.facts.subject);
  insert.bind(data.facts.commit_time).bind(now_utc()).bind(data.facts.experiment);
  insert.bind(data.facts.device).bind(facts).run();
  const std::int64_t run = database.last_row();
  RunWriter writer(database, run);
  for (const SeriesValues& values : data.series) writer.write(values);
  write_previews(database, run, previews);
  transaction.commit();
  return {run, true};
}

std::vector<StoredRun> list_runs(const Sqlite& database) {
  Statement rows(database, fmt::format("SELECT {} FROM runs {}", run_columns, run_order));
  std::vector<StoredRun> runs;
  while (rows.step()) runs.push_back(stored_run(rows));
  return runs;
}

std::vector<StoredRun> runs_of_commit(const Sqlite& database, const std::string& commit) {
  std::vector<StoredRun> runs;
  std::vector<std::string> commits;
  for (StoredRun& run : list_runs(database)) {
    const bool begins = commit.size() >= least_digits && run.commit.starts_with(commit);
    // A full hash asks for what a build calls by its first digits, too.
    const bool is_short = run.commit.size() >= 7 && commit.starts_with(run.commit);
    if (run.commit == commit) {  // exactly that, even where others begin like it
      if (commits != std::vector{commit}) runs.clear();
      commits = {commit};
    } else if ((!begins && !is_short) || commits == std::vector{commit}) {
      continue;
    } else if (std::ranges::find(commits, run.commit) == commits.end()) {
      commits.push_back(run.commit);
    }
    runs.push_back(std::move(run));
  }
  if (commits.size() > 1) {
    throw InputError(fmt::format("{}: commit {} fits several: {} and {}; accepted is one of them",
                                 database.path().string(), commit, commits[0], commits[1]));
  }
  return runs;
}

std::vector<StoredRun> runs_named(const Sqlite& database, const std::string& name) {
  std::vector<StoredRun> runs = runs_of_commit(database, name);
  if (!runs.empty()) return runs;
  const auto commit = find_commit(name);
  return commit ? runs_of_commit(database, commit->hash) : runs;
}

RunData read_run(const Sqlite& database, const StoredRun& run) {
  RunData data;
  data.name = fmt::format("run {} (commit {}) of {}", run.id, run.commit, database.path().string());
  data.facts = {run.commit, run.subject, run.commit_time, run.experiment, run.device, nullptr};
  Statement facts(database, "SELECT facts FROM runs WHERE id = ?");
  facts.bind(run.id);
  if (facts.step()) data.facts.run = parse_limited_json_or_discard(facts.text(0));
  Statement rows(database,
                 "SELECT s.id, s.experiment, s.scene, s.view, s.resolution, s.probe, s.method, "
                 "s.parameters, s.stage, s.metric, s.unit, s.device, v.value, v.lower, v.upper, "
                 "v.n, v.reason FROM over_seeds v JOIN series s ON s.id = v.series WHERE v.run = ? "
                 "ORDER BY s.id");
  rows.bind(run.id);
  std::map<std::int64_t, std::size_t> places;
  while (rows.step()) {
    SeriesValues values;
    values.series = {rows.text(1), rows.text(2),  rows.text(3), rows.text(4),
                     rows.text(5), rows.text(6),  {},           rows.text(8),
                     rows.text(9), rows.text(10), rows.text(11)};
    values.series.parameters = parameters_of(rows.text(7));
    values.value = rows.number(12);
    values.lower = rows.number(13);
    values.upper = rows.number(14);
    values.n = long(rows.integer(15));
    values.reason = rows.text(16);
    places.emplace(rows.integer(0), data.series.size());
    data.series.push_back(std::move(values));
  }
  Statement seeds(database, "SELECT series, seed, value FROM per_seed WHERE run = ?");
  seeds.bind(run.id);
  while (seeds.step()) {
    const auto place = places.find(seeds.integer(0));
    if (place == places.end()) continue;
    data.series[place->second].by_seed.emplace(long(seeds.integer(1)), seeds.number(2));
  }
  return data;
}

}  // namespace occlab::history
