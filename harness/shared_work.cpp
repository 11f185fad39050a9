#include "harness/shared_work.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <numeric>

#include "harness/cell_writer.h"
#include "harness/progress.h"
#include "renderers/scene/interrupt.h"
#include "renderers/scene/parallel.h"

namespace occlab {
namespace {

// A process that died has lost its locks; one on a machine that died may keep them for a while.
// After that the work is done twice, which costs time and nothing else.
constexpr std::chrono::seconds patience_for_a_cell(120);
constexpr std::chrono::seconds patience_for_the_tables(3600);

std::vector<PlannedWork> planned_work(const std::vector<WorkItem>& items) {
  std::vector<PlannedWork> plan;
  for (const WorkItem& item : items) plan.push_back({item.key.id(), item.what, item.cost});
  return plan;
}

std::vector<const WorkItem*> share_of(const std::vector<WorkItem>& items,
                                      const std::optional<Shard>& shard) {
  const Shard wanted = shard.value_or(Shard{});
  std::vector<double> costs;
  for (const WorkItem& item : items) costs.push_back(item.cost);
  const std::vector<std::size_t> shards = share_out(costs, wanted.count);
  std::vector<const WorkItem*> share;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (shards[i] == wanted.index) share.push_back(&items[i]);
  }
  return share;
}

}  // namespace

SharedWork::SharedWork(CellStore& store, std::vector<WorkItem> items, const WorkOptions& options,
                       std::function<void(std::string)> warn)
    : store_(store),
      items_(std::move(items)),
      options_(options),
      share_(share_of(items_, options.shard)),
      warn_(std::move(warn)),
      locks_(store.folder()),
      log_(store.folder(), planned_work(items_), options.shard),
      watch_(options.cell_seconds,
             [this](const std::string& message) { say_last_words(message); }) {
  show_alive();
}

std::size_t SharedWork::make_missing() {
  const auto start = std::chrono::steady_clock::now();
  std::vector<char> finished(share_.size());
  parallel_for(share_.size(), [&](std::size_t i) { finished[i] = store_.has(share_[i]->key); });
  std::vector<const WorkItem*> missing;
  for (std::size_t i = 0; i < share_.size(); ++i) {
    const WorkItem* const item = share_[i];
    if (finished[i]) continue;
    const std::string damage = store_.read(item->key).warning;
    if (!damage.empty()) warn_(damage);
    missing.push_back(item);
  }
  const std::string of_all =
      options_.shard
          ? fmt::format("shard {} of {} cells: ", to_string(*options_.shard), items_.size())
          : "";
  const std::chrono::duration<double> looking = std::chrono::steady_clock::now() - start;
  fmt::print(stderr, "{}{} cells, {} to render (looked for in {:.2f} s)\n", of_all, share_.size(),
             missing.size(), looking.count());

  if (missing.empty()) {
    if (!log_.was("finished")) begin_measuring();
    return 0;
  }
  const double planned = cost_of_share();
  double done = planned;
  for (const WorkItem* item : missing) done -= item->cost;
  log_.begin(done);
  Progress progress("rendering", missing.size());
  std::vector<const WorkItem*> elsewhere;
  std::size_t at = 0;
  for (const WorkItem* item : missing) {
    throw_if_interrupted();
    progress.update(at, item->what);
    log_.update(done, planned, item->what);
    show_alive();
    if (auto lock = locks_.take(item->key.hash())) {
      make(*item);
      keep(std::move(*lock));
      done += item->cost;
      ++at;
    } else {
      elsewhere.push_back(item);
    }
  }
  for (const WorkItem* item : elsewhere) {
    progress.update(at++, item->what + " (waiting for another process)");
    auto lock =
        locks_.wait(item->key.hash(), patience_for_a_cell, [&] { return store_.has(item->key); });
    make(*item);
    if (lock) keep(std::move(*lock));
    done += item->cost;
  }
  log_.update(done, planned, "");
  return missing.size();
}

void SharedWork::make(const WorkItem& item) {
  if (store_.has(item.key)) return;  // another process has finished it meanwhile
  watch_.during(fmt::format("cell {}, {}", item.key.id(), item.what), item.make);
}

/// Another process that writes the same log may have ended since.
void SharedWork::show_alive() {
  if (alive_) return;
  if (auto lock = locks_.take(log_.life())) alive_.emplace(std::move(*lock));
}

/// Others may think a cell missing until it is stored, which is some time after it was made.
void SharedWork::keep(WorkLocks::Lock lock) {
  kept_.push_back(std::move(lock));
  if (kept_.size() <= CellWriter::most_waiting) return;
  kept_.pop_front();
}

void SharedWork::settle() {
  options_.flush();
  kept_.clear();
}

void SharedWork::say_last_words(const std::string& message) {
  try {
    options_.flush();
  } catch (const std::exception& error) {
    warn_(error.what());
  }
  log_.end("failed", message);
}

std::size_t SharedWork::finished() const {
  return std::size_t(
      std::ranges::count_if(share_, [&](const WorkItem* item) { return store_.has(item->key); }));
}

WorkLocks::Lock SharedWork::collect() {
  const std::string hash = sha256_text("measurements and tables");
  if (auto lock = locks_.take(hash)) return std::move(*lock);
  fmt::print(stderr, "another process measures in {}; waiting for it\n", store_.folder().string());
  if (auto lock = locks_.wait(hash, patience_for_the_tables)) return std::move(*lock);
  warn_(fmt::format("another process has measured in {} for an hour; not waiting for it any longer",
                    store_.folder().string()));
  return WorkLocks::nothing();
}

double SharedWork::cost_of_share() const {
  return std::accumulate(share_.begin(), share_.end(), 0.0,
                         [](double sum, const WorkItem* item) { return sum + item->cost; });
}

}  // namespace occlab
