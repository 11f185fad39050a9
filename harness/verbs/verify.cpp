#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "harness/table_formats.h"
#include "harness/table_layout.h"
#include "harness/verbs/verbs.h"
#include "harness/verify/analytic_checks.h"
#include "harness/verify/cycles_checks.h"
#include "harness/verify/metrics_checks.h"
#include "harness/verify/representation_checks.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

struct VerifyOptions {
  std::vector<std::string> only;
  bool cycles = false;
  std::filesystem::path cases;
  std::filesystem::path output = "results/verify";
  std::string device = "auto";
  std::string format = "md";
  CyclesSettings against_cycles;
  std::vector<int> resolution;
  ProbeSettings probe;
};

AnalyticSettings analytic_settings(const VerifyOptions& options) {
  return {.cases = options.cases, .output = options.output, .device = options.device};
}

CyclesSettings cycles_settings(const VerifyOptions& options) {
  CyclesSettings settings = options.against_cycles;
  if (!options.resolution.empty()) {
    settings.view.width = options.resolution[0];
    settings.view.height = options.resolution[1];
  }
  if (!options.probe.source.empty()) settings.view.probe = options.probe;
  settings.device = options.device;
  settings.output = options.output / "cycles";
  return settings;
}

/// What can be verified, in the order of the table.
struct Subject {
  const char* name;
  bool has_cases;       ///< measures what --cases names
  bool is_default;      ///< part of a plain `occlab verify`
  double family_level;  ///< probability of a false alarm of its statistical tests; 0: it has none
  Checks (*verify)(const VerifyOptions&);
};
constexpr const char* cycles_subject = "cycles";
constexpr Subject subjects[] = {
    {"reference", true, true, analytic_family_level,
     [](const VerifyOptions& options) { return verify_reference(analytic_settings(options)); }},
    {"passes", true, true, analytic_family_level,
     [](const VerifyOptions& options) { return verify_passes(analytic_settings(options)); }},
    {"representations", false, true, representation_family_level,
     [](const VerifyOptions& options) {
       return verify_representations({.device = options.device, .output = options.output});
     }},
    {"metrics", false, true, 0.0, [](const VerifyOptions&) { return verify_metrics(); }},
    {cycles_subject, false, false, cycles_family_level,
     [](const VerifyOptions& options) { return verify_cycles(cycles_settings(options)); }},
};

/// Those named by --only; else with --cases those that have cases; else the default ones.
bool is_chosen(const Subject& subject, const VerifyOptions& options) {
  if (options.cycles && subject.name == std::string(cycles_subject)) return true;
  if (!options.only.empty()) return std::ranges::count(options.only, subject.name) > 0;
  return options.cases.empty() ? subject.is_default : subject.has_cases;
}

Table table_of(const Checks& checks) {
  Table table{.name = "verify",
              .title = "Verification",
              .columns = {{.name = "subject", .unit = ""},
                          {.name = "case", .unit = ""},
                          {.name = "quantity", .unit = ""},
                          {.name = "measured", .unit = "", .alignment = Alignment::right},
                          {.name = "expected", .unit = "", .alignment = Alignment::right},
                          {.name = "error", .unit = "", .alignment = Alignment::right},
                          {.name = "bound", .unit = "", .alignment = Alignment::right},
                          {.name = "rule", .unit = ""},
                          {.name = "verdict", .unit = ""}},
              .rows = {},
              .notes = {}};
  const auto number = [](double value) -> TableCell {
    if (std::isnan(value)) return TableMissing{"not a number"};
    return TableNumber{.value = value, .lower = {}, .upper = {}};
  };
  for (const Check& check : checks) {
    table.rows.push_back({check.subject, check.name, check.quantity, number(check.measured),
                          number(check.expected), number(check.measured - check.expected),
                          number(check.bound), check.rule, check.passes ? "passes" : "FAILS"});
    if (!check.passes) {
      table.notes.push_back(
          fmt::format("{}, {} FAILS: {}", check.name, check.quantity, check.detail));
    }
  }
  return table;
}

int verify(const VerifyOptions& options) {
  Checks checks;
  double no_false_alarm = 1.0;
  for (const Subject& subject : subjects) {
    if (!is_chosen(subject, options)) continue;
    std::ranges::move(subject.verify(options), std::back_inserter(checks));
    no_false_alarm *= 1.0 - subject.family_level;
  }
  if (checks.empty()) {
    throw InputError(
        fmt::format("--cases {}: no case of what is to be verified", options.cases.string()));
  }
  print_table(table_of(checks), options.format);
  // A machine-readable table is all there is on standard output.
  const bool is_page = options.format == "md";
  const auto failed = std::ranges::count(checks, false, &Check::passes);
  fmt::print(is_page ? stdout : stderr, "{}{} checks, {} failed, family false-alarm rate {:.2g}\n",
             is_page ? "\n" : "", checks.size(), failed, 1.0 - no_false_alarm);
  return failed == 0 ? exit_good : exit_check_failed;
}

void add_cycles_options(CLI::App& verb, VerifyOptions& options) {
  CyclesSettings& cycles = options.against_cycles;
  const auto group = verb.add_option_group("Cycles", "what --cycles renders");
  group->add_option("--scene", cycles.view.scene, "a scene's name, or a .glb or .gltf")
      ->capture_default_str();
  group->add_option("--view", cycles.view.view, "a camera's name; default: the first");
  group->add_option("--resolution", options.resolution, "width and height in pixels")
      ->expected(2)
      ->check(CLI::Range(1, 16384));
  group->add_option("--probe", options.probe.source, "a probe's name, or an equirect .exr or .hdr");
  group->add_option("--rotation", options.probe.rotation_degrees,
                    "turns the probe counter-clockwise from above, degrees");
  group->add_option("--prefilter", options.probe.prefilter_degrees,
                    "sigma of a Gaussian over the probe, degrees");
  group->add_option("--samples", cycles.samples, "Cycles' paths a pixel, all seeds together")
      ->capture_default_str();
  group->add_option("--rays-per-pixel", cycles.rays_per_pixel, "RTDO's rays, all seeds together")
      ->capture_default_str();
  group->add_option("--seeds", cycles.seeds, "independent renderings a renderer")
      ->capture_default_str();
  group
      ->add_option("--ao-distance", cycles.ao_distance_world,
                   "farthest blocker of the ambient occlusion, scene units")
      ->capture_default_str();
  group->add_option("--blender", cycles.blender, "a program on the PATH, or a path")
      ->capture_default_str();
}

}  // namespace

void add_verify_verb(CLI::App& app, Action& action) {
  auto options = std::make_shared<VerifyOptions>();
  std::vector<std::string> names;
  for (const Subject& subject : subjects) names.emplace_back(subject.name);
  CLI::App* verb = app.add_subcommand(
      "verify", "measure what has a known answer: reference, passes, representations, metrics");
  verb->add_option("--only", options->only, "a subject; may be repeated; default: all but cycles")
      ->check(CLI::IsMember(names));
  verb->add_flag("--cycles", options->cycles, "also compare the reference with Blender's Cycles");
  verb->add_option("--cases", options->cases,
                   "a scene file that carries its expected values, or a folder of them "
                   "(scenes/FORMAT.md), instead of scenes/analytic; then only these");
  verb->add_option("--out", options->output,
                   "folder for the images of checks that fail; made when needed")
      ->capture_default_str();
  verb->add_option("--device", options->device, "see 'occlab list devices'")->capture_default_str();
  verb->add_option("--format", options->format, "the table's format")
      ->check(CLI::IsMember(table_formats()))
      ->capture_default_str();
  add_cycles_options(*verb, *options);
  verb->callback([options, &action] { action = [options] { return verify(*options); }; });
}

}  // namespace occlab
