#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "harness/shards.h"

namespace occlab {

/// One process's part of a run.
struct ShardStatus {
  Shard shard;
  /// "rendered" (all its cells are there), "running", "queued", "not started"; and what ended
  /// early: "interrupted", "failed", "died" (without a last word), "incomplete" (cells were lost
  /// later).
  std::string state;
  std::string message;  ///< of the error, why it waits, or the last line of its log
  std::size_t done = 0;
  std::size_t planned = 0;  ///< cells; 0 while no process has planned yet
  std::string host;
  std::string job;  ///< of a batch system
  std::optional<double> seconds_left;

  bool finished() const { return state == "rendered"; }
  bool ended_early() const;
};

struct RunStatus {
  std::size_t done = 0;
  std::size_t planned = 0;  ///< cells
  /// Of the run that measures: "not started", "running", "queued", "finished", "failed",
  /// "interrupted", "died".
  std::string collecting;
  std::string message;  ///< of collecting
  std::vector<ShardStatus> shards;
  std::optional<double> seconds_left;  ///< until all cells are rendered, as fast as now
};

/// What the processes over a results folder have done, from what they left there; where Slurm runs
/// them and can be asked, from its queue too. `shards`: of a submission, to list those that have
/// not begun. Reads no pixels. Throws InputError where no run has left a trace.
RunStatus read_status(const std::filesystem::path& results);

std::string status_text(const RunStatus& status);
nlohmann::json to_json(const RunStatus& status);

}  // namespace occlab
