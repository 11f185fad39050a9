#include "harness/status.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <numeric>
#include <set>

#include "harness/executors/child_process.h"
#include "harness/executors/slurm.h"
#include "harness/executors/slurm_queue.h"
#include "harness/files.h"
#include "harness/spawn.h"
#include "harness/work_locks.h"
#include "harness/work_log.h"
#include "renderers/scene/error.h"
#include "renderers/scene/limited_json.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

struct Work {
  std::string id;
  double cost = 0.0;
};

/// All that a results folder says of its processes.
struct Traces {
  std::vector<Work> plan;
  std::map<std::size_t, json> shards;  ///< by shard, from 0
  std::size_t count = 0;               ///< of shards
  json run;                            ///< of the run that is no shard; null where there is none
  std::set<std::string> cells;
  std::optional<SlurmSubmission> submission;
  std::map<std::string, QueuedJob> queue;
  bool asked = false;  ///< the queue
};

json read_json(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  json document = parse_limited_json_or_discard(
      std::string(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()));
  return document.is_object() ? document : json::object();
}

std::vector<Work> read_plan(const fs::path& path) {
  std::vector<Work> plan;
  for (const json& work : read_json(path).value("work", json::array())) {
    plan.push_back({work.value("id", ""), std::max(work.value("cost", 1.0), 1e-9)});
  }
  return plan;
}

/// The logs of the newest plan: those of an earlier experiment in the same folder are no part of
/// this run, nor are those of another number of shards.
void read_logs(const fs::path& results, Traces& traces) {
  std::vector<std::pair<fs::file_time_type, json>> logs;
  std::error_code error;
  for (fs::directory_iterator entry(results / "progress", error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name != "run.json" && !name.starts_with("shard-")) continue;
    json log = read_json(entry->path());
    if (!log.contains("plan")) continue;
    std::error_code ignored;
    logs.emplace_back(fs::last_write_time(entry->path(), ignored), std::move(log));
  }
  std::ranges::stable_sort(logs, [](const auto& a, const auto& b) { return a.first > b.first; });
  if (traces.submission) traces.count = traces.submission->shards;
  if (logs.empty()) return;
  const std::string plan = logs.front().second.value("plan", "");
  traces.plan = read_plan(results / "progress" / fmt::format("plan-{}.json", plan));
  for (auto& [time, log] : logs) {
    if (log.value("plan", "") != plan) continue;
    const json shard = log.value("shard", json());
    if (!shard.is_array()) {
      traces.run = std::move(log);
      continue;
    }
    const auto index = shard.at(0).get<std::size_t>();
    const auto count = shard.at(1).get<std::size_t>();
    if (traces.count == 0) traces.count = count;
    if (count == traces.count && index >= 1) traces.shards[index - 1] = std::move(log);
  }
}

std::set<std::string> cell_names(const fs::path& results) {
  std::set<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(results / "cells", error), end; !error && entry != end;
       entry.increment(error)) {
    names.insert(entry->path().filename().string());
  }
  return names;
}

Traces read_traces(const fs::path& results) {
  Traces traces;
  traces.submission = read_submission(results);
  read_logs(results, traces);
  traces.cells = cell_names(results);
  if (traces.submission && find_on_path("squeue")) {
    try {
      traces.queue = slurm_queue();
      traces.asked = true;
    } catch (const DeviceError&) {
      // Without the queue the logs alone have to do.
    }
  }
  return traces;
}

const QueuedJob* queued(const Traces& traces, const std::string& job) {
  const auto found = traces.queue.find(job);
  return found == traces.queue.end() ? nullptr : &found->second;
}

fs::path slurm_log(const fs::path& results, const json& shard) {
  return results / "slurm" /
         (shard.is_array() ? fmt::format("shard-{}.log", shard.at(0).get<std::size_t>())
                           : std::string("collect.log"));
}

/// The last line with anything on it that a job printed; "" if there is none.
std::string last_line(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  file.seekg(0, std::ios::end);
  const auto size = std::streamoff(file.tellg());
  file.seekg(std::max<std::streamoff>(0, size - 4096));
  std::string last;
  for (std::string line; std::getline(file, line);) {
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  }
  return last;
}

/// What became of the process that wrote a log; its message, where it left none from what it
/// printed under Slurm.
std::string state_of(const fs::path& results, const json& log, const std::string& name,
                     std::string& message) {
  std::string state = log.value("state", "");
  message = log.value("message", "");
  // Without locks nobody knows; the process may be on another machine.
  if (state == "running" && WorkLocks::taken(results, WorkLog::life_of(name + ".json")) == false) {
    state = "died";
    message = last_line(slurm_log(results, log.value("shard", json())));
  }
  return state;
}

/// How fast the process of a log goes, in costs a second; 0 where it is not known.
double rate_of(const json& log) {
  if (!log.is_object()) return 0.0;
  const double seconds = log.value("seconds", 0.0);
  const double made = log.value("cost_done", 0.0) - log.value("cost_before", 0.0);
  return seconds > 0.0 && made > 0.0 ? made / seconds : 0.0;
}

/// A shard that has no log, or one that ended: what the queue says of its last job.
void ask_queue(const Traces& traces, const fs::path& results, ShardStatus& status) {
  if (!traces.submission || status.finished() || status.state == "running") return;
  const auto task = traces.submission->tasks.find(status.shard.index + 1);
  if (task == traces.submission->tasks.end()) return;
  if (const QueuedJob* job = queued(traces, task->second)) {
    status.state = job->state == "PENDING" ? "queued" : "running";
    status.message = job->state == "PENDING" ? job->reason : "";
    status.job = task->second;
  } else if (traces.asked && status.state == "not started") {
    status.state = "died";
    status.job = task->second;
    status.message = last_line(slurm_log(results, {status.shard.index + 1, traces.count}));
  }
}

std::size_t count_missing(const Traces& traces) {
  return std::size_t(std::ranges::count_if(
      traces.plan, [&](const Work& work) { return !traces.cells.contains(work.id); }));
}

/// All shards with their cells; `left` gets the costs that each has before it.
std::vector<ShardStatus> planned_shards(const Traces& traces, std::vector<double>& left) {
  std::vector<ShardStatus> shards(traces.count);
  for (std::size_t index = 0; index < traces.count; ++index) {
    shards[index].shard = {index, traces.count};
  }
  std::vector<double> costs;
  for (const Work& work : traces.plan) costs.push_back(work.cost);
  const std::vector<std::size_t> shard_of = share_out(costs, left.size());
  for (std::size_t i = 0; i < traces.plan.size(); ++i) {
    const bool there = traces.cells.contains(traces.plan[i].id);
    if (!there) left[shard_of[i]] += costs[i];
    if (shards.empty()) continue;
    ++shards[shard_of[i]].planned;
    shards[shard_of[i]].done += there ? 1 : 0;
  }
  return shards;
}

void find_state(const Traces& traces, const fs::path& results, ShardStatus& shard) {
  const bool whole = !traces.plan.empty() && shard.done == shard.planned;
  shard.state = "not started";
  if (const auto log = traces.shards.find(shard.shard.index); log != traces.shards.end()) {
    shard.host = log->second.value("host", "");
    shard.job = log->second.value("job", "");
    const std::string name =
        fmt::format("shard-{}-of-{}", shard.shard.index + 1, shard.shard.count);
    shard.state = state_of(results, log->second, name, shard.message);
    if (shard.state == "rendered" && !whole) shard.state = "incomplete";
  }
  if (whole && shard.state != "running") {
    shard.state = "rendered";
    shard.message.clear();
  }
  ask_queue(traces, results, shard);
}

void find_collecting(const Traces& traces, const fs::path& results, RunStatus& status) {
  status.collecting = "not started";
  if (!traces.run.is_null()) {
    status.collecting = state_of(results, traces.run, "run", status.message);
  }
  if (!traces.submission || status.collecting == "running") return;
  if (const QueuedJob* job = queued(traces, traces.submission->collect)) {
    status.collecting = job->state == "PENDING" ? "queued" : "running";
    status.message = job->state == "PENDING" ? job->reason : "";
  } else if (traces.asked && status.collecting == "not started") {
    status.collecting = "failed";
    status.message = last_line(slurm_log(results, json()));
  }
}

RunStatus status_of(const fs::path& results) {
  const Traces traces = read_traces(results);
  if (traces.plan.empty() && !traces.submission) {
    throw InputError(fmt::format(
        "{}: no run has left its progress there; accepted: the folder of an 'occlab run'",
        results.string()));
  }
  RunStatus status;
  status.planned = traces.plan.size();
  std::vector<double> left(std::max<std::size_t>(traces.count, 1), 0.0);
  status.shards = planned_shards(traces, left);
  status.done = status.planned - count_missing(traces);
  double rate = 0.0;
  for (ShardStatus& shard : status.shards) {
    find_state(traces, results, shard);
    const auto log = traces.shards.find(shard.shard.index);
    if (shard.state != "running" || log == traces.shards.end()) continue;
    const double own = rate_of(log->second);
    rate += own;
    if (own > 0.0) shard.seconds_left = left[shard.shard.index] / own;
  }
  find_collecting(traces, results, status);
  if (status.collecting == "running") rate += rate_of(traces.run);
  const double all_left = std::accumulate(left.begin(), left.end(), 0.0);
  if (all_left > 0.0 && rate > 0.0) status.seconds_left = all_left / rate;
  return status;
}

}  // namespace

bool ShardStatus::ended_early() const {
  return state == "failed" || state == "interrupted" || state == "died" || state == "incomplete";
}

RunStatus read_status(const fs::path& results) {
  try {
    return status_of(results);
  } catch (const json::exception& error) {
    throw InputError(fmt::format("{}: not what occlab wrote: {}", (results / "progress").string(),
                                 error.what()));
  }
}

std::string status_text(const RunStatus& status) {
  const auto rendered = std::ranges::count_if(status.shards, &ShardStatus::finished);
  std::string text = fmt::format("{} of {} cells", status.done, status.planned);
  if (!status.shards.empty()) {
    text += fmt::format(", {} of {} shards", rendered, status.shards.size());
  }
  if (status.seconds_left) text += fmt::format(", about {:.0f} s left", *status.seconds_left);
  text += fmt::format("; measuring: {}", status.collecting);
  if (!status.message.empty()) text += fmt::format(" ({})", status.message);
  text += '\n';
  for (const ShardStatus& shard : status.shards) {
    std::string line =
        fmt::format("{:>9}  {:<12} {:>5} of {:<5} {:<10} {:<10}", to_string(shard.shard),
                    shard.state, shard.done, shard.planned, shard.job, shard.host);
    if (shard.seconds_left) line += fmt::format(" {:.0f} s left", *shard.seconds_left);
    if (!shard.message.empty()) line += " " + shard.message;
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  }
  return text;
}

json to_json(const RunStatus& status) {
  const auto seconds = [](const std::optional<double>& value) {
    return value ? json(*value) : json();
  };
  json shards = json::array();
  for (const ShardStatus& shard : status.shards) {
    shards.push_back({{"shard", to_string(shard.shard)},
                      {"state", shard.state},
                      {"message", shard.message},
                      {"cells_done", shard.done},
                      {"cells_planned", shard.planned},
                      {"host", shard.host},
                      {"job", shard.job},
                      {"seconds_left", seconds(shard.seconds_left)}});
  }
  return {{"cells_done", status.done},
          {"cells_planned", status.planned},
          {"measuring", status.collecting},
          {"message", status.message},
          {"seconds_left", seconds(status.seconds_left)},
          {"shards", shards}};
}

}  // namespace occlab
