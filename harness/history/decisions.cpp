#include <fmt/format.h>

#include <algorithm>

#include "harness/history/store.h"
#include "renderers/scene/error.h"
#include "renderers/scene/limited_json.h"

// What people decided: baselines and intended changes.

namespace occlab::history {

void add_baseline(const Sqlite& database, const Baseline& baseline) {
  Transaction transaction(database);
  Statement insert(database,
                   "INSERT INTO baselines (name, experiment, run, who, accepted, why, findings) "
                   "VALUES (?,?,?,?,?,?,?)");
  insert.bind(baseline.name).bind(baseline.experiment).bind(baseline.run).bind(baseline.who);
  insert.bind(baseline.accepted).bind(baseline.why).bind(baseline.findings.dump()).run();
  transaction.commit();
}

std::vector<Baseline> list_baselines(const Sqlite& database) {
  Statement rows(database,
                 "SELECT name, experiment, run, who, accepted, why, findings FROM baselines ORDER "
                 "BY id");
  std::vector<Baseline> all;
  while (rows.step()) {
    all.push_back({rows.text(0), rows.text(1), rows.integer(2), rows.text(3), rows.text(4),
                   rows.text(5), parse_limited_json_or_discard(rows.text(6))});
  }
  return all;
}

std::optional<Baseline> current_baseline(const Sqlite& database, const std::string& name,
                                         const std::string& experiment) {
  std::optional<Baseline> current;
  for (Baseline& baseline : list_baselines(database)) {
    if (baseline.name == name && baseline.experiment == experiment) current = std::move(baseline);
  }
  return current;
}

void add_intended(const Sqlite& database, const Intended& intended) {
  Transaction transaction(database);
  Statement known(database, "SELECT count(*) FROM series WHERE key = ?");
  known.bind(intended.series);
  known.step();
  if (known.integer(0) == 0) {
    throw InputError(
        fmt::format("{}: no series has the key '{}'; the dashboard's page shows the keys there are",
                    database.path().string(), intended.series));
  }
  Statement insert(database, "INSERT OR REPLACE INTO intended VALUES (?,?,?,?,?)");
  insert.bind(intended.series).bind(intended.commit).bind(intended.who).bind(intended.accepted);
  insert.bind(intended.why).run();
  transaction.commit();
}

std::vector<Intended> list_intended(const Sqlite& database) {
  Statement rows(database,
                 "SELECT series, commit_id, who, accepted, why FROM intended ORDER BY accepted");
  std::vector<Intended> all;
  while (rows.step()) {
    all.push_back({rows.text(0), rows.text(1), rows.text(2), rows.text(3), rows.text(4)});
  }
  return all;
}

}  // namespace occlab::history
