#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "harness/history/series.h"

namespace occlab::history {

/// What a run says of itself.
struct RunFacts {
  std::string commit;       ///< "" if unknown; may end in "-dirty"
  std::string subject;      ///< of the commit, "" if unknown
  std::string commit_time;  ///< "2026-11-22T10:57:39Z", "" if unknown
  std::string experiment;
  std::string device;
  nlohmann::json run;  ///< run.json; null for bare measurements
};

/// One run: a results folder, a file of measurements or a run of the database.
struct RunData {
  std::string name;  ///< for messages: the folder, the file or "commit 1234 of history.sqlite"
  RunFacts facts;
  std::vector<SeriesValues> series;   ///< in order of appearance
  std::vector<std::string> left_out;  ///< rows that nothing tells apart, and other warnings
  std::string content;                ///< SHA-256 of what was read, "" from the database
};

/// "AMD EPYC, 2 threads" of run.json; "" where it says nothing of it.
std::string machine_of(const nlohmann::json& run);

/// Rows as series, in order of appearance. Rows of one series and seed that are there twice are
/// left out and said in `left_out`.
std::vector<SeriesValues> collect_series(const std::vector<Measurement>& rows,
                                         const std::string& machine,
                                         std::vector<std::string>& left_out);

/// A results folder (finished, with a run.json that belongs to its measurements.csv) or, where
/// `path` is a file, measurements alone. Throws InputError with what is wrong.
RunData read_results(const std::filesystem::path& path);

/// All of them, in order. Throws InputError where two are the same run: a run is no repetition of
/// itself.
std::vector<RunData> read_each_once(const std::vector<std::string>& paths);

/// Whether read_results would take it for one: a folder, or a file that is there.
bool is_results(const std::filesystem::path& path);

/// ISO 8601 with date, time and offset ("2026-11-22T11:57:39+01:00") in UTC as
/// "2026-11-22T10:57:39Z". Throws InputError beginning with `where`.
std::string utc_time(const std::string& iso, const std::string& where);
std::string now_utc();

}  // namespace occlab::history
