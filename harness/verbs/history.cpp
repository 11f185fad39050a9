#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "harness/files.h"
#include "harness/history/baseline.h"
#include "harness/history/dashboard.h"
#include "harness/history/gate_formats.h"
#include "harness/history/gate_settings.h"
#include "harness/history/git.h"
#include "harness/history/schema.h"
#include "harness/history/store.h"
#include "harness/table_layout.h"
#include "harness/verbs/verbs.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

using namespace history;

struct HistoryOptions {
  std::string db = "history.sqlite";
  std::vector<std::string> results;
  std::string commit;
  std::string subject;
  std::string commit_time;
  bool no_images = false;
  // check
  std::vector<std::string> against;
  std::string settings_file;
  std::vector<std::string> minimum_effects;
  GateSettings gate;
  std::optional<double> level;  ///< before that of the file
  bool all = false;
  std::string junit;
  std::string markdown;
  std::string json;
  bool accept = false;
  std::string as = "main";
  std::string why;
  // accept, list, report
  std::string series;
  bool print_json = false;
  DashboardOptions dashboard;
};

void override_commit(RunFacts& facts, const HistoryOptions& options) {
  if (!options.commit.empty()) {
    const auto known = find_commit(options.commit);
    facts.commit = options.commit;
    if (known && !known->hash.starts_with(options.commit)) facts.commit = known->hash;  // a branch
    facts.subject.clear();
  }
  if (!options.subject.empty()) facts.subject = options.subject;
  if (!options.commit_time.empty()) {
    facts.commit_time = utc_time(options.commit_time, "--commit-time");
  }
  complete_commit(facts);
}

/// Adds one results folder; prints what it did.
Added add_results(const Sqlite& database, const RunData& data, const std::string& folder,
                  bool images) {
  std::vector<std::string> problems;
  std::vector<Preview> previews;
  if (images && data.facts.run.is_object()) {
    previews = make_previews(folder, data.facts.run, problems);
  }
  for (const std::string& problem : data.left_out) fmt::print(stderr, "occlab: {}\n", problem);
  for (const std::string& problem : problems) fmt::print(stderr, "occlab: {}\n", problem);
  const Added added = add_run(database, data, previews);
  if (added.is_new) {
    fmt::print("{}: run {} of commit {}: {} series, {} pictures\n", database.path().string(),
               added.run, data.facts.commit, data.series.size(), previews.size());
  } else {
    fmt::print("{}: was there already as run {} of commit {}; nothing changed\n",
               database.path().string(), added.run, data.facts.commit);
  }
  return added;
}

int add(const HistoryOptions& options) {
  std::vector<RunData> runs;
  for (const std::string& folder : options.results) {
    runs.push_back(read_results(folder));
    if (!runs.back().facts.run.is_object()) {
      throw InputError(fmt::format(
          "{}: a results folder is expected; a bare file does not say what it is of", folder));
    }
    override_commit(runs.back().facts, options);
  }
  const Sqlite database = open_history(options.db, true);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    add_results(database, runs[i], options.results[i], !options.no_images);
  }
  return exit_good;
}

nlohmann::json list_json(const Sqlite& database) {
  nlohmann::json runs = nlohmann::json::array();
  for (const StoredRun& run : list_runs(database)) {
    runs.push_back({{"id", run.id},
                    {"commit", run.commit},
                    {"subject", run.subject},
                    {"commit_time", run.commit_time},
                    {"added", run.added},
                    {"experiment", run.experiment},
                    {"device", run.device}});
  }
  nlohmann::json baselines = nlohmann::json::array();
  for (const Baseline& baseline : list_baselines(database)) {
    baselines.push_back({{"name", baseline.name},
                         {"experiment", baseline.experiment},
                         {"run", baseline.run},
                         {"who", baseline.who},
                         {"accepted", baseline.accepted},
                         {"why", baseline.why},
                         {"findings", baseline.findings}});
  }
  nlohmann::json intended = nlohmann::json::array();
  for (const Intended& mark : list_intended(database)) {
    intended.push_back({{"series", mark.series},
                        {"commit", mark.commit},
                        {"who", mark.who},
                        {"accepted", mark.accepted},
                        {"why", mark.why}});
  }
  return {{"runs", runs}, {"baselines", baselines}, {"intended", intended}};
}

int list(const HistoryOptions& options) {
  const Sqlite database = open_history(options.db, false);
  if (options.print_json) {
    fmt::print("{}\n", list_json(database).dump(2));
    return exit_good;
  }
  for (const StoredRun& run : list_runs(database)) {
    fmt::print("{:>5}  {:<20}  {:.16}  {}  {}\n", run.id,
               run.commit_time.empty() ? run.added : run.commit_time, run.commit, run.experiment,
               run.subject);
  }
  for (const Baseline& baseline : list_baselines(database)) {
    fmt::print("baseline {} of {}: run {}, accepted {} by {}: {}\n", baseline.name,
               baseline.experiment, baseline.run, baseline.accepted, baseline.who, baseline.why);
    for (const auto& finding : baseline.findings) {
      fmt::print("  accepted although {}: {} {}\n", finding.value("verdict", ""),
                 finding.value("what", ""), finding.value("effect", ""));
    }
  }
  for (const Intended& mark : list_intended(database)) {
    fmt::print("intended: series {} since {}, {} by {}: {}\n", mark.series, mark.commit,
               mark.accepted, mark.who, mark.why);
  }
  return exit_good;
}

void write_outputs(const GateReport& report, const HistoryOptions& options,
                   const GateSettings& settings) {
  if (!options.junit.empty()) write_text_atomically(options.junit, gate_junit(report, settings));
  if (!options.markdown.empty()) {
    write_text_atomically(options.markdown, gate_markdown(report, settings));
  }
  if (!options.json.empty()) {
    write_text_atomically(options.json, gate_json(report, settings).dump(2) + "\n");
  }
}

int accept_baseline(const GateSide& results, const HistoryOptions& options,
                    const nlohmann::json& findings) {
  const Sqlite database = open_history(options.db, true);
  std::optional<std::int64_t> first;
  for (std::size_t i = 0; i < results.runs.size(); ++i) {
    const Added added =
        add_results(database, results.runs[i], options.results[i], !options.no_images);
    if (!first) first = added.run;
  }
  add_baseline(database, {.name = options.as,
                          .experiment = results.runs.front().facts.experiment,
                          .run = *first,
                          .who = current_user(),
                          .accepted = now_utc(),
                          .why = options.why,
                          .findings = findings});
  fmt::print("{}: run {} is now the baseline '{}': {}\n", options.db, *first, options.as,
             options.why);
  return exit_good;
}

/// The results' runs, with their commits where they are to be stored.
GateSide read_side(const HistoryOptions& options) {
  GateSide side;
  for (RunData& data : read_each_once(options.results)) {
    const std::string folder = data.name;
    side.runs.push_back(std::move(data));
    RunData& run = side.runs.back();
    if (options.accept && !run.facts.run.is_object()) {
      throw InputError(fmt::format("{}: --accept needs a results folder", folder));
    }
    if (options.accept) override_commit(run.facts, options);
    if (run.facts.experiment != side.runs.front().facts.experiment) {
      throw InputError(
          fmt::format("{}: is of the experiment '{}', {} of '{}'; accepted are "
                      "repeated runs of one",
                      folder, run.facts.experiment, options.results.front(),
                      side.runs.front().facts.experiment));
    }
  }
  return side;
}

void refuse_outputs(const HistoryOptions& options) {
  for (const auto& [name, file] :
       {std::pair("--junit", options.junit), std::pair("--markdown", options.markdown),
        std::pair("--json", options.json)}) {
    if (file.empty()) continue;
    throw InputError(
        fmt::format("{} {}: the first baseline '{}' is compared with nothing; accept it without",
                    name, file, options.as));
  }
}

int check(const HistoryOptions& options) {
  GateSettings settings = options.gate;
  if (!options.settings_file.empty()) read_gate_settings(options.settings_file, settings);
  if (options.level) settings.level = *options.level;
  apply_minimum_effects(options.minimum_effects, settings.minimum);
  if (options.accept && options.why.empty()) {
    throw InputError("--accept: --why is missing: say why this is right");
  }
  const GateSide results = read_side(options);
  const std::string experiment = results.runs.front().facts.experiment;
  std::error_code error;
  std::optional<Sqlite> database;
  if (std::filesystem::exists(options.db, error)) database.emplace(open_history(options.db, false));
  const Sqlite* const opened = database ? &*database : nullptr;
  const bool first = options.accept && options.against == std::vector{options.as} &&
                     (!opened || !current_baseline(*opened, options.as, experiment));
  if (first) {
    refuse_outputs(options);
    return accept_baseline(results, options, nlohmann::json::array());
  }
  const ChosenBaseline baseline = choose_baseline(opened, options.against, experiment);
  const GateReport report = run_gate(baseline.side, results, baseline.others, settings);
  write_outputs(report, options, settings);
  const Table table = gate_table(report, options.all);
  if (!table.rows.empty()) {
    print_table(table, "md");
    fmt::print("\n");
  } else {
    for (const std::string& note : report.notes) fmt::print("{}\n", note);
  }
  fmt::print("{}: {}\n", report.experiment, summary(report, settings));
  if (report.compared() == 0 && !options.accept) {
    throw InputError(fmt::format("{} against {}: {}", report.results, report.baseline,
                                 summary(report, settings)));
  }
  if (options.accept) return accept_baseline(results, options, accepted_findings(report));
  return exit_code(report, settings);
}

int accept(const HistoryOptions& options) {
  const Sqlite database = open_history(options.db, false);
  const std::vector<StoredRun> runs = runs_named(database, options.commit);
  if (runs.empty()) {
    throw InputError(
        fmt::format("{}: no run is of commit '{}'; 'occlab history list' prints those there are",
                    database.path().string(), options.commit));
  }
  add_intended(database, {.series = options.series,
                          .commit = runs.front().commit,
                          .who = current_user(),
                          .accepted = now_utc(),
                          .why = options.why});
  fmt::print("{}: the change of series {} in {} is marked as intended\n", options.db,
             options.series, runs.front().commit);
  return exit_good;
}

int report_history(const HistoryOptions& options) {
  const Sqlite database = open_history(options.db, false);
  DashboardOptions dashboard = options.dashboard;
  apply_minimum_effects(options.minimum_effects, dashboard.minimum);
  const WrittenDashboard written = write_dashboard(database, dashboard);
  fmt::print("{}: {} runs, {} series, {} steps ({} WORSE and not intended), {:.1f} MB\n",
             written.index.string(), written.runs, written.series, written.steps, written.worse,
             double(written.bytes) * 1e-6);
  return exit_good;
}

using Options = std::shared_ptr<HistoryOptions>;

void add_db(CLI::App* verb, const Options& options) {
  verb->add_option("--db", options->db, "the history's file")->capture_default_str();
}

void add_results_options(CLI::App* verb, const Options& options) {
  verb->add_option("results", options->results,
                   "folders of an 'occlab run' or 'occlab time'; several: repeated runs")
      ->required();
  verb->add_option("--commit", options->commit,
                   "what the runs are of; default: the program's that made them, else HEAD");
  verb->add_option("--subject", options->subject, "the commit's subject; default: git's");
  verb->add_option("--commit-time", options->commit_time, "ISO 8601; default: git's");
  verb->add_flag("--no-images", options->no_images, "store no small pictures");
}

void add_minimum_effects(CLI::App* verb, const Options& options) {
  verb->add_option("--minimum-effect", options->minimum_effects,
                   "CLASS=VALUE, the least change that matters: error (0.02 of the baseline), time "
                   "(0.05 of it), similarity (0.002), decibel (0.1)");
}

void add_check(CLI::App* parent, const Options& options, Action& action) {
  CLI::App* verb = parent->add_subcommand(
      "check", "compare runs with a baseline, metric by metric; exit code 1 on a regression");
  add_results_options(verb, options);
  verb->add_option("--against", options->against,
                   "an accepted baseline (main), a commit of the history, or other results; given "
                   "again: repeated runs of these")
      ->required()
      ->allow_extra_args(false);
  add_db(verb, options);
  verb->add_option("--settings", options->settings_file,
                   "TOML: level = 0.05 and [minimum_effect] with the classes below");
  add_minimum_effects(verb, options);
  verb->add_option("--level", options->level,
                   "the probability of any false alarm, at most; default: the file's, else 0.05")
      ->check(CLI::Range(1e-6, 0.5));
  verb->add_flag("--absolute-times", options->gate.absolute_times,
                 "judge milliseconds as well as ratios: only where the machine does not drift");
  verb->add_flag("--allow-missing", options->gate.allow_missing,
                 "what only the baseline measured does not fail");
  verb->add_flag("--allow-changed-inputs", options->gate.allow_changed_inputs,
                 "another scene or probe file of the same name does not fail");
  verb->add_flag("--strict", options->gate.strict, "UNSURE fails, too");
  verb->add_flag("--all", options->all, "print what is the SAME, too");
  verb->add_option("--junit", options->junit, "write JUnit XML");
  verb->add_option("--markdown", options->markdown, "write Markdown for a pull request");
  verb->add_option("--json", options->json, "write JSON");
  verb->add_flag("--accept", options->accept, "make these results the baseline, whatever came out");
  verb->add_option("--as", options->as, "the accepted baseline's name")->capture_default_str();
  verb->add_option("--why", options->why, "why it is accepted; required with --accept");
  verb->callback([options, &action] { action = [options] { return check(*options); }; });
}

}  // namespace

void add_history_verb(CLI::App& app, Action& action) {
  auto options = std::make_shared<HistoryOptions>();
  CLI::App* verb =
      app.add_subcommand("history", "store runs, compare them, find what changed and when");
  verb->require_subcommand(1);

  CLI::App* adding = verb->add_subcommand("add", "store the measurements of finished runs");
  add_results_options(adding, options);
  add_db(adding, options);
  adding->callback([options, &action] { action = [options] { return add(*options); }; });

  CLI::App* listing =
      verb->add_subcommand("list", "the runs, the accepted baselines and the intended changes");
  add_db(listing, options);
  listing->add_flag("--json", options->print_json, "print JSON");
  listing->callback([options, &action] { action = [options] { return list(*options); }; });

  add_check(verb, options, action);

  CLI::App* accepting = verb->add_subcommand("accept", "mark a step of a series as intended");
  add_db(accepting, options);
  accepting->add_option("--series", options->series, "its key, as the page shows it")->required();
  accepting->add_option("--commit", options->commit, "the commit that caused it")->required();
  accepting->add_option("--why", options->why, "why it is right")->required();
  accepting->callback([options, &action] { action = [options] { return accept(*options); }; });

  CLI::App* reporting =
      verb->add_subcommand("report", "write the page: every series over commits, with its steps");
  add_db(reporting, options);
  reporting->add_option("-o,--out", options->dashboard.folder, "the page's folder")->required();
  reporting->add_option("--project", options->dashboard.project, "the page's title")
      ->capture_default_str();
  add_minimum_effects(reporting, options);
  reporting->callback(
      [options, &action] { action = [options] { return report_history(*options); }; });
}

}  // namespace occlab
