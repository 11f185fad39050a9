// read_grid of config_parts.h.

#include <fmt/format.h>

#include <algorithm>

#include "harness/config_parts.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

/// The methods that the entries name, in their order, each once.
std::vector<std::string> methods_of(const std::vector<GridEntry>& columns,
                                    const std::vector<GridEntry>& rows) {
  std::vector<std::string> methods;
  for (const auto* entries : {&columns, &rows}) {
    for (const GridEntry& entry : *entries) {
      if (entry.method.empty() || std::ranges::find(methods, entry.method) != methods.end()) {
        continue;
      }
      methods.push_back(entry.method);
    }
  }
  return methods;
}

/// What selects no cell yet: the method of every entry. All name one, or none does.
std::vector<GridEntry> read_methods(std::vector<TomlTable>& tables) {
  std::vector<GridEntry> entries;
  for (TomlTable& table : tables) {
    GridEntry entry;
    entry.label = table.text("label");
    entry.method = table.text("method", "");
    if (!entries.empty() && entry.method.empty() != entries.front().method.empty()) {
      table.fail("method", "accepted is a method in all of them or in none");
    }
    entries.push_back(std::move(entry));
  }
  return entries;
}

NamedValues joined(const NamedValues& a, const NamedValues& b, const TomlTable& table) {
  NamedValues all = a;
  for (const auto& [name, value] : b) {
    if (std::ranges::find(a, name, &NamedValues::value_type::first) != a.end()) {
      table.fail(name, "it is also given elsewhere in the figure");
    }
    all.emplace_back(name, value);
  }
  return all;
}

std::vector<Axis> joined(std::vector<Axis> a, const std::vector<Axis>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

class GridReader {
 public:
  GridReader(TomlTable& table, const FigureContext& context, FigureSettings& figure)
      : table_(table), context_(context), figure_(figure) {}

  void read() {
    std::vector<TomlTable> columns = table_.tables("columns");
    std::vector<TomlTable> rows = table_.tables("rows");
    figure_.columns = read_methods(columns);
    figure_.grid_rows = read_methods(rows);
    if (figure_.columns.front().method.empty() == figure_.grid_rows.front().method.empty()) {
      table_.fail("rows", "accepted is a method in every column or in every row, not in both");
    }
    figure_.methods = methods_of(figure_.columns, figure_.grid_rows);
    read_rest(columns, figure_.columns);
    const std::vector<Axis> bench = read_bench_values(table_);
    figure_.select = parameters(table_);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      GridEntry& row = figure_.grid_rows[r];
      row.bench = read_bench_values(rows[r]);
      const bool enlarged = rows[r].has("rectangle");
      for (std::size_t c = 0; c < figure_.columns.size(); ++c) {
        const std::vector<Axis> values = joined(joined(bench, figure_.columns[c].bench), row.bench);
        add_panel(rows[r], c, row, select_bench(rows[r], "label", context_.benches, values));
      }
      if (enlarged) {
        row.rectangle =
            read_rectangle(rows[r], context_.benches[figure_.panels.front().bench].scene);
      }
      row.select = parameters(rows[r]);
    }
    select_cells(rows);
    figure_.bench = figure_.panels.front().bench;
  }

 private:
  NamedValues parameters(TomlTable& table) {
    const auto known = known_methods(table, "method", figure_.methods, context_.methods);
    return single_values(read_parameters(table, known, {}));
  }

  void read_rest(std::vector<TomlTable>& tables, std::vector<GridEntry>& entries) {
    for (std::size_t i = 0; i < tables.size(); ++i) {
      entries[i].bench = read_bench_values(tables[i]);
      entries[i].select = parameters(tables[i]);
    }
  }

  void add_panel(const TomlTable& table, std::size_t column, const GridEntry& row,
                 std::size_t bench) {
    const std::string& method = row.method.empty() ? figure_.columns[column].method : row.method;
    figure_.panels.push_back({method, {}, bench});
    const SceneSettings& first = context_.benches[figure_.panels.front().bench].scene;
    const SceneSettings& scene = context_.benches[bench].scene;
    if (scene.width == first.width && scene.height == first.height) return;
    table.fail("label", fmt::format("panels of {}x{} and of {}x{} pixels; accepted are equal ones",
                                    first.width, first.height, scene.width, scene.height));
  }

  /// Each panel's cell is there, and is one.
  void select_cells(const std::vector<TomlTable>& rows) {
    const std::size_t columns = figure_.columns.size();
    for (std::size_t i = 0; i < figure_.panels.size(); ++i) {
      const TomlTable& table = rows[i / columns];
      const GridEntry& column = figure_.columns[i % columns];
      GridPanel& panel = figure_.panels[i];
      panel.select = joined(joined(figure_.select, column.select, table),
                            figure_.grid_rows[i / columns].select, table);
      try {
        select_group(context_.cells, panel.method, panel.select);
      } catch (const SelectionError& error) {
        table.fail("label", fmt::format("column '{}': {}", column.label, error.what()));
      }
    }
  }

  TomlTable& table_;
  const FigureContext& context_;
  FigureSettings& figure_;
};

}  // namespace

void read_grid(TomlTable& table, const FigureContext& context, FigureSettings& figure) {
  GridReader(table, context, figure).read();
}

}  // namespace occlab
