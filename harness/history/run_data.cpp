#include "harness/history/run_data.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <cstdio>

#include "renderers/scene/error.h"

namespace occlab::history {
namespace {

using nlohmann::json;

/// Calendar fields of "2026-11-22T11:57:39+01:00" and the offset's minutes.
struct IsoFields {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0, offset = 0;
};

bool parse_iso(const std::string& text, IsoFields& at) {
  int length = 0;
  if (std::sscanf(text.c_str(), "%4d-%2d-%2dT%2d:%2d:%2d%n", &at.year, &at.month, &at.day, &at.hour,
                  &at.minute, &at.second, &length) != 6 ||
      length != 19) {
    return false;
  }
  const std::string zone = text.substr(19);
  if (zone == "Z") return true;
  int hours = 0;
  int minutes = 0;
  int zone_length = 0;
  char sign = 0;
  if (std::sscanf(zone.c_str(), "%c%2d:%2d%n", &sign, &hours, &minutes, &zone_length) != 3 ||
      zone_length != 6 || zone.size() != 6 || (sign != '+' && sign != '-')) {
    return false;
  }
  at.offset = (sign == '-' ? -1 : 1) * (60 * hours + minutes);
  return true;
}

std::string iso_text(std::chrono::sys_seconds time) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(time)));
}

}  // namespace

std::string machine_of(const json& run) {
  if (!run.is_object() || !run.contains("timing") || !run["timing"].is_object()) return "";
  const json& timing = run["timing"];
  if (!timing.contains("cpu")) return "";
  return fmt::format("{}, {} threads", timing.value("cpu", ""), timing.value("threads", 0));
}

std::string utc_time(const std::string& iso, const std::string& where) {
  IsoFields at;
  using namespace std::chrono;
  const bool reads = parse_iso(iso, at);
  const year_month_day date{year(at.year), month(unsigned(at.month)), day(unsigned(at.day))};
  if (!reads || !date.ok() || at.hour > 23 || at.minute > 59 || at.second > 60 || at.hour < 0 ||
      at.minute < 0 || at.second < 0) {
    throw InputError(fmt::format(
        "{}: found '{}'; accepted is a time such as 2026-11-22T11:57:39+01:00", where, iso));
  }
  return iso_text(sys_days(date) + hours(at.hour) + minutes(at.minute - at.offset) +
                  seconds(at.second));
}

std::string now_utc() {
  return iso_text(std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now()));
}

}  // namespace occlab::history
