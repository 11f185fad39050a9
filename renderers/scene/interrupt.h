#pragma once

#include <stdexcept>

namespace occlab {

/// Ctrl-C or SIGTERM arrived. What was finished is kept; the same command goes on from there.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// From now on SIGINT and SIGTERM are remembered instead of ending the process; a second one ends
/// it.
void catch_interrupts();

/// Throws Interrupted once a signal has come. Long work calls it between its parts.
void throw_if_interrupted();

}  // namespace occlab
