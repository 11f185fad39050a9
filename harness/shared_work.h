#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "harness/cell_watch.h"
#include "harness/shards.h"
#include "harness/store.h"
#include "harness/work_locks.h"
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
  std::function<void()> flush;         ///< waits until what the items made is stored
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
  /// Waits until what was made is stored, and lets others have it.
  void settle();
  /// Of the share.
  std::size_t finished() const;
  std::size_t planned() const { return share_.size(); }

  /// Waits for another process that measures and writes tables, for a long time, and keeps others
  /// from it.
  WorkLocks::Lock collect();

  /// Says in the log that the cells are all there and what comes after is at work.
  void begin_measuring() { log_.begin(cost_of_share()); }
  WorkLog& log() { return log_; }

 private:
  void make(const WorkItem& item);
  void show_alive();
  void keep(WorkLocks::Lock lock);
  void say_last_words(const std::string& message);
  double cost_of_share() const;

  CellStore& store_;
  std::vector<WorkItem> items_;
  WorkOptions options_;
  std::vector<const WorkItem*> share_;
  std::function<void(std::string)> warn_;
  WorkLocks locks_;
  WorkLog log_;
  std::optional<WorkLocks::Lock> alive_;  ///< what 'occlab status' knows a live process by
  std::deque<WorkLocks::Lock> kept_;      ///< of cells that may not be stored yet, oldest first
  CellWatch watch_;
};

}  // namespace occlab
