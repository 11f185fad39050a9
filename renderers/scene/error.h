#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace occlab {

/// Process exit codes of every `occlab` verb.
enum ExitCode : int {
  exit_good = 0,
  exit_check_failed = 1,   ///< a check, claim or regression failed
  exit_bad_input = 2,      ///< bad usage or bad input
  exit_device_failed = 3,  ///< the graphics device or the machine failed
};

/// The user's input is wrong. The message names the file, the key or line, what was found and what
/// is accepted. Maps to exit code 2.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The graphics device, the disk or the machine failed. Maps to exit code 3.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// "; did you mean 'samples'? accepted: a, b, samples": the tail of an error about a word that is
/// not in `accepted`. The guess appears only when its edit distance is small.
std::string accepted_words(std::string_view found, std::span<const std::string> accepted);

}  // namespace occlab
