#include <fmt/format.h>

#include <filesystem>

#include "harness/verbs/verbs.h"
#include "renderers/scene/error.h"
#include "renderers/scene/interrupt.h"

namespace {

int report(const char* what, occlab::ExitCode code) {
  fmt::print(stderr, "occlab: {}\n", what);
  return code;
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
  occlab::Action action;
  occlab::add_run_verb(app, action);
  occlab::add_render_verb(app, action);
  occlab::add_compare_verb(app, action);
  occlab::add_table_verb(app, action);
  occlab::add_list_verb(app, action);
  occlab::add_export_verb(app, action);
  try {
    app.parse(argc, argv);
    occlab::catch_interrupts();
    return action();
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
  }
}
