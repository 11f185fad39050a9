#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "harness/metrics/metrics.h"
#include "harness/verbs/verbs.h"
#include "renderers/gl/context.h"
#include "renderers/methods/method.h"
#include "renderers/scene/data_root.h"
#include "renderers/scene/environment.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

using nlohmann::json;

/// What can be listed: rows of (key, value); the first value is the name.
json list_methods() {
  json all = json::array();
  for (const MethodInfo& method : methods()) {
    json parameters = json::array();
    for (const Parameter& parameter : method.parameters) {
      parameters.push_back({{"name", parameter.name},
                            {"default", to_string(parameter.default_value)},
                            {"accepted", accepted_values(parameter)},
                            {"unit", parameter.unit},
                            {"help", parameter.help}});
    }
    all.push_back({{"name", method.name},
                   {"title", method.title},
                   {"paper", method.paper},
                   {"truth", method.truth},
                   {"layers", method.layers},
                   {"parameters", parameters}});
  }
  return all;
}

json list_scenes() {
  json all = json::array();
  for (const std::string& name : scene_names()) {
    all.push_back({{"name", name}, {"path", scene_path(name).string()}});
  }
  return all;
}

json list_probes() {
  json all = json::array();
  for (const ProbeName& probe : probe_names()) {
    all.push_back({{"name", probe.name}, {"path", probe.path.string()}});
  }
  return all;
}

json list_devices_json() {
  json all = json::array();
  for (const DeviceInfo& device : list_devices()) {
    all.push_back({{"name", device.id},
                   {"renderer", device.renderer},
                   {"driver", device.version},
                   {"rasteriser", device.software ? "software" : "hardware"}});
  }
  if (all.empty()) {
    throw DeviceError(
        "no device: EGL gives no OpenGL 4.5 context; is Mesa's libegl-mesa0 installed?");
  }
  return all;
}

json list_metrics() {
  json all = json::array();
  for (const MetricInfo& metric : metrics()) {
    all.push_back({{"name", metric.name},
                   {"unit", metric.unit},
                   {"better", metric.lower_is_better ? "lower" : "higher"},
                   {"definition", metric.definition}});
  }
  return all;
}

struct Listing {
  const char* name;
  json (*make)();
};
constexpr std::array<Listing, 5> listings = {{{"methods", list_methods},
                                              {"scenes", list_scenes},
                                              {"probes", list_probes},
                                              {"devices", list_devices_json},
                                              {"metrics", list_metrics}}};

std::string plain(const json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

/// A block an entry: its name, then its other values; nested entries (parameters) indented.
void print_entries(const json& entries, const std::string& indent) {
  for (const json& entry : entries) {
    fmt::print("{}{}\n", indent, entry["name"].get<std::string>());
    for (const auto& [key, value] : entry.items()) {
      if (key == "name" || value == json("")) continue;
      if (value.is_array() && !value.empty() && value.front().is_object()) {
        fmt::print("{}  {}:\n", indent, key);
        print_entries(value, indent + "    ");
      } else {
        fmt::print("{}  {}: {}\n", indent, key, plain(value));
      }
    }
  }
}

struct ListOptions {
  std::string what;
  bool json = false;
};

}  // namespace

void add_list_verb(CLI::App& app, Action& action) {
  auto options = std::make_shared<ListOptions>();
  std::vector<std::string> names;
  for (const Listing& listing : listings) names.emplace_back(listing.name);
  CLI::App* verb = app.add_subcommand("list", "what there is to choose from");
  verb->add_option("what", options->what, fmt::format("{}", fmt::join(names, ", ")))
      ->required()
      ->check(CLI::IsMember(names));
  verb->add_flag("--json", options->json, "print JSON");
  verb->callback([options, &action] {
    action = [options] {
      const auto* listing = std::ranges::find_if(
          listings, [&](const Listing& candidate) { return candidate.name == options->what; });
      const json entries = listing->make();
      if (options->json) {
        fmt::print("{}\n", entries.dump(2));
      } else {
        print_entries(entries, "");
      }
      return exit_good;
    };
  });
}

}  // namespace occlab
