// read_figure of config_parts.h.

#include <fmt/format.h>

#include <algorithm>

#include "harness/config_parts.h"
#include "harness/error_budget.h"
#include "renderers/methods/representation.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

bool shows_errors(FigureKind kind) {
  return kind == FigureKind::error_map || kind == FigureKind::error_budget ||
         kind == FigureKind::failure_classes;
}

bool is_of_budget(FigureKind kind) {
  return kind == FigureKind::error_budget || kind == FigureKind::failure_classes;
}

/// The parameters that select one cell of each of the figure's methods; they do.
NamedValues read_selection(TomlTable& table, const FigureSettings& figure,
                           const FigureContext& context) {
  const auto known = known_methods(table, "methods", figure.methods, context.methods);
  NamedValues select = single_values(read_parameters(table, known, {}));
  for (const std::string& method : figure.methods) {
    try {
      const int group = select_group(context.cells, method, select);
      const auto cell = std::ranges::find(context.cells, group, &PlannedCell::group);
      if (shows_errors(figure.kind) && cell->role == Role::reference) {
        table.fail("methods", fmt::format("'{}' is the reference itself", method));
      }
      if (is_of_budget(figure.kind) && !has_budget(*cell)) {
        table.fail("methods", fmt::format("'{}' has no budget: it does not march through the depth "
                                          "buffer, or has no form on the CPU",
                                          method));
      }
    } catch (const SelectionError& error) {
      table.fail(select.empty() ? "methods" : select.front().first, error.what());
    }
  }
  return select;
}

/// Refuses methods that the kind cannot show, by what they have rather than by their names.
void check_method_of_kind(const TomlTable& table, const FigureSettings& figure,
                          const FigureContext& context) {
  const auto known = known_methods(table, "methods", figure.methods, context.methods);
  if (known.size() != 1) table.fail("methods", "accepted is one method");
  const MethodInfo& method = *known.front();
  if (figure.kind == FigureKind::ambient_occlusion &&
      (!method.representation || method.representation->channels != 1)) {
    table.fail("methods",
               fmt::format("'{}' is not light times a scalar; accepted is a method whose "
                           "representation is ambient occlusion",
                           method.name));
  }
  if (figure.kind == FigureKind::lobes &&
      std::ranges::find(method.layers, "sh_visibility") == method.layers.end()) {
    table.fail("methods", fmt::format("'{}' has no layer 'sh_visibility'", method.name));
  }
}

void read_lobes(TomlTable& table, const FigureContext& context, FigureSettings& figure) {
  if (figure.stage != "filtered") {
    table.fail("stage", "the coefficients are stored after the filter; accepted is 'filtered'");
  }
  for (TomlTable& point : table.tables("points")) {
    figure.points.push_back(read_point(point, context.benches[figure.bench].scene));
    point.refuse_others();
  }
  if (figure.points.size() > 2) table.fail("points", "accepted are one or two points");
  if (!table.has("switch")) return;
  figure.switched = table.words("switch");
  if (figure.switched.size() != 2) table.fail("switch", "accepted are two lights' names");
}

}  // namespace

FigureSettings read_figure(TomlTable& table, const FigureContext& context) {
  FigureSettings figure;
  figure.name = table.identifier("name");
  const std::vector<std::pair<std::string, FigureKind>> kinds = {
      {"comparison", FigureKind::comparison},
      {"closeups", FigureKind::closeups},
      {"error_map", FigureKind::error_map},
      {"error_budget", FigureKind::error_budget},
      {"failure_classes", FigureKind::failure_classes},
      {"ambient_occlusion", FigureKind::ambient_occlusion},
      {"lobes", FigureKind::lobes},
      {"grid", FigureKind::grid}};
  std::vector<std::string> words;
  for (const auto& [word, unused] : kinds) words.push_back(word);
  const std::string kind = table.one_of("kind", words, "");
  figure.kind = std::ranges::find(kinds, kind, &std::pair<std::string, FigureKind>::first)->second;
  figure.title = table.text("title", "");
  figure.caption = table.text("caption", "");
  figure.stage = table.one_of("stage", {"filtered", "unfiltered"}, "filtered");
  if (figure.kind == FigureKind::grid) {
    read_grid(table, context, figure);
    return figure;
  }
  figure.methods = table.words("methods");
  known_methods(table, "methods", figure.methods, context.methods);
  figure.bench = select_bench(table, "name", context.benches, read_bench_values(table));
  if (figure.kind == FigureKind::closeups) {
    for (TomlTable& row_table : table.tables("rows")) {
      CloseupRow row;
      row.label = row_table.text("label");
      row.rectangle = read_rectangle(row_table, context.benches[figure.bench].scene);
      row.select = read_selection(row_table, figure, context);
      figure.rows.push_back(std::move(row));
    }
    table.refuse_others();
    return figure;
  }
  if (shows_errors(figure.kind)) {
    figure.scale = table.real("scale", 1e-9, 1e9, std::nullopt);
    if (context.cells.front().role != Role::reference) {
      table.fail("kind", "a figure of errors needs a [reference]");
    }
  }
  if (is_of_budget(figure.kind) && !context.budget) {
    table.fail("kind", fmt::format("'{}' needs a [budget]", kind));
  }
  if (figure.kind == FigureKind::failure_classes && figure.methods.size() != 1) {
    table.fail("methods", "accepted is one method: all that share its march have the same classes");
  }
  if (figure.kind == FigureKind::ambient_occlusion || figure.kind == FigureKind::lobes) {
    check_method_of_kind(table, figure, context);
  }
  if (figure.kind == FigureKind::lobes) read_lobes(table, context, figure);
  figure.select = read_selection(table, figure, context);
  return figure;
}

}  // namespace occlab
