#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "harness/history/schema.h"
#include "harness/history/store.h"
#include "renderers/scene/error.h"

namespace occlab::history {
namespace {

namespace fs = std::filesystem;

class HistoryStore : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / (std::string("occlab-history-") + info->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path file() const { return folder_ / "history.sqlite"; }

  /// What opening says; "" if it works.
  std::string refusal() const {
    try {
      open_history(file(), false);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

SeriesValues series(const std::string& metric, double value) {
  SeriesValues values;
  values.series = {"small",
                   "boxes",
                   "main",
                   "16x9",
                   metric == "psnr" ? "sky" : "sun",
                   "ssao",
                   {{"samples", "8"}},
                   "filtered",
                   metric,
                   "1",
                   "llvmpipe"};
  values.value = value;
  values.lower = value - 0.5;
  values.upper = value + 0.5;
  values.n = 2;
  values.by_seed = {{0, value - 0.1}, {1, value + 0.1}};
  return values;
}

RunData run(const std::string& commit, double value) {
  RunData data;
  data.content = "measurements " + std::to_string(value);
  data.facts = {commit,     "subject's \"quotes\"", "2026-01-02T03:04:05Z", "small",
                "llvmpipe", {{"schema", 1}}};
  data.series = {series("rmse", value), series("psnr", 30.0)};
  SeriesValues missing = series("ssim", 0.0);
  missing.value = missing.lower = missing.upper = std::nullopt;
  missing.reason = "no pixels";
  missing.by_seed = {{0, std::nullopt}};
  data.series.push_back(missing);
  return data;
}

/// Version 1 as it was published; frozen here, whatever the program's own steps become.
constexpr const char* version_1 = R"sql(
CREATE TABLE runs (id INTEGER PRIMARY KEY, content TEXT NOT NULL UNIQUE, commit_id TEXT NOT NULL,
  subject TEXT NOT NULL, commit_time TEXT NOT NULL, added TEXT NOT NULL, experiment TEXT NOT NULL,
  device TEXT NOT NULL, facts TEXT NOT NULL) STRICT;
CREATE TABLE series (id INTEGER PRIMARY KEY, key TEXT NOT NULL UNIQUE, experiment TEXT NOT NULL,
  scene TEXT NOT NULL, view TEXT NOT NULL, resolution TEXT NOT NULL, probe TEXT NOT NULL,
  method TEXT NOT NULL, parameters TEXT NOT NULL, stage TEXT NOT NULL, metric TEXT NOT NULL,
  unit TEXT NOT NULL, device TEXT NOT NULL) STRICT;
CREATE TABLE over_seeds (series INTEGER NOT NULL REFERENCES series (id),
  run INTEGER NOT NULL REFERENCES runs (id), value REAL, lower REAL, upper REAL, n INTEGER NOT NULL,
  reason TEXT NOT NULL, PRIMARY KEY (series, run)) STRICT, WITHOUT ROWID;
CREATE INDEX over_seeds_of_run ON over_seeds (run);
CREATE TABLE per_seed (run INTEGER NOT NULL REFERENCES runs (id),
  series INTEGER NOT NULL REFERENCES series (id), seed INTEGER NOT NULL, value REAL,
  PRIMARY KEY (run, series, seed)) STRICT, WITHOUT ROWID;
INSERT INTO runs VALUES (1, 'c', 'abcd1234', 's', '', '2026-01-01T00:00:00Z', 'old', 'd', '{}');
INSERT INTO series VALUES (1, 'k', 'old', 'boxes', 'main', '16x9', 'sun', 'ssao',
  '[["samples","8"]]', 'filtered', 'rmse', '1', 'd');
INSERT INTO over_seeds VALUES (1, 1, 0.25, 0.2, 0.3, 2, '');
INSERT INTO per_seed VALUES (1, 1, 0, 0.24);
PRAGMA application_id = 1868784492;
PRAGMA user_version = 1;
)sql";

TEST_F(HistoryStore, KeepsWhatItIsGiven) {
  const Sqlite database = open_history(file(), true);
  const RunData data = run("abcd1234", 0.1);
  const Added added = add_run(database, data, {});
  EXPECT_TRUE(added.is_new);
  const std::vector<StoredRun> runs = list_runs(database);
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(runs[0].subject, data.facts.subject);
  const RunData read = read_run(database, runs[0]);
  ASSERT_EQ(read.series.size(), data.series.size());
  for (std::size_t i = 0; i < data.series.size(); ++i) {
    EXPECT_EQ(read.series[i].series, data.series[i].series);
    EXPECT_EQ(read.series[i].value, data.series[i].value);
    EXPECT_EQ(read.series[i].lower, data.series[i].lower);
    EXPECT_EQ(read.series[i].by_seed, data.series[i].by_seed);
    EXPECT_EQ(read.series[i].reason, data.series[i].reason);
  }
  EXPECT_EQ(read.facts.run, data.facts.run);
}

TEST_F(HistoryStore, TheSameRunIsAddedOnce) {
  const Sqlite database = open_history(file(), true);
  const Added first = add_run(database, run("abcd1234", 0.1), {});
  const Added again = add_run(database, run("abcd1234", 0.1), {});
  EXPECT_FALSE(again.is_new);
  EXPECT_EQ(again.run, first.run);
  EXPECT_TRUE(add_run(database, run("ffff0000", 0.1), {}).is_new);  // of another commit
  EXPECT_EQ(list_runs(database).size(), 2u);
  EXPECT_EQ(database.integer("SELECT count(*) FROM series"), 3);
}

TEST_F(HistoryStore, ARunThatFailsLeavesNothing) {
  const Sqlite database = open_history(file(), true);
  RunData twice = run("abcd1234", 0.1);
  twice.series.push_back(twice.series.front());
  EXPECT_THROW(add_run(database, twice, {}), std::runtime_error);
  for (const char* table : {"runs", "series", "over_seeds", "per_seed"}) {
    EXPECT_EQ(database.integer(std::string("SELECT count(*) FROM ") + table), 0) << table;
  }
}

TEST_F(HistoryStore, TwoWritersTakeTurns) {
  open_history(file(), true);
  const auto add_many = [&](int first) {
    const Sqlite database = open_history(file(), true);
    for (int i = 0; i < 20; ++i) add_run(database, run("abcd1234", first + i), {});
  };
  std::thread other(add_many, 100);
  add_many(0);
  other.join();
  EXPECT_EQ(list_runs(open_history(file(), false)).size(), 40u);
}

TEST_F(HistoryStore, CommitsByTheirFirstDigits) {
  const Sqlite database = open_history(file(), true);
  add_run(database, run("abcd1234", 0.1), {});
  add_run(database, run("abcd1234", 0.2), {});
  add_run(database, run("abce9999", 0.3), {});
  EXPECT_EQ(runs_of_commit(database, "abcd").size(), 2u);
  EXPECT_EQ(runs_of_commit(database, "abcd1234ffffffff").size(), 2u);  // the full hash
  EXPECT_TRUE(runs_of_commit(database, "abc").empty());                // too short
  EXPECT_TRUE(runs_of_commit(database, "0000").empty());
  add_run(database, run("abcd5678", 0.4), {});
  EXPECT_THROW(runs_of_commit(database, "abcd"), InputError);
}

TEST_F(HistoryStore, BaselinesAndMarksAreKept) {
  const Sqlite database = open_history(file(), true);
  const std::int64_t id = add_run(database, run("abcd1234", 0.1), {}).run;
  add_baseline(database, {"main", "small", id, "me", "2026", "first", nlohmann::json::array()});
  add_baseline(database, {"main", "small", id, "you", "2027", "again", {{{"verdict", "WORSE"}}}});
  EXPECT_EQ(list_baselines(database).size(), 2u);
  EXPECT_EQ(current_baseline(database, "main", "small")->who, "you");
  EXPECT_FALSE(current_baseline(database, "main", "large"));
  EXPECT_THROW(add_intended(database, {"nokey", "abcd1234", "me", "2026", "why"}), InputError);
  const std::string key = series_key(run("", 0.1).series.front().series);
  add_intended(database, {key, "abcd1234", "me", "2026", "why"});
  EXPECT_EQ(list_intended(database).front().why, "why");
}

TEST_F(HistoryStore, OldVersionsBecomeTheNewest) {
  Sqlite(file(), true).execute(version_1);
  const Sqlite database = open_history(file(), false);
  EXPECT_EQ(database.integer("PRAGMA user_version"), newest_version());
  const std::vector<StoredRun> runs = list_runs(database);
  ASSERT_EQ(runs.size(), 1u);
  const RunData old = read_run(database, runs[0]);
  ASSERT_EQ(old.series.size(), 1u);
  EXPECT_EQ(old.series[0].value, 0.25);
  EXPECT_EQ(old.series[0].by_seed.at(0), 0.24);
  add_baseline(database, {"main", "old", 1, "me", "2026", "why", nlohmann::json::array()});
  EXPECT_TRUE(add_run(database, run("abcd1234", 0.1), {}).is_new);
  // Nothing tells it from a new one.
  const Sqlite fresh = open_history(folder_ / "fresh.sqlite", true);
  for (const Sqlite* one : {&database, &fresh}) {
    EXPECT_EQ(one->integer("SELECT count(*) FROM sqlite_schema WHERE type = 'table'"), 8);
  }
}

TEST_F(HistoryStore, NewerVersionsAreRefusedWithAHint) {
  open_history(file(), true).execute("PRAGMA user_version = 99");
  EXPECT_NE(refusal().find("99"), std::string::npos);
  EXPECT_NE(refusal().find("newer occlab"), std::string::npos);
}

TEST_F(HistoryStore, VersionsBelowTheFirstAreRefused) {
  open_history(file(), true).execute("PRAGMA user_version = -7");
  EXPECT_NE(refusal().find("-7"), std::string::npos);
}

TEST_F(HistoryStore, WhatIsNoHistoryIsRefused) {
  EXPECT_NE(refusal().find("there is no such history"), std::string::npos);
  std::ofstream(file()) << std::string(5000, 'x');
  EXPECT_NE(refusal().find("is not an SQLite database"), std::string::npos);
  fs::remove(file());
  Sqlite(file(), true).execute("CREATE TABLE cats (name TEXT)");
  EXPECT_NE(refusal().find("another program"), std::string::npos);
  fs::remove(file());
  std::ofstream(file()).close();
  EXPECT_NE(refusal().find("is empty"), std::string::npos);
  fs::remove(file());
  fs::create_directory(file());
  EXPECT_NE(refusal().find("is a folder"), std::string::npos);
}

TEST_F(HistoryStore, DamageIsFoundWhenItIsRead) {
  {
    const Sqlite database = open_history(file(), true);
    for (int i = 0; i < 50; ++i) add_run(database, run("abcd1234", i), {});
  }
  // The header stays whole, all pages after it are garbage.
  std::fstream bytes(file(), std::ios::in | std::ios::out | std::ios::binary);
  bytes.seekp(4096);
  bytes << std::string(std::size_t(fs::file_size(file()) - 4096), '\x5a');
  bytes.close();
  try {
    const Sqlite database = open_history(file(), false);
    list_runs(database);
    FAIL() << "read a damaged file";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("damaged"), std::string::npos) << error.what();
  }
}

TEST(UtcTime, OffsetsAreTakenOff) {
  EXPECT_EQ(utc_time("2026-11-22T11:57:39+01:00", "x"), "2026-11-22T10:57:39Z");
  EXPECT_EQ(utc_time("2026-12-31T23:30:00-01:30", "x"), "2027-01-01T01:00:00Z");
  EXPECT_EQ(utc_time("2024-02-29T00:00:00Z", "x"), "2024-02-29T00:00:00Z");
  for (const char* wrong :
       {"", "today", "2026-11-22", "2026-13-01T00:00:00Z", "2025-02-29T00:00:00Z",
        "2026-11-22T11:57:39", "2026-11-22T25:00:00Z"}) {
    EXPECT_THROW(utc_time(wrong, "x"), InputError) << wrong;
  }
}

}  // namespace
}  // namespace occlab::history
