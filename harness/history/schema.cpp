#include "harness/history/schema.h"

#include <fmt/format.h>

#include <array>
#include <string>

#include "renderers/scene/error.h"

namespace occlab::history {
namespace {

constexpr std::array<std::string_view, 3> steps = {
    // 1: runs and their numbers. Both tables of numbers are clustered by what they are read by: a
    // series over all runs for the dashboard, a run over all series for comparing.
    R"sql(
CREATE TABLE runs (
  id INTEGER PRIMARY KEY,
  content TEXT NOT NULL UNIQUE,
  commit_id TEXT NOT NULL,
  subject TEXT NOT NULL,
  commit_time TEXT NOT NULL,
  added TEXT NOT NULL,
  experiment TEXT NOT NULL,
  device TEXT NOT NULL,
  facts TEXT NOT NULL
) STRICT;
CREATE TABLE series (
  id INTEGER PRIMARY KEY,
  key TEXT NOT NULL UNIQUE,
  experiment TEXT NOT NULL,
  scene TEXT NOT NULL,
  view TEXT NOT NULL,
  resolution TEXT NOT NULL,
  probe TEXT NOT NULL,
  method TEXT NOT NULL,
  parameters TEXT NOT NULL,
  stage TEXT NOT NULL,
  metric TEXT NOT NULL,
  unit TEXT NOT NULL,
  device TEXT NOT NULL
) STRICT;
CREATE TABLE over_seeds (
  series INTEGER NOT NULL REFERENCES series (id),
  run INTEGER NOT NULL REFERENCES runs (id),
  value REAL,
  lower REAL,
  upper REAL,
  n INTEGER NOT NULL,
  reason TEXT NOT NULL,
  PRIMARY KEY (series, run)
) STRICT, WITHOUT ROWID;
CREATE INDEX over_seeds_of_run ON over_seeds (run);
CREATE TABLE per_seed (
  run INTEGER NOT NULL REFERENCES runs (id),
  series INTEGER NOT NULL REFERENCES series (id),
  seed INTEGER NOT NULL,
  value REAL,
  PRIMARY KEY (run, series, seed)
) STRICT, WITHOUT ROWID;
)sql",
    // 2: what people decided.
    R"sql(
CREATE TABLE baselines (
  id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  experiment TEXT NOT NULL,
  run INTEGER NOT NULL REFERENCES runs (id),
  who TEXT NOT NULL,
  accepted TEXT NOT NULL,
  why TEXT NOT NULL,
  findings TEXT NOT NULL
) STRICT;
CREATE TABLE intended (
  series TEXT NOT NULL,
  commit_id TEXT NOT NULL,
  who TEXT NOT NULL,
  accepted TEXT NOT NULL,
  why TEXT NOT NULL,
  PRIMARY KEY (series, commit_id)
) STRICT, WITHOUT ROWID;
)sql",
    // 3: small pictures, each stored once.
    R"sql(
CREATE TABLE images (
  hash TEXT PRIMARY KEY,
  png BLOB NOT NULL
) STRICT;
CREATE TABLE run_images (
  run INTEGER NOT NULL REFERENCES runs (id),
  scene TEXT NOT NULL,
  view TEXT NOT NULL,
  method TEXT NOT NULL,
  parameters TEXT NOT NULL,
  stage TEXT NOT NULL,
  hash TEXT NOT NULL REFERENCES images (hash),
  PRIMARY KEY (run, scene, view, method, parameters, stage)
) STRICT, WITHOUT ROWID;
)sql"};

bool has_tables(const Sqlite& database) {
  return database.integer("SELECT count(*) FROM sqlite_schema") > 0;
}

std::int64_t known_version(const Sqlite& database) {
  const std::int64_t version = database.integer("PRAGMA user_version");
  if (0 <= version && version <= newest_version()) return version;
  throw InputError(
      fmt::format("{}: its schema has version {}; this occlab knows versions up to {}: use a "
                  "newer occlab",
                  database.path().string(), version, newest_version()));
}

/// Where another process has migrated meanwhile, nothing is left to do.
void migrate(const Sqlite& database) {
  Transaction transaction(database);
  for (std::int64_t version = known_version(database); version < newest_version(); ++version) {
    database.execute(std::string(steps[std::size_t(version)]));
  }
  database.execute(fmt::format("PRAGMA application_id = {}", application_id));
  database.execute(fmt::format("PRAGMA user_version = {}", newest_version()));
  transaction.commit();
}

}  // namespace

std::span<const std::string_view> migrations() { return steps; }

Sqlite open_history(const std::filesystem::path& path, bool create) {
  Sqlite database(path, create);
  const std::int64_t id = database.integer("PRAGMA application_id");
  const std::int64_t version = database.integer("PRAGMA user_version");
  const bool is_new = id == 0 && version == 0 && !has_tables(database);
  if (is_new && !create) {
    throw InputError(fmt::format("{}: is empty; a history is expected", path.string()));
  }
  if (!is_new && id != application_id) {
    throw InputError(fmt::format("{}: is the database of another program, not a history of occlab",
                                 path.string()));
  }
  if (known_version(database) < newest_version()) migrate(database);
  return database;
}

}  // namespace occlab::history
