#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "harness/cell_watch.h"
#include "harness/claims.h"
#include "harness/shards.h"
#include "harness/store.h"
#include "harness/work_log.h"

namespace occlab {

/// A cell that a run needs and how it is made.
struct WorkItem {
  CellKey key;
  std::string what;            ///< for the terminal: "s3ho samples=16 seed=3"
  double cost = 1.0;           ///< above 0; only ratios matter
  std::function<void()> make;  ///< renders it and puts it into the store
};

struct WorkOptions {
  std::optional<Shard> shard;          ///< none: all of the work
  std::optional<double> cell_seconds;  ///< a limit for each item (cell_watch.h)
};

/// What a process does of a run's work, beside others on the same folder.
class SharedWork {
 public:
  /// `warn` is told of damaged cells.
  SharedWork(CellStore& store, std::vector<WorkItem> items, const WorkOptions& options,
             std::function<void(std::string)> warn);

  /// Makes what is missing of this process's share, in order. What another process is at is left to
  /// it and looked at again at the end. Returns how many were missing at first. Throws Interrupted
  /// and what making throws.
  std::size_t make_missing();
  /// Of the share.
  std::size_t finished() const;
  std::size_t planned() const { return share_.size(); }

  /// Waits for another process that measures and writes tables, for a long time, and keeps others
  /// from it.
  Claims::Claim collect();

  WorkLog& log() { return log_; }

 private:
  void make(const WorkItem& item);
  double cost_of_share() const;

  CellStore& store_;
  std::vector<WorkItem> items_;
  WorkOptions options_;
  std::vector<const WorkItem*> share_;
  std::function<void(std::string)> warn_;
  Claims claims_;
  WorkLog log_;
  std::optional<Claims::Claim> alive_;  ///< what 'occlab status' knows a live process by
  CellWatch watch_;
};

}  // namespace occlab
