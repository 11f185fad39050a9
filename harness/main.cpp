#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "harness/verbs/verbs.h"
#include "renderers/scene/error.h"
#include "renderers/scene/interrupt.h"

namespace {

int report(const char* what, occlab::ExitCode code) {
  fmt::print(stderr, "occlab: {}\n", what);
  return code;
}

/// One line, as all our errors.
std::string usage_message(const CLI::App*, const CLI::Error& error) {
  return fmt::format("occlab: {}; see --help\n", error.what());
}

/// CLI11 would only say that a verb is required.
void check_verb(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> verbs;
  for (const CLI::App* verb : app.get_subcommands({})) verbs.push_back(verb->get_name());
  if (std::find(verbs.begin(), verbs.end(), argv[1]) != verbs.end()) return;
  throw occlab::InputError(
      fmt::format("unknown verb '{}'{}", argv[1], occlab::accepted_words(argv[1], verbs)));
}

/// What was printed may still be in a buffer: a full disk shows here.
void flush_output() {
  if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return;
  throw occlab::DeviceError(
      fmt::format("standard output cannot be written: {}", std::strerror(errno)));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "A laboratory for screen-space occlusion: SSAO, S3HO, SSDO and SSBN against ray-traced "
      "truth.\nExit codes: 0 good; 1 a check failed; 2 bad usage or bad input; 3 the device or the "
      "machine failed, or the run was interrupted.",
      "occlab");
  app.set_version_flag("--version", "occlab " OCCLAB_VERSION);
  app.require_subcommand(1);
  app.failure_message(usage_message);
  occlab::Action action;
  occlab::add_run_verb(app, action);
  occlab::add_status_verb(app, action);
  occlab::add_time_verb(app, action);
  occlab::add_render_verb(app, action);
  occlab::add_compare_verb(app, action);
  occlab::add_table_verb(app, action);
  occlab::add_claims_verb(app, action);
  occlab::add_query_verb(app, action);
  occlab::add_why_verb(app, action);
  occlab::add_report_verb(app, action);
  occlab::add_history_verb(app, action);
  occlab::add_verify_verb(app, action);
  occlab::add_list_verb(app, action);
  occlab::add_export_verb(app, action);
  try {
    check_verb(app, argc, argv);
    app.parse(argc, argv);
    occlab::catch_interrupts();
    const int code = action();
    flush_output();
    return code;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? occlab::exit_good : occlab::exit_bad_input;
  } catch (const occlab::InputError& error) {
    return report(error.what(), occlab::exit_bad_input);
  } catch (const occlab::Interrupted& error) {
    return report(error.what(), occlab::exit_device_failed);
  } catch (const occlab::DeviceError& error) {
    return report(error.what(), occlab::exit_device_failed);
  } catch (const std::bad_alloc&) {
    return report("out of memory", occlab::exit_device_failed);
  } catch (const std::filesystem::filesystem_error& error) {
    return report(error.what(), occlab::exit_device_failed);
  } catch (const std::exception& error) {  // our bug: a message and an exit code all the same
    return report(fmt::format("internal error: {}", error.what()).c_str(),
                  occlab::exit_device_failed);
  }
}
