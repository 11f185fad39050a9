#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "harness/shards.h"

namespace occlab {

/// One piece of a run's work, as 'occlab status' knows it.
struct PlannedWork {
  std::string id;    ///< of the cell
  std::string what;  ///< "s3ho samples=16 seed=3"
  double cost = 1.0;
};

/// Writes RESULTS/progress/, which 'occlab status' reads:
///
///     plan-HASH.json     the work in its order; written once by whoever comes first
///     shard-I-of-N.json  what a shard is at, or ended with; run.json for a run that is no shard
///
/// Nothing else reads these files, and a run goes on where they cannot be written. A run that has
/// nothing to do leaves them as they are.
class WorkLog {
 public:
  WorkLog(const std::filesystem::path& results, std::vector<PlannedWork> plan,
          std::optional<Shard> shard);
  WorkLog(const WorkLog&) = delete;
  WorkLog& operator=(const WorkLog&) = delete;

  /// Of the planned costs, `cost_before` were finished when this process came. Once is enough.
  void begin(double cost_before = 0.0);
  /// `done` of the `planned` costs are finished, `next` begins. Written at most once in ten
  /// seconds.
  void update(double cost_done, double cost_planned, const std::string& next);
  /// What it came to: "rendered", "finished", "failed", "interrupted". May be called by another
  /// thread.
  void end(const std::string& state, const std::string& message = {});

  /// The state that an earlier process has left in the log.
  bool was(const std::string& state) const;

  /// What the process that writes this log has a lock of as long as it lives (work_locks.h).
  std::string life() const { return life_of(path_.filename().string()); }
  static std::string life_of(const std::string& file_name);

 private:
  void write_first();
  void write();

  std::filesystem::path folder_;
  std::filesystem::path path_;
  std::vector<PlannedWork> plan_;
  std::mutex mutex_;
  bool begun_ = false;
  nlohmann::json log_;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point written_;
};

}  // namespace occlab
