#include "renderers/scene/interrupt.h"

#include <csignal>

namespace occlab {
namespace {

volatile std::sig_atomic_t signal_received = 0;

extern "C" void remember_signal(int signal) {
  signal_received = signal;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void catch_interrupts() {
  std::signal(SIGINT, remember_signal);
  std::signal(SIGTERM, remember_signal);
}

void throw_if_interrupted() {
  if (signal_received) throw Interrupted("interrupted");
}

}  // namespace occlab
