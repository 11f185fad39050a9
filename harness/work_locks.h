#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace occlab {

/// Says to other processes on the same results folder what this one is working on, so that none
/// does the same needlessly. A lock is of one byte of FOLDER/locks, at an offset made of
/// the work's hash: it costs no file of its own, holds across machines where the file system's
/// locks do, and ends with its process, however that ends. Nothing depends on locks but time: the
/// cell store keeps what is finished first.
class WorkLocks {
 public:
  /// Held until it is destroyed.
  class Lock {
   public:
    Lock(Lock&& other) noexcept;
    ~Lock();
    Lock(const Lock&) = delete;
    Lock& operator=(const Lock&) = delete;
    Lock& operator=(Lock&&) = delete;
    /// False for nothing(), and where the file system has no locks.
    bool held() const { return descriptor_ >= 0; }

   private:
    friend class WorkLocks;
    Lock(int descriptor, long long offset) : descriptor_(descriptor), offset_(offset) {}
    int descriptor_;
    long long offset_;
  };

  /// Creates FOLDER/locks where needed. Throws DeviceError if it cannot be opened.
  explicit WorkLocks(const std::filesystem::path& folder);
  ~WorkLocks();
  WorkLocks(const WorkLocks&) = delete;
  WorkLocks& operator=(const WorkLocks&) = delete;

  /// Nothing while another process has the lock. `hash`: hex digits, at least 15. Where the file
  /// system has no locks every lock is given.
  std::optional<Lock> take(const std::string& hash) const;
  /// Whether another process has it, asked without opening the file for writing; nothing where the
  /// file or the file system's locks are not to be had.
  static std::optional<bool> taken(const std::filesystem::path& folder, const std::string& hash);
  /// A lock of nothing.
  static Lock nothing() { return {-1, 0}; }
  /// Takes it as soon as it is free; nothing if it is not within `patience`, or once `needless()`.
  /// Throws Interrupted.
  std::optional<Lock> wait(
      const std::string& hash, std::chrono::seconds patience,
      const std::function<bool()>& needless = [] { return false; }) const;

 private:
  int descriptor_ = -1;
};

}  // namespace occlab
