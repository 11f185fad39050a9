#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "harness/claims/claim_tables.h"
#include "harness/claims/record.h"
#include "harness/results_folder.h"
#include "harness/table_formats.h"
#include "harness/table_layout.h"
#include "harness/verbs/verbs.h"
#include "harness/version.h"
#include "renderers/scene/data_root.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

struct ClaimsOptions {
  std::vector<std::string> results;
  std::string claims;
  std::string record;
  std::string format = "md";
  bool json = false;
  bool accept = false;
};

/// Every folder below results/ that has measurements, sorted.
std::vector<std::string> all_results() {
  std::vector<std::string> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator("results", error)) {
    if (fs::exists(entry.path() / "measurements.csv")) found.push_back(entry.path().string());
  }
  std::ranges::sort(found);
  return found;
}

std::vector<MeasuredFolder> read_folders(const std::vector<std::string>& names) {
  std::vector<MeasuredFolder> folders;
  for (const std::string& name : names) {
    const bool known = std::ranges::any_of(
        folders, [&](const MeasuredFolder& folder) { return fs::equivalent(folder.name, name); });
    if (known) throw InputError(fmt::format("{}: the folder is there twice", name));
    folders.push_back({name, read_measurements(ResultsFolder(name).measurements())});
  }
  return folders;
}

/// To standard error, as what is printed may be for a program.
void report(const RecordComparison& comparison, const fs::path& record) {
  const auto say = [](const std::string& text) { fmt::print(stderr, "occlab: {}\n", text); };
  for (const std::string& remark : comparison.remarks) say(remark);
  if (comparison.untested > 0) {
    say(fmt::format("{} claims that {} has as reproduced cannot be tested with these results",
                    comparison.untested, record.string()));
  }
  for (const std::string& lost : comparison.lost) say("LOST: " + lost);
}

int claims(const ClaimsOptions& options) {
  const fs::path claims_path = options.claims.empty() ? data_root() / "configs/papers/claims.toml"
                                                      : fs::path(options.claims);
  const fs::path record_path = options.record.empty()
                                   ? data_root() / "results/published/claims.json"
                                   : fs::path(options.record);
  const ClaimFile file = load_claims(claims_path, methods());
  const ClaimRecord record = read_record(record_path);
  const std::vector<MeasuredFolder> folders =
      read_folders(options.results.empty() ? all_results() : options.results);
  ClaimEstimator estimator(folders);
  const JudgedClaims judged = judge_claims(file, estimator);
  if (options.json) {
    fmt::print("{}\n", claims_json(file, judged).dump(2));
  } else {
    print_tables(claim_tables(file, judged), options.format);
  }
  const RecordComparison comparison = compare(record, judged);
  report(comparison, record_path);
  if (options.accept) {
    write_record(record_path, accept(record, judged, std::string(build_commit)));
    fmt::print(stderr, "occlab: these verdicts are now expected: {}\n", record_path.string());
    return exit_good;
  }
  return comparison.lost.empty() ? exit_good : exit_check_failed;
}

}  // namespace

void add_claims_verb(CLI::App& app, Action& action) {
  auto options = std::make_shared<ClaimsOptions>();
  CLI::App* verb = app.add_subcommand(
      "claims",
      "print each claim of the papers with its verdict, from stored measurements; exit "
      "code 1 if one that was reproduced is not any more");
  verb->add_option("results", options->results,
                   "folders of 'occlab run' or 'occlab time'; default: all in results/");
  verb->add_option("--claims", options->claims,
                   "the claims (configs/FORMAT.md); default: configs/papers/claims.toml");
  verb->add_option("--record", options->record,
                   "the verdicts that are expected; default: results/published/claims.json");
  verb->add_flag("--accept", options->accept, "make these verdicts the expected ones");
  verb->add_option("--format", options->format, "the format to print")
      ->check(CLI::IsMember(table_formats()))
      ->capture_default_str();
  verb->add_flag("--json", options->json, "print all of it as one JSON object");
  verb->callback([options, &action] { action = [options] { return claims(*options); }; });
}

}  // namespace occlab
