#include "harness/work_log.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <system_error>

#include "harness/files.h"
#include "renderers/scene/limited_json.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;
using Seconds = std::chrono::duration<double>;

constexpr Seconds between_writes(10.0);

std::string host() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

/// Complete or not at all, but not synced: it is worth nothing after a crash of the machine.
void write_quietly(const fs::path& path, const json& document) {
  const fs::path temporary =
      path.parent_path() / fmt::format(".{}.{}.{}", path.filename().string(), host(), ::getpid());
  std::error_code ignored;
  {
    std::ofstream file(temporary, std::ios::binary);
    file << document.dump(1, ' ', false, json::error_handler_t::replace) << '\n';
    if (!file.flush()) {
      fs::remove(temporary, ignored);
      return;
    }
  }
  fs::rename(temporary, path, ignored);
  if (ignored) fs::remove(temporary, ignored);
}

json plan_as_json(const std::vector<PlannedWork>& plan) {
  json items = json::array();
  for (const PlannedWork& work : plan) {
    items.push_back({{"id", work.id}, {"what", work.what}, {"cost", work.cost}});
  }
  return items;
}

/// The job of a batch system that this process is, where it says so.
std::string job_name() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return std::string(value ? value : "");
  };
  const std::string array = variable("SLURM_ARRAY_JOB_ID");
  if (!array.empty()) return array + "_" + variable("SLURM_ARRAY_TASK_ID");
  return variable("SLURM_JOB_ID");
}

/// The state that a log was left in, "" where there is none.
std::string stored_state(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  const json stored = parse_limited_json_or_discard(
      std::string(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()));
  return stored.is_object() ? stored.value("state", "") : "";
}

}  // namespace

WorkLog::WorkLog(const fs::path& results, std::vector<PlannedWork> plan, std::optional<Shard> shard)
    : folder_(results / "progress"),
      path_(folder_ / (shard ? fmt::format("shard-{}-of-{}.json", shard->index + 1, shard->count)
                             : std::string("run.json"))),
      plan_(std::move(plan)),
      start_(std::chrono::steady_clock::now()) {
  log_ = {{"format", 1},
          {"host", host()},
          {"process", ::getpid()},
          {"job", job_name()},
          {"started", fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)))},
          {"state", "running"},
          {"message", ""},
          {"seconds", 0.0},
          {"cost_done", 0.0},
          {"cost_planned", 0.0},
          {"now", ""}};
  log_["shard"] = shard ? json::array({shard->index + 1, shard->count}) : json();
}

std::string WorkLog::life_of(const std::string& file_name) {
  return sha256_text("the process of " + file_name);
}

void WorkLog::begin(double cost_before) {
  const std::lock_guard lock(mutex_);
  if (begun_) return;
  log_["cost_before"] = cost_before;
  write_first();
}

bool WorkLog::was(const std::string& state) const { return stored_state(path_) == state; }

void WorkLog::write_first() {
  std::error_code ignored;
  fs::create_directories(folder_, ignored);
  const json work = plan_as_json(plan_);
  const std::string hash = sha256_text(work.dump()).substr(0, 16);
  const fs::path plan_path = folder_ / fmt::format("plan-{}.json", hash);
  if (!fs::exists(plan_path, ignored)) write_quietly(plan_path, {{"format", 1}, {"work", work}});
  log_["plan"] = hash;
  begun_ = true;
  write();
}

void WorkLog::update(double cost_done, double cost_planned, const std::string& next) {
  const std::lock_guard lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  log_["seconds"] = Seconds(now - start_).count();
  log_["cost_done"] = cost_done;
  log_["cost_planned"] = cost_planned;
  log_["now"] = next;
  if (begun_ && now - written_ >= between_writes) write();
}

void WorkLog::end(const std::string& state, const std::string& message) {
  const std::lock_guard lock(mutex_);
  if (!begun_) {
    if (was(state)) return;
    write_first();
  }
  log_["state"] = state;
  log_["message"] = message;
  log_["now"] = "";
  log_["seconds"] = Seconds(std::chrono::steady_clock::now() - start_).count();
  write();
}

void WorkLog::write() {
  written_ = std::chrono::steady_clock::now();
  write_quietly(path_, log_);
}

}  // namespace occlab
