#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "harness/store.h"

namespace occlab {

/// Stores cells on a thread of its own, so that rendering goes on while the disk is waited for; on
/// the caller's where there is to be one thread (thread_count() of parallel.h).
class CellWriter {
 public:
  explicit CellWriter(CellStore& store);
  /// Waits for what is still to be stored.
  ~CellWriter();
  CellWriter(const CellWriter&) = delete;
  CellWriter& operator=(const CellWriter&) = delete;

  /// A cell is stored once so many others were given to write() after it.
  static constexpr std::size_t most_waiting = 64;

  /// CellStore::write(), some time before flush() returns. Waits while 256 MB or most_waiting cells
  /// are waiting. Throws what an earlier write has thrown; that cell is not stored, nor are those
  /// after it.
  void write(CellKey key, Layers layers, Metadata metadata, nlohmann::json extra);

  /// Waits until all is stored. Throws as write() does.
  void flush();

 private:
  struct Job {
    CellKey key;
    Layers layers;
    Metadata metadata;
    nlohmann::json extra;
    std::size_t bytes = 0;
  };
  void work(const std::stop_token& ended);
  void throw_failure();

  CellStore& store_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Job> jobs_;  ///< the first is being written
  std::size_t bytes_ = 0;
  std::exception_ptr failure_;
  std::jthread thread_;  ///< last: it uses all of the above; none: the caller stores
};

}  // namespace occlab
