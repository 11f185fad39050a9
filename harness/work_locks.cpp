#include "harness/work_locks.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cassert>
#include <cerrno>
#include <cstring>
#include <thread>
#include <utility>

#include "renderers/scene/error.h"
#include "renderers/scene/interrupt.h"

namespace occlab {
namespace {

constexpr std::chrono::milliseconds between_looks(50);

/// 0 or the reason. Locks of the open file rather than of the process: two stores in one process
/// exclude each other too.
int lock_byte(int descriptor, short kind, long long offset) {
  struct flock lock {};
  lock.l_type = kind;
  lock.l_whence = SEEK_SET;
  lock.l_start = offset;
  lock.l_len = 1;
  while (::fcntl(descriptor, F_OFD_SETLK, &lock) != 0) {
    if (errno != EINTR) return errno;
  }
  return 0;
}

long long offset_of(const std::string& hash) {
  assert(hash.size() >= 15);
  return std::stoll(hash.substr(0, 15), nullptr, 16);  // below 2^60
}

}  // namespace

WorkLocks::Lock::Lock(Lock&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), offset_(other.offset_) {}

WorkLocks::Lock::~Lock() {
  if (descriptor_ >= 0) lock_byte(descriptor_, F_UNLCK, offset_);
}

WorkLocks::WorkLocks(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "locks";
  descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor_ < 0) {
    throw DeviceError(fmt::format("{}: cannot be opened: {}", path.string(), std::strerror(errno)));
  }
}

WorkLocks::~WorkLocks() { ::close(descriptor_); }

std::optional<WorkLocks::Lock> WorkLocks::take(const std::string& hash) const {
  const long long offset = offset_of(hash);
  const int reason = lock_byte(descriptor_, F_WRLCK, offset);
  if (reason == EAGAIN || reason == EACCES) return std::nullopt;
  return Lock(reason == 0 ? descriptor_ : -1, offset);
}

std::optional<bool> WorkLocks::taken(const std::filesystem::path& folder, const std::string& hash) {
  const int descriptor = ::open((folder / "locks").c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return std::nullopt;
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  lock.l_start = offset_of(hash);
  lock.l_len = 1;
  const bool known = ::fcntl(descriptor, F_OFD_GETLK, &lock) == 0;
  ::close(descriptor);
  return known ? std::optional(lock.l_type != F_UNLCK) : std::nullopt;
}

std::optional<WorkLocks::Lock> WorkLocks::wait(const std::string& hash,
                                               std::chrono::seconds patience,
                                               const std::function<bool()>& needless) const {
  const auto end = std::chrono::steady_clock::now() + patience;
  for (;;) {
    if (auto lock = take(hash)) return lock;
    if (needless() || std::chrono::steady_clock::now() >= end) return std::nullopt;
    throw_if_interrupted();
    std::this_thread::sleep_for(between_looks);
  }
}

}  // namespace occlab
