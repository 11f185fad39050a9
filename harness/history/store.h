#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "harness/history/previews.h"
#include "harness/history/run_data.h"
#include "harness/history/sqlite.h"

namespace occlab::history {

/// A run as the list shows it.
struct StoredRun {
  std::int64_t id = 0;
  std::string commit;
  std::string subject;
  std::string commit_time;
  std::string added;
  std::string experiment;
  std::string device;
};

struct Added {
  std::int64_t run = 0;
  bool is_new = false;  ///< false: the same run of the same commit was there
};

/// Stores a run and its previews in one transaction.
Added add_run(const Sqlite& database, const RunData& data, const std::vector<Preview>& previews);

/// In the order of the history: by the commit's time, where that is unknown by the time it was
/// added; then as they were added.
std::vector<StoredRun> list_runs(const Sqlite& database);

/// The runs whose commit begins with `commit` (at least 4 digits) or is it. Empty if there are
/// none. Throws InputError where several commits begin so.
std::vector<StoredRun> runs_of_commit(const Sqlite& database, const std::string& commit);

/// As runs_of_commit(), of what git calls `name` where no run does: "HEAD", a branch.
std::vector<StoredRun> runs_named(const Sqlite& database, const std::string& name);

/// Everything add_run() was given of that run, in the order of the series' ids.
RunData read_run(const Sqlite& database, const StoredRun& run);

/// A run that was accepted as the baseline of its experiment; the last one of a name counts.
struct Baseline {
  std::string name;
  std::string experiment;
  std::int64_t run = 0;
  std::string who;
  std::string accepted;
  std::string why;
  /// What was WORSE, CHANGED or missing when it was accepted: a list of {series, what, verdict,
  /// effect}.
  nlohmann::json findings = nlohmann::json::array();
};
void add_baseline(const Sqlite& database, const Baseline& baseline);
/// All there ever were, the oldest first.
std::vector<Baseline> list_baselines(const Sqlite& database);
std::optional<Baseline> current_baseline(const Sqlite& database, const std::string& name,
                                         const std::string& experiment);

/// A change of a series that somebody wanted.
struct Intended {
  std::string series;  ///< key
  std::string commit;
  std::string who;
  std::string accepted;
  std::string why;
};
/// Throws InputError where no series has that key.
void add_intended(const Sqlite& database, const Intended& intended);
std::vector<Intended> list_intended(const Sqlite& database);

std::string parameters_text(const std::vector<std::pair<std::string, std::string>>& parameters);
std::vector<std::pair<std::string, std::string>> parameters_of(const std::string& text);

}  // namespace occlab::history
