#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace occlab {

/// A time that a paper printed.
struct PublishedTime {
  std::string method;
  int width = 0;  ///< pixels
  int height = 0;
  std::string device;
  long samples = 0;
  long steps = 0;
  double time_ms = 0.0;
  std::string origin;  ///< where in the paper: "Table 1", "text of section 4"
  std::string remark;  ///< what contradicts it or is not stated; "" if nothing
};

struct PublishedTimes {
  std::string source;                ///< the paper
  std::vector<PublishedTime> times;  ///< those of the first origin are the paper's table
};

/// results/published/NAME.csv among occlab's data.
std::filesystem::path published_path(const std::string& name);

/// Throws InputError naming the file and line.
PublishedTimes read_published_times(const std::filesystem::path& path);

}  // namespace occlab
