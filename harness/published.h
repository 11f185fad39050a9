#pragma once

#include <filesystem>
#include <optional>
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
  /// As printed: how much lower its frame rate is than the first method's, percent.
  std::optional<double> slower_percent;
  std::string origin;  ///< where in the paper: "Table 1", "text of section 4"
  std::string remark;  ///< what contradicts it or is not stated; "" if nothing
};

struct PublishedTimes {
  std::string source;                ///< the paper
  bool frame_rates = false;          ///< it printed frames a second, with one decimal
  std::vector<PublishedTime> times;  ///< those of the first origin are the paper's table
};

/// results/published/NAME.csv among occlab's data.
std::filesystem::path published_path(const std::string& name);

/// A file has a column `time_ms`, or `fps` and `slower_percent` (empty where nothing is printed);
/// the method of its first row is what percentages are to. Throws InputError naming the file and
/// line.
PublishedTimes read_published_times(const std::filesystem::path& path);

}  // namespace occlab
