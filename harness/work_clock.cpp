#include "harness/work_clock.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

namespace occlab {
namespace {

constexpr const char* other_work = "other";

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

WorkClock::WorkClock(std::function<double()> seconds)
    : seconds_(seconds ? std::move(seconds) : steady_seconds),
      start_(seconds_()),
      last_(start_),
      kind_(other_work) {}

WorkClock::Scope::Scope(WorkClock& clock, const char* kind)
    : clock_(clock), outer_(clock.change(kind)) {}

WorkClock::Scope::~Scope() { clock_.change(outer_); }

std::string WorkClock::change(std::string kind) {
  const double now = seconds_();
  spent_[kind_] += now - last_;
  last_ = now;
  return std::exchange(kind_, std::move(kind));
}

nlohmann::json WorkClock::report() {
  change(kind_);
  const double total = last_ - start_;
  double overhead = total;
  for (const char* kind : {rendering_work, tracing_work, measuring_work, timing_work}) {
    overhead -= spent_[kind];
  }
  return {{"total_seconds", total},
          {"seconds", spent_},
          {"overhead_seconds", overhead},
          {"overhead_share", total > 0.0 ? overhead / total : 0.0}};
}

std::string overhead_sentence(const nlohmann::json& report) {
  const auto seconds = report.at("seconds").get<std::map<std::string, double>>();
  std::string parts;
  for (const auto& [kind, spent] : seconds) {
    if (spent >= 0.05)
      parts += fmt::format("{}{} {:.1f} s", parts.empty() ? "" : ", ", kind, spent);
  }
  return fmt::format(
      "of {:.1f} s, {:.1f}% were neither rendering, tracing, measuring nor timing{}{}",
      report.at("total_seconds").get<double>(), 100.0 * report.at("overhead_share").get<double>(),
      parts.empty() ? "" : ": ", parts);
}

}  // namespace occlab
