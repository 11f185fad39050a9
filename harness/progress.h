#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace occlab {

/// "rendering 12/97 s3ho samples=16 (3 of 8), 41 s left": one rewritten line on a terminal, plain
/// lines of at most one in two seconds elsewhere. Goes to stderr.
class Progress {
 public:
  Progress(std::string what, std::size_t total);
  ~Progress();

  /// `done` of the total parts are finished, `next` begins.
  void update(std::size_t done, const std::string& next);

 private:
  std::string what_;
  std::size_t total_;
  bool terminal_;
  bool line_open_ = false;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point last_line_;
};

}  // namespace occlab
