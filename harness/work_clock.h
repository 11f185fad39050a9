#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace occlab {

/// Where the wall time of a run goes. Time belongs to the innermost kind of work that is going on;
/// what belongs to none is the harness's own. One thread only.
class WorkClock {
 public:
  /// `seconds` is the time since some start; by default the machine's steady clock.
  explicit WorkClock(std::function<double()> seconds = {});

  /// Runs `work` and returns what it returns; its time counts for `kind`.
  template <typename Work>
  decltype(auto) in(const char* kind, const Work& work) {
    const Scope scope(*this, kind);
    return work();
  }

  /// Up to now: `total_seconds`, `seconds` by kind, and what is left after rendering, tracing,
  /// measuring and timing as `overhead_seconds` and `overhead_share` of the total.
  nlohmann::json report();

 private:
  class Scope {
   public:
    Scope(WorkClock& clock, const char* kind);
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    WorkClock& clock_;
    std::string outer_;
  };
  /// Books the time since the last change and goes on with another kind.
  std::string change(std::string kind);

  std::function<double()> seconds_;
  double start_;
  double last_;
  std::string kind_;
  std::map<std::string, double> spent_;
};

// The kinds of work that are the purpose of a run; all else is overhead.
inline constexpr const char* rendering_work = "rendering";
inline constexpr const char* tracing_work = "tracing";
inline constexpr const char* measuring_work = "measuring";
inline constexpr const char* timing_work = "timing";
// Overhead that has a name.
inline constexpr const char* storing_work = "storing";
inline constexpr const char* figures_work = "figures and tables";

/// "Of 12.3 s, 2.1% were neither rendering, tracing, measuring nor timing".
std::string overhead_sentence(const nlohmann::json& report);

}  // namespace occlab
