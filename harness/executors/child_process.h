#pragma once

#include <string>
#include <vector>

namespace occlab {

struct ChildResult {
  int code = 0;  ///< exit code; 128 + N where signal N ended it
  std::string out;
  std::string err;
};

/// Runs a program, looked up on the PATH, with these arguments as they are: no shell reads them.
/// Waits for its end. Throws DeviceError if it cannot be started.
ChildResult run_child(const std::vector<std::string>& command);

/// `text` as one word of a POSIX shell, whatever is in it but NUL.
std::string shell_word(const std::string& text);

/// A program's message on one line: its lines without "PROGRAM: error: " in front, by "; ".
std::string one_line(const std::string& message);

}  // namespace occlab
