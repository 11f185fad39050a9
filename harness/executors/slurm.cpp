#include "harness/executors/slurm.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <thread>

#include "harness/executors/child_process.h"
#include "harness/executors/slurm_queue.h"
#include "harness/files.h"
#include "harness/shards.h"
#include "harness/spawn.h"
#include "harness/status.h"
#include "harness/toml_reader.h"
#include "renderers/scene/error.h"
#include "renderers/scene/interrupt.h"
#include "renderers/scene/limited_json.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

fs::path slurm_folder(const fs::path& results) { return results / "slurm"; }

void write_submission(const SlurmRun& run, const SlurmSubmission& submission) {
  json tasks = json::object();
  for (const auto& [shard, job] : submission.tasks) tasks[std::to_string(shard)] = job;
  const json document = {{"format", 1},
                         {"key", submission.key},
                         {"shards", submission.shards},
                         {"tasks", tasks},
                         {"collect", submission.collect}};
  write_text_atomically(slurm_folder(run.results) / "submission.json", document.dump(2) + "\n");
}

/// The option that has a job print into RESULTS/slurm/NAME, `name` a pattern of sbatch's. In the
/// folder's own path a '%' stands for itself.
std::string output_option(const SlurmRun& run, const std::string& name) {
  std::string option = "--output=";
  for (const char letter : slurm_folder(run.results).string()) {
    option += letter;
    if (letter == '%') option += letter;
  }
  return option + "/" + name;
}

/// Runs sbatch; returns the job's id.
std::string submit_job(const SlurmRun& run, const SlurmSettings& settings,
                       std::vector<std::string> arguments, const fs::path& script) {
  std::vector<std::string> command = {"sbatch", "--parsable"};
  const auto add = [&](const char* option, const std::string& value) {
    if (!value.empty()) command.push_back(fmt::format("--{}={}", option, value));
  };
  add("partition", settings.partition);
  add("time", settings.time);
  add("gpus", settings.gpus);
  add("chdir", run.results.string());
  add("open-mode", "append");
  command.insert(command.end(), arguments.begin(), arguments.end());
  command.insert(command.end(), settings.options.begin(), settings.options.end());
  command.push_back(script.string());
  const ChildResult result = run_child(command);
  if (result.code != 0) {
    throw DeviceError(fmt::format("sbatch refuses the job: {}", one_line(result.err)));
  }
  const std::string id = result.out.substr(0, result.out.find_first_of(";\n"));  // "12;cluster"
  if (id.empty() || id.find_first_not_of("0123456789") != std::string::npos) {
    throw DeviceError(
        fmt::format("sbatch printed '{}' where a job's number is expected", one_line(result.out)));
  }
  return id;
}

fs::path write_script(const SlurmRun& run, const char* name, std::size_t shards) {
  create_folder(slurm_folder(run.results));
  const fs::path path = slurm_folder(run.results) / name;
  write_text_atomically(path, slurm_script(run, shards));
  return path;
}

/// Drops what processes on other work said of themselves: a shard of an experiment that was changed
/// since is not done because it once was.
void remove_states(const fs::path& results) {
  std::error_code error;
  std::vector<fs::path> states;
  for (const fs::directory_entry& entry : fs::directory_iterator(results / "progress", error)) {
    if (!entry.path().filename().string().starts_with("plan-")) states.push_back(entry.path());
  }
  for (const fs::path& state : states) fs::remove(state, error);
}

/// What is left to do of an earlier submission of the same run.
struct Left {
  std::vector<std::size_t> shards;  ///< to submit, from 1
  std::vector<std::size_t> queued;  ///< that are in the queue already
  bool collecting = false;          ///< the measuring job is
  bool finished = false;            ///< all of it
};

Left what_is_left(const SlurmRun& run, const std::optional<SlurmSubmission>& earlier,
                  std::size_t count) {
  Left left;
  if (!earlier) {
    for (std::size_t shard = 1; shard <= count; ++shard) left.shards.push_back(shard);
    return left;
  }
  const RunStatus status = read_status(run.results);
  for (const ShardStatus& shard : status.shards) {
    if (shard.finished()) continue;
    if (shard.state == "running" || shard.state == "queued") {
      left.queued.push_back(shard.shard.index + 1);
    } else {
      left.shards.push_back(shard.shard.index + 1);
    }
  }
  left.collecting = status.collecting == "running" || status.collecting == "queued";
  left.finished = left.shards.empty() && left.queued.empty() && status.collecting == "finished";
  return left;
}

}  // namespace

SlurmSettings read_slurm_settings(const fs::path& path) {
  const toml::table file = parse_toml(path, {});
  TomlTable root(file, "", path.string());
  TomlTable table = root.table("slurm");
  root.refuse_others();
  SlurmSettings settings;
  settings.partition = table.text("partition", "");
  settings.time = table.text("time", "");
  settings.gpus = table.text("gpus", "");
  settings.shards = std::size_t(table.integer("shards", 1, long(most_shards), 16));
  settings.at_once = std::size_t(table.integer("at_once", 0, long(most_shards), 0));
  if (table.has("options")) settings.options = table.words("options");
  table.refuse_others();
  return settings;
}

std::string slurm_script(const SlurmRun& run, std::size_t shards) {
  std::string text = "#!/bin/sh\n";
  text += shards > 0 ? "# Written by occlab: task I of the array renders shard I.\n"
                     : "# Written by occlab: measures and writes the tables when the shards are "
                       "done.\n";
  text += fmt::format("cd {} || exit 3\n", shell_word(run.folder.string()));
  // Otherwise this one job would render what many have left.
  if (shards == 0) {
    text += fmt::format("{} status {} --rendered || exit 3\n", shell_word(run.command.front()),
                        shell_word(run.results.string()));
  }
  text += "exec";
  for (std::size_t i = 0; i < run.command.size(); ++i) {
    text += " " + shell_word(run.command[i]);
    // Behind the verb, so that a "--" among the arguments does not matter.
    if (i == 1 && shards > 0) text += fmt::format(" --shard \"$SLURM_ARRAY_TASK_ID/{}\"", shards);
  }
  return text + "\n";
}

std::string array_indices(const std::vector<std::size_t>& indices) {
  std::string text;
  for (std::size_t i = 0; i < indices.size();) {
    std::size_t end = i;
    while (end + 1 < indices.size() && indices[end + 1] == indices[end] + 1) ++end;
    text += (text.empty() ? "" : ",") + std::to_string(indices[i]);
    if (end > i) text += "-" + std::to_string(indices[end]);
    i = end + 1;
  }
  return text;
}

std::optional<SlurmSubmission> read_submission(const fs::path& results) {
  const fs::path path = slurm_folder(results) / "submission.json";
  if (!fs::exists(path)) return std::nullopt;
  const json document = parse_limited_json_or_discard(read_text(path));
  try {
    SlurmSubmission submission{.key = document.at("key").get<std::string>(),
                               .shards = document.at("shards").get<std::size_t>(),
                               .tasks = {},
                               .collect = document.at("collect").get<std::string>()};
    for (const auto& [shard, job] : document.at("tasks").items()) {
      submission.tasks[std::stoul(shard)] = job.get<std::string>();
    }
    return submission;
  } catch (const std::exception&) {
    throw InputError(fmt::format("{}: not what occlab wrote; remove it to submit everything again",
                                 path.string()));
  }
}

SlurmSubmission submit(const SlurmRun& run, const SlurmSettings& settings) {
  if (!find_on_path("sbatch")) {
    throw DeviceError(
        "--executor slurm: there is no sbatch on the PATH; is this a machine of a Slurm cluster?");
  }
  if (run.results.string().find('\\') != std::string::npos) {
    throw InputError(fmt::format(
        "--out {}: sbatch cannot be given a path with a backslash for what its jobs print",
        run.results.string()));
  }
  create_folder(slurm_folder(run.results));
  std::optional<SlurmSubmission> earlier = read_submission(run.results);
  if (!earlier || earlier->key != run.key || earlier->shards != settings.shards) {
    earlier.reset();
    remove_states(run.results);
  }
  const Left left = what_is_left(run, earlier, settings.shards);
  SlurmSubmission submission{.key = run.key, .shards = settings.shards, .tasks = {}, .collect = ""};
  if (earlier) submission = *earlier;
  if (left.finished) {
    fmt::print(stderr, "{}: everything is done\n", run.results.string());
    return submission;
  }
  if (!left.queued.empty()) {
    fmt::print(stderr, "in the queue already: shards {} of {}\n", array_indices(left.queued),
               settings.shards);
  }
  if (left.shards.empty() && left.collecting) return submission;

  const std::string name = "occlab-" + run.name;
  std::vector<std::string> before;  // the jobs after which it is measured
  for (const std::size_t shard : left.queued) before.push_back(submission.tasks[shard]);
  std::string array;
  if (!left.shards.empty()) {
    std::string indices = array_indices(left.shards);
    if (settings.at_once > 0) indices += fmt::format("%{}", settings.at_once);
    array =
        submit_job(run, settings,
                   {"--job-name=" + name, "--array=" + indices, output_option(run, "shard-%a.log")},
                   write_script(run, "shard.sh", settings.shards));
    for (const std::size_t shard : left.shards) {
      submission.tasks[shard] = fmt::format("{}_{}", array, shard);
    }
    fmt::print("array job {}: shards {} of {}\n", array, indices, settings.shards);
  }
  if (!array.empty()) before.push_back(array);
  std::vector<std::string> measuring = {"--job-name=" + name, output_option(run, "collect.log")};
  if (!before.empty()) {
    measuring.push_back(fmt::format("--dependency=afterany:{}", fmt::join(before, ":")));
  }
  if (left.collecting) run_child({"scancel", earlier->collect});
  try {
    submission.collect =
        submit_job(run, settings, std::move(measuring), write_script(run, "collect.sh", 0));
  } catch (const DeviceError& error) {
    if (!array.empty()) run_child({"scancel", array});
    throw DeviceError(
        fmt::format("{} (the one that measures; the array job was taken back)", error.what()));
  }
  fmt::print("job {} measures when they have ended\n", submission.collect);
  std::fflush(stdout);
  write_submission(run, submission);
  return submission;
}

void wait_for_jobs(const SlurmRun& run, const SlurmSubmission& submission) {
  constexpr std::chrono::milliseconds between_looks(500);
  constexpr int looks_between_lines = 20;
  const auto in_queue = [&] {
    const auto queue = slurm_queue();
    return queue.contains(submission.collect) ||
           std::ranges::any_of(submission.tasks,
                               [&](const auto& task) { return queue.contains(task.second); });
  };
  for (int look = 0; in_queue(); ++look) {
    if (look % looks_between_lines == 0) {
      const std::string text = status_text(read_status(run.results));
      fmt::print(stderr, "{}\n", text.substr(0, text.find('\n')));
    }
    std::this_thread::sleep_for(between_looks);
    try {
      throw_if_interrupted();
    } catch (const Interrupted&) {
      throw Interrupted(fmt::format("interrupted; the jobs go on; 'occlab status {}' follows them",
                                    run.results.string()));
    }
  }
  const RunStatus status = read_status(run.results);
  if (status.collecting == "finished") return;
  std::string failures;
  for (const ShardStatus& shard : status.shards) {
    if (!shard.ended_early()) continue;
    failures += fmt::format("; shard {} {}: {}", to_string(shard.shard), shard.state,
                            shard.message.empty() ? "no message" : shard.message);
    if (failures.size() > 400) break;
  }
  throw DeviceError(fmt::format(
      "the jobs have ended and the run is not finished: measuring {}{}{}; the same command goes on",
      status.collecting, status.message.empty() ? "" : ": " + status.message, failures));
}

}  // namespace occlab
