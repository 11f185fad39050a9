#include "harness/verbs/executor.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "harness/executors/slurm.h"
#include "harness/files.h"
#include "harness/shards.h"
#include "harness/version.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

const std::vector<std::pair<std::string, bool>> executor_options = {
    {"--executor", true},      {"--slurm", true},        {"--slurm-partition", true},
    {"--slurm-time", true},    {"--slurm-gpus", true},   {"--slurm-shards", true},
    {"--slurm-at-once", true}, {"--slurm-option", true}, {"--wait", false},
};

/// The arguments of this process, the program's own path in front.
std::vector<std::string> own_command() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  std::vector<std::string> command;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\0', at), text.size());
    command.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error || command.empty() || !fs::exists(program)) {
    throw DeviceError("--executor slurm: this program's own file is not to be found (/proc)");
  }
  command.front() = program.string();
  return command;
}

SlurmSettings settings_of(const ExecutorOptions& options) {
  SlurmSettings settings;
  if (options.settings) settings = read_slurm_settings(*options.settings);
  if (options.partition) settings.partition = *options.partition;
  if (options.time) settings.time = *options.time;
  if (options.gpus) settings.gpus = *options.gpus;
  if (options.shards) settings.shards = *options.shards;
  if (options.at_once) settings.at_once = *options.at_once;
  settings.options.insert(settings.options.end(), options.options.begin(), options.options.end());
  for (const std::string& option : settings.options) {
    if (option.starts_with("-")) continue;
    throw InputError(fmt::format(
        "slurm options: '{}' is no option of sbatch; accepted: one argument each, such as "
        "--account=NAME",
        option));
  }
  return settings;
}

}  // namespace

std::vector<std::string> without_options(const std::vector<std::string>& command,
                                         const std::vector<std::pair<std::string, bool>>& known) {
  std::vector<std::string> kept;
  for (std::size_t i = 0; i < command.size(); ++i) {
    const std::string name = command[i].substr(0, command[i].find('='));
    const auto option = std::ranges::find_if(known, [&](const auto& o) { return o.first == name; });
    if (i == 0 || option == known.end()) {
      kept.push_back(command[i]);
    } else if (option->second && name == command[i]) {
      ++i;  // its value is the next argument
    }
  }
  return kept;
}

void add_executor_options(CLI::App& verb, ExecutorOptions& options) {
  verb.add_option("--executor", options.executor,
                  "local, or slurm: submit an array job of shards and one that measures after it")
      ->check(CLI::IsMember({"local", "slurm"}))
      ->capture_default_str();
  verb.add_option("--slurm", options.settings,
                  "a TOML file with a table [slurm] (configs/FORMAT.md); the options below win");
  verb.add_option("--slurm-partition", options.partition, "the partition; default: Slurm's");
  verb.add_option("--slurm-time", options.time, "time limit of a job, as sbatch has it");
  verb.add_option("--slurm-gpus", options.gpus, "GPUs of a task: a number, or TYPE:NUMBER");
  verb.add_option("--slurm-shards", options.shards, "tasks of the array; default: 16")
      ->check(CLI::Range(std::size_t(1), most_shards));
  verb.add_option("--slurm-at-once", options.at_once, "tasks at the same time; default: all")
      ->check(CLI::Range(std::size_t(1), most_shards));
  verb.add_option("--slurm-option", options.options,
                  "one more argument of sbatch, as it is: --slurm-option=--account=NAME")
      ->allow_extra_args(false);
  verb.add_flag("--wait", options.wait, "with slurm: until the jobs have ended");
}

bool on_cluster(const ExecutorOptions& options) {
  if (options.executor == "slurm") return true;
  if (options.settings || options.partition || options.time || options.gpus || options.shards ||
      options.at_once || !options.options.empty() || options.wait) {
    throw InputError("--slurm... and --wait: need --executor slurm");
  }
  return false;
}

void run_on_cluster(const Experiment& experiment, const fs::path& results,
                    const ExecutorOptions& options) {
  const SlurmSettings settings = settings_of(options);
  const SlurmRun run{.results = fs::absolute(results).lexically_normal(),
                     .folder = fs::current_path(),
                     .command = without_options(own_command(), executor_options),
                     .name = experiment.name,
                     .key = sha256_text(experiment.resolved + std::string(renderers_hash) +
                                        std::string(harness_hash))};
  for (const char* option : {"--shard", "--fresh"}) {
    if (std::ranges::any_of(run.command, [&](const std::string& word) {
          return word.substr(0, word.find('=')) == option;
        })) {
      throw InputError(fmt::format("{} cannot be combined with --executor slurm", option));
    }
  }
  const SlurmSubmission submission = submit(run, settings);
  if (options.wait) wait_for_jobs(run, submission);
}

}  // namespace occlab
