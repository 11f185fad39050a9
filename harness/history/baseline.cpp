#include "harness/history/baseline.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "harness/history/git.h"
#include "renderers/scene/error.h"

namespace occlab::history {
namespace {

constexpr std::string_view dirty = "-dirty";
constexpr std::size_t most_other_groups = 20;  // the last ones: enough to know how times vary

std::string clean(std::string commit) {
  if (commit.ends_with(dirty)) commit.resize(commit.size() - dirty.size());
  return commit;
}

std::vector<StoredRun> of_experiment(std::vector<StoredRun> runs, const std::string& experiment) {
  std::erase_if(runs, [&](const StoredRun& run) { return run.experiment != experiment; });
  return runs;
}

/// Equal for runs that repeat each other: of one commit, and, as one "-dirty" commit may be many
/// programs and a name many experiments, of the same sources and settings.
std::string repetition_of(const RunData& run) {
  const nlohmann::json& facts = run.facts.run;
  std::string text = run.facts.commit;
  for (const char* fact : {"code", "configuration"}) {
    if (facts.is_object()) text += facts.value(fact, nlohmann::json()).dump();
  }
  return text;
}

/// The run `first` and those of `runs` that repeat it.
ChosenBaseline baseline_of(const Sqlite& database, const std::vector<StoredRun>& runs,
                           std::int64_t first) {
  ChosenBaseline chosen;
  std::vector<StoredRun> ordered = runs;
  std::stable_partition(ordered.begin(), ordered.end(),
                        [&](const StoredRun& run) { return run.id == first; });
  for (const StoredRun& run : ordered) {
    RunData data = read_run(database, run);
    if (chosen.side.runs.empty() ||
        repetition_of(data) == repetition_of(chosen.side.runs.front())) {
      chosen.side.runs.push_back(std::move(data));
    }
  }
  std::vector<StoredRun> all = of_experiment(list_runs(database), runs.front().experiment);
  std::ranges::reverse(all);
  std::vector<std::string> groups;
  for (const StoredRun& run : all) {
    if (run.commit == runs.front().commit) continue;
    if (std::ranges::count(all, run.commit, &StoredRun::commit) < 2) continue;
    RunData data = read_run(database, run);
    auto place = std::ranges::find(groups, repetition_of(data));
    if (place == groups.end()) {
      if (groups.size() == most_other_groups) break;
      place = groups.insert(groups.end(), repetition_of(data));
      chosen.others.emplace_back();
    }
    chosen.others[std::size_t(place - groups.begin())].push_back(std::move(data));
  }
  return chosen;
}

[[noreturn]] void refuse(const Sqlite* database, const std::string& against,
                         const std::string& experiment) {
  if (!database) {
    throw InputError(fmt::format(
        "--against {}: there is no such results folder or file, and no history (--db) "
        "to look it up in; 'occlab history add' begins one, and --accept --why TEXT makes "
        "these results the first baseline",
        against));
  }
  std::set<std::string> known;
  for (const Baseline& baseline : list_baselines(*database)) {
    if (baseline.experiment == experiment) known.insert(baseline.name);
  }
  for (const StoredRun& run : of_experiment(list_runs(*database), experiment)) {
    if (known.size() < 12) known.insert(run.commit);
  }
  throw InputError(fmt::format(
      "--against {}: {} has no baseline and no run of that name for the experiment '{}'; {}",
      against, database->path().string(), experiment,
      known.empty() ? "it has none at all: the first is accepted with --accept --why TEXT"
                    : fmt::format("there are: {}", fmt::join(known, ", "))));
}

ChosenBaseline choose_one(const Sqlite* database, const std::string& against,
                          const std::string& experiment) {
  if (database) {
    if (const auto baseline = current_baseline(*database, against, experiment)) {
      const std::vector<StoredRun> all = of_experiment(list_runs(*database), experiment);
      const auto accepted = std::ranges::find(all, baseline->run, &StoredRun::id);
      if (accepted != all.end()) {
        std::vector<StoredRun> runs = all;
        std::erase_if(runs, [&](const StoredRun& r) { return r.commit != accepted->commit; });
        return baseline_of(*database, runs, baseline->run);
      }
    }
  }
  if (is_results(against)) return {{{read_results(against)}}, {}};
  if (database) {
    const std::vector<StoredRun> runs = of_experiment(runs_named(*database, against), experiment);
    if (!runs.empty()) return baseline_of(*database, runs, runs.front().id);
  }
  refuse(database, against, experiment);
}

}  // namespace

void complete_commit(RunFacts& facts) {
  if (facts.commit.empty()) {
    if (const auto head = find_commit("HEAD")) facts.commit = head->hash;
  }
  if (facts.commit.empty()) {
    throw InputError(
        "--commit: the run does not say which commit it is of, and the current folder is no git "
        "repository: give the commit");
  }
  if (!facts.subject.empty() && !facts.commit_time.empty()) return;
  const auto known = find_commit(clean(facts.commit));
  if (!known) return;
  if (facts.subject.empty()) facts.subject = known->subject;
  if (facts.commit_time.empty()) facts.commit_time = known->time;
}

ChosenBaseline choose_baseline(const Sqlite* database, const std::vector<std::string>& against,
                               const std::string& experiment) {
  if (against.size() == 1) return choose_one(database, against.front(), experiment);
  ChosenBaseline chosen;
  chosen.side.runs = read_each_once(against);
  return chosen;
}

}  // namespace occlab::history
