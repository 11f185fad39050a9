#pragma once

#include <map>
#include <string>

namespace occlab {

struct QueuedJob {
  std::string state;   ///< as squeue has it: "PENDING", "RUNNING", ...
  std::string reason;  ///< why it waits: "Resources"
};

/// This user's jobs that have not ended, by id: "12_3" for a task of an array, "13" for a job.
/// Throws DeviceError when squeue is not there or fails.
std::map<std::string, QueuedJob> slurm_queue();

/// The jobs in what `squeue --array --noheader --format="%i|%T|%r"` prints.
std::map<std::string, QueuedJob> parse_queue(const std::string& text);

}  // namespace occlab
