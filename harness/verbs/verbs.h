#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace occlab {

/// What a verb does once the command line has been read; returns the exit code.
using Action = std::function<int()>;

// Each adds its subcommand to `app`; when that is chosen, `action` is set.
void add_run_verb(CLI::App& app, Action& action);
void add_status_verb(CLI::App& app, Action& action);
void add_time_verb(CLI::App& app, Action& action);
void add_render_verb(CLI::App& app, Action& action);
void add_compare_verb(CLI::App& app, Action& action);
void add_table_verb(CLI::App& app, Action& action);
void add_claims_verb(CLI::App& app, Action& action);
void add_query_verb(CLI::App& app, Action& action);
void add_why_verb(CLI::App& app, Action& action);
void add_report_verb(CLI::App& app, Action& action);
void add_history_verb(CLI::App& app, Action& action);
void add_verify_verb(CLI::App& app, Action& action);
void add_list_verb(CLI::App& app, Action& action);
void add_export_verb(CLI::App& app, Action& action);

}  // namespace occlab
