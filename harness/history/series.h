#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "harness/measurements.h"

namespace occlab::history {

/// What is the same in all runs of a number: the identity of a line in the dashboard. Times name
/// the machine along with the device, as a software rasteriser's depend on it.
struct Series {
  std::string experiment;
  std::string scene;
  std::string view;
  std::string resolution;
  std::string probe;
  std::string method;
  std::vector<std::pair<std::string, std::string>> parameters;  ///< without `seed`
  std::string stage;
  std::string metric;
  std::string unit;
  std::string device;

  bool operator==(const Series&) const = default;
};

/// `machine`: the processor and its threads, "" if unknown; used for times alone.
Series series_of(const Measurement& row, const std::string& machine);

/// 16 hex digits of the SHA-256 of all of it; the order of the parameters does not matter.
std::string series_key(const Series& series);
/// The same without the device: what may be compared across devices.
std::string series_key_on_any_device(const Series& series);

/// "s3ho rmse filtered (samples 32)" with those parameters that `shown` names.
std::string series_label(const Series& series, const std::vector<std::string>& shown);
/// The parameters in which series of one method differ, in order of appearance, and the names of
/// those of scene, view, resolution and probe in which any differ.
std::vector<std::string> differing_parameters(const std::vector<const Series*>& all);

/// What one run measured of a series.
struct SeriesValues {
  Series series;
  std::optional<double> value;  ///< over all seeds
  std::optional<double> lower;
  std::optional<double> upper;
  long n = 0;
  std::string reason;                             ///< why there is no value
  std::map<long, std::optional<double>> by_seed;  ///< none: that seed could not be measured
};

enum class Direction { lower, higher, none };
/// Which is better. Errors, noise and times: lower.
Direction direction_of(const std::string& metric);
std::string to_string(Direction direction);

/// Which minimum effect a metric is held to.
enum class MetricClass { error, similarity, decibel, time };
MetricClass class_of(const std::string& metric);

/// A change that matters, at least: of errors and times relative to the baseline, of similarities
/// (SSIM) and decibels (PSNR) absolute.
struct MinimumEffects {
  double error = 0.02;
  double similarity = 0.002;
  double decibel = 0.1;
  double time = 0.05;

  double of(MetricClass metric_class) const;
  /// Sets the one of that name. Throws InputError for an unknown name and a value that is not
  /// positive and finite; `where` begins the message.
  void set(const std::string& name, double value, const std::string& where);
};

/// Whether a change is given relative to the baseline.
bool is_relative(MetricClass metric_class);

/// Rows that are parts of a curve or repeat others (ratios of two methods) have no history.
bool has_history(const Measurement& row);

/// The least RMS error that a scene allows to tell: the half-width of the reference's own 95%
/// interval (metric reference_interval), by the view it is of. For errors in its unit.
class NoiseFloors {
 public:
  void add(const Series& series, std::optional<double> value);
  std::optional<double> of(const Series& series) const;

 private:
  std::map<std::string, double> floors_;
};

}  // namespace occlab::history
