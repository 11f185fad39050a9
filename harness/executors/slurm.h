#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace occlab {

// A run on a Slurm cluster: an array job of which each task renders one shard, and a job after it
// that measures. Everything goes through sbatch, squeue and scancel; no text of a file or of the
// command line is read by a shell.

/// What sbatch is told; empty: what the cluster does without it.
struct SlurmSettings {
  std::string partition;
  std::string time;  ///< as sbatch has it: minutes, or [DAYS-]HOURS:MINUTES:SECONDS
  std::string gpus;  ///< of each task: a number, or TYPE:NUMBER
  std::size_t shards = 16;
  std::size_t at_once = 0;           ///< tasks that run at the same time; 0: as many as fit
  std::vector<std::string> options;  ///< further arguments of sbatch, "--account=light"
};

/// The table [slurm] of a TOML file, with the members of SlurmSettings as keys. Throws InputError.
SlurmSettings read_slurm_settings(const std::filesystem::path& path);

/// What the jobs run.
struct SlurmRun {
  std::filesystem::path results;     ///< absolute; the scripts and logs are in RESULTS/slurm
  std::filesystem::path folder;      ///< the current folder of the jobs
  std::vector<std::string> command;  ///< "occlab", "run", ... with neither shard nor executor
  std::string name;                  ///< of the experiment
  std::string key;  ///< of experiment and code: what another one left is no part of this run
};

/// What RESULTS/slurm/submission.json holds.
struct SlurmSubmission {
  std::string key;
  std::size_t shards = 0;
  std::map<std::size_t, std::string> tasks;  ///< by shard, from 1: the last job "12_3"
  std::string collect;                       ///< the last job that measures
};
std::optional<SlurmSubmission> read_submission(const std::filesystem::path& results);

/// The bash script of the array's tasks, or with 0 shards of the job that measures.
std::string slurm_script(const SlurmRun& run, std::size_t shards);

/// "1-4,7": array indices in rising order.
std::string array_indices(const std::vector<std::size_t>& indices);

/// Submits the shards that are neither finished nor in the queue, and a job that measures after
/// all of them. Prints what it submits; nothing to do is said, too. Throws DeviceError when Slurm
/// is not there or refuses, with its words.
SlurmSubmission submit(const SlurmRun& run, const SlurmSettings& settings);

/// Prints the progress until none of the jobs is in the queue. Throws DeviceError where the run is
/// not finished then, saying what failed, and Interrupted; the jobs go on then.
void wait_for_jobs(const SlurmRun& run, const SlurmSubmission& submission);

}  // namespace occlab
