#include "harness/cell_writer.h"

#include <utility>

#include "renderers/scene/parallel.h"

namespace occlab {
namespace {

constexpr std::size_t most_bytes = std::size_t(256) << 20;

}  // namespace

CellWriter::CellWriter(CellStore& store) : store_(store) {
  if (thread_count() == 1) return;
  thread_ = std::jthread([this](const std::stop_token& ended) { work(ended); });
}

CellWriter::~CellWriter() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return jobs_.empty(); });
}

void CellWriter::write(CellKey key, Layers layers, Metadata metadata, nlohmann::json extra) {
  if (!thread_.joinable()) {
    store_.write(key, layers, metadata, extra);
    return;
  }
  Job job{std::move(key), std::move(layers), std::move(metadata), std::move(extra)};
  for (const Layers::Layer& layer : job.layers.all()) {
    job.bytes += layer.image.values().size_bytes();
  }
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] {
    return jobs_.empty() || (bytes_ + job.bytes <= most_bytes && jobs_.size() < most_waiting);
  });
  throw_failure();
  bytes_ += job.bytes;
  jobs_.push_back(std::move(job));
  changed_.notify_all();
}

void CellWriter::flush() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return jobs_.empty(); });
  throw_failure();
}

void CellWriter::throw_failure() {
  if (failure_) std::rethrow_exception(failure_);
}

void CellWriter::work(const std::stop_token& ended) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, ended, [this] { return !jobs_.empty(); })) {
    const Job& job = jobs_.front();
    lock.unlock();
    std::exception_ptr failure;
    try {
      store_.write(job.key, job.layers, job.metadata, job.extra);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    bytes_ -= job.bytes;
    jobs_.pop_front();
    if (failure) {
      if (!failure_) failure_ = failure;
      bytes_ = 0;
      jobs_.clear();
    }
    changed_.notify_all();
  }
}

}  // namespace occlab
