#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

namespace occlab {

/// Says to other processes on the same results folder what this one is working on, so that none
/// does the same needlessly. A claim is a lock on one byte of FOLDER/claims, at an offset made of
/// the work's hash: it costs no file of its own, holds across machines where the file system's
/// locks do, and ends with its process, however that ends. Nothing depends on claims but time: the
/// cell store keeps what is finished first.
class Claims {
 public:
  /// Held until it is destroyed.
  class Claim {
   public:
    Claim(Claim&& other) noexcept;
    ~Claim();
    Claim(const Claim&) = delete;
    Claim& operator=(const Claim&) = delete;
    Claim& operator=(Claim&&) = delete;

   private:
    friend class Claims;
    Claim(int descriptor, long long offset) : descriptor_(descriptor), offset_(offset) {}
    int descriptor_;
    long long offset_;
  };

  /// Creates FOLDER/claims where needed. Throws DeviceError if it cannot be opened.
  explicit Claims(const std::filesystem::path& folder);
  ~Claims();
  Claims(const Claims&) = delete;
  Claims& operator=(const Claims&) = delete;

  /// Nothing while another process has the claim. `hash`: hex digits, at least 15. Where the file
  /// system has no locks every claim is given.
  std::optional<Claim> take(const std::string& hash) const;
  /// Whether another process has it, asked without opening the file for writing; nothing where the
  /// file or the file system's locks are not to be had.
  static std::optional<bool> taken(const std::filesystem::path& folder, const std::string& hash);
  /// A claim of nothing.
  static Claim nothing() { return {-1, 0}; }
  /// Takes it as soon as it is free; nothing if it is not within `patience`. Throws Interrupted.
  std::optional<Claim> wait(const std::string& hash, std::chrono::seconds patience) const;

 private:
  int descriptor_ = -1;
};

}  // namespace occlab
