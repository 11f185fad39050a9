#include "harness/executors/slurm_queue.h"

#include <fmt/format.h>

#include <sstream>

#include "harness/executors/child_process.h"
#include "renderers/scene/error.h"

namespace occlab {

std::map<std::string, QueuedJob> parse_queue(const std::string& text) {
  std::map<std::string, QueuedJob> jobs;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t first = line.find('|');
    const std::size_t second = line.find('|', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string state = line.substr(first + 1, second - first - 1);
    jobs[line.substr(0, first)] = {state, line.substr(second + 1)};
  }
  return jobs;
}

std::map<std::string, QueuedJob> slurm_queue() {
  const ChildResult result =
      run_child({"squeue", "--me", "--array", "--noheader", "--format=%i|%T|%r"});
  if (result.code != 0) {
    throw DeviceError(fmt::format("squeue failed: {}", one_line(result.err)));
  }
  return parse_queue(result.out);
}

}  // namespace occlab
