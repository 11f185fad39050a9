#include "harness/experiment_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "harness/figure_source.h"
#include "harness/figures/canvas.h"
#include "harness/figures/figures.h"
#include "harness/files.h"
#include "harness/lobe_figures.h"
#include "renderers/methods/failure_classes.h"
#include "renderers/methods/method.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

std::string describe(const NamedValues& select) {
  std::string text;
  for (const auto& [name, value] : select) {
    text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", name, to_string(value));
  }
  return text;
}

/// What the file says is to be seen, as a paragraph of its own, and the text.
std::string captioned(const FigureSettings& figure, const std::string& text) {
  return figure.caption.empty() ? text : figure.caption + "\n" + text;
}

bool is_of_several_benches(const FigureSettings& figure) {
  return std::ranges::any_of(figure.panels, [&](const GridPanel& panel) {
    return panel.bench != figure.panels.front().bench;
  });
}

std::string display_caption(const FigureSettings& figure, const FigureSource& source) {
  return captioned(
      figure,
      fmt::format(
          "{} images. All panels share one exposure, {:.4g}, at which the {}reference's "
          "99th-percentile luminance is white.{}",
          figure.stage == "filtered" ? "Filtered" : "Unfiltered", source.exposure(),
          is_of_several_benches(figure) ? "first panel's " : "",
          figure.select.empty() ? "" : " Screen-space methods: " + describe(figure.select) + "."));
}

Image draw_comparison(const FigureSettings& settings, const FigureSource& source) {
  ComparisonFigure figure{settings.title, {}, display_caption(settings, source)};
  for (const std::string& method : settings.methods) {
    figure.panels.push_back({find_method(method).title, source.colour(method),
                             source.displayed(method, settings.select, settings.stage)});
  }
  return comparison_figure(figure);
}

Image draw_closeups(const FigureSettings& settings, const FigureSource& source) {
  CloseupFigure figure;
  figure.title = settings.title;
  figure.overview = tone_map(source.reference(), source.exposure(), source.mask());
  figure.caption = display_caption(settings, source);
  for (const std::string& method : settings.methods) {
    figure.columns.push_back({find_method(method).title, source.colour(method)});
  }
  for (const CloseupRow& row : settings.rows) {
    CloseupFigureRow closeups{row.label, describe(row.select), row.rectangle, {}};
    for (const std::string& method : settings.methods) {
      closeups.images.push_back(source.displayed(method, row.select, settings.stage));
    }
    figure.rows.push_back(std::move(closeups));
  }
  return closeup_figure(figure);
}

Image draw_errors(const FigureSettings& settings, const FigureSource& source) {
  ErrorFigure figure;
  figure.title = settings.title;
  figure.kind = ErrorMap::signed_luminance;
  figure.scale = settings.scale;
  figure.mask = source.mask();
  figure.caption = captioned(
      settings,
      fmt::format("{} images minus the reference, in units of the reference's mean luminance; one "
                  "fixed scale. {}",
                  settings.stage == "filtered" ? "Filtered" : "Unfiltered",
                  describe(settings.select)));
  for (const std::string& method : settings.methods) {
    const Image radiance = source.radiance(method, settings.select, settings.stage);
    figure.panels.push_back({find_method(method).title, source.colour(method),
                             error_map({.reference = source.reference_of(method, settings.select),
                                        .test = radiance,
                                        .mask = source.mask()},
                                       figure.kind)});
  }
  return error_figure(figure);
}

/// Pixels; larger figures leave some out.
constexpr int budget_page_width = 2600;

ErrorFigure map_figure(const FigureSettings& settings, const FigureSource& source, int columns) {
  ErrorFigure figure;
  figure.title = settings.title;
  figure.scale = settings.scale;
  figure.columns = columns;
  figure.mask = source.mask();
  return figure;
}

/// Shows so many of the pixels that the page stays about as wide as it may be, and says so.
Image draw_decimated(ErrorFigure figure) {
  figure.step = std::max(
      1, (figure.columns * figure.mask.width() + budget_page_width - 1) / budget_page_width);
  if (figure.step > 1) {
    figure.caption +=
        fmt::format(" Of {0}x{0} pixels one is shown; the numbers are of all.", figure.step);
  }
  return error_figure(figure);
}

/// The luminance of a - b in mean luminances of the reference.
Image luminance_difference(const Image& a, const Image& b, const FigureSource& source) {
  Image difference(a.width(), a.height(), 1);
  const auto luminance = [](const Image& image, std::size_t p) {
    const auto rgb = image.values().subspan(3 * p, 3);
    return 0.2126 * double(rgb[0]) + 0.7152 * double(rgb[1]) + 0.0722 * double(rgb[2]);
  };
  double sum = 0.0;
  std::size_t pixels = 0;
  for (std::size_t p = 0; p < difference.pixel_count(); ++p) {
    if (source.mask().values()[p] <= 0.5f) continue;
    difference.values()[p] = float(luminance(a, p) - luminance(b, p));
    sum += luminance(source.reference(), p);
    ++pixels;
  }
  for (float& value : difference.values()) value = float(double(value) * double(pixels) / sum);
  return difference;
}

Image draw_budget(const FigureSettings& settings, const FigureSource& source,
                  const std::filesystem::path& maps_file) {
  ErrorFigure figure = map_figure(settings, source, 4);
  Layers maps;
  for (const std::string& method : settings.methods) {
    const MeasuredCell& cell = source.cell(method, settings.select);
    const StoredBudget& budget = source.budget(cell);
    const Layers layers = source.layers(cell);
    for (const BudgetPart& part : budget_parts(
             budget.layers, *find_variant(budget.cell, cell.planned), source.reference(), layers)) {
      Image map = luminance_difference(*part.minuend, *part.subtrahend, source);
      maps.add(method + "_" + part.name, map);
      figure.panels.push_back(
          {find_method(method).title + ": " + part.name, source.colour(method), std::move(map)});
    }
  }
  figure.columns = int(figure.panels.size() / settings.methods.size());
  figure.caption = captioned(
      settings,
      fmt::format("A row's maps add up to the method's image minus the reference. Representation: "
                  "traced visibility, converged, minus the reference; visibility: the depth "
                  "buffer's, converged, minus the traced; sampling: one seed's samples minus "
                  "converged; filter: after minus before. {}.",
                  describe(settings.select)));
  write_exr(maps_file, maps, {});
  return draw_decimated(std::move(figure));
}

Image draw_failures(const FigureSettings& settings, const FigureSource& source) {
  ErrorFigure figure = map_figure(settings, source, 3);
  const StoredBudget& budget = source.budget(source.cell(settings.methods[0], settings.select));
  for (const std::string_view name : failure_class_names) {
    figure.panels.push_back({std::string(name), source.colour(settings.methods[0]),
                             budget.layers.at(std::string(name) + "_occlusion")});
  }
  figure.quantity =
      "ambient occlusion by the depth buffer minus traced; blue: light is lost, red: "
      "light leaks in";
  figure.caption = captioned(
      settings,
      "off_screen: the blocker is off the screen or behind the camera; hidden_blocker: it is "
      "behind "
      "the first surface of its pixel; thin: it is in full view, and the steps missed it; edge: a "
      "pixel's centre and the ray see different sides of a silhouette; behind_surface: a free ray "
      "passes behind the first surface; beyond_radius: what the ray meets is farther than d_max.");
  return draw_decimated(std::move(figure));
}

void write_numbers(const std::filesystem::path& path, const FigureSettings& settings,
                   const MeasuredCell& cell, nlohmann::json numbers) {
  numbers["figure"] = settings.name;
  numbers["method"] = cell.planned.method;
  numbers["cell"] = cell.id;
  write_text_atomically(path, numbers.dump(2) + "\n");
}

/// One channel as grey, three channels.
Image grey(const Image& channel) {
  Image rgb(channel.width(), channel.height(), 3);
  for (std::size_t p = 0; p < channel.pixel_count(); ++p) {
    for (std::size_t c = 0; c < 3; ++c) rgb.values()[3 * p + c] = channel.values()[p];
  }
  return rgb;
}

/// The light without occlusion, L / k_A; NaN where nothing gets in.
Image without_occlusion(const Image& radiance, const Image& occlusion) {
  Image open = radiance;
  for (std::size_t p = 0; p < occlusion.pixel_count(); ++p) {
    for (std::size_t c = 0; c < 3; ++c) open.values()[3 * p + c] /= occlusion.values()[p];
  }
  return open;
}

/// The mean over the surface, and which share of it is darker.
nlohmann::json occlusion_numbers(const Image& occlusion, const Image& mask) {
  double sum = 0.0;
  double pixels = 0.0;
  double below_half = 0.0;
  double below_nine_tenths = 0.0;
  for (std::size_t p = 0; p < occlusion.pixel_count(); ++p) {
    if (mask.values()[p] <= 0.5f) continue;
    pixels += 1.0;
    sum += double(occlusion.values()[p]);
    below_half += occlusion.values()[p] < 0.5f ? 1.0 : 0.0;
    below_nine_tenths += occlusion.values()[p] < 0.9f ? 1.0 : 0.0;
  }
  return {{"mean_ambient_occlusion", sum / pixels},
          {"share_below_0.5", below_half / pixels},
          {"share_below_0.9", below_nine_tenths / pixels}};
}

/// Light, occlusion and their product (Fig. 1 of the S3HO paper).
Image draw_ambient_occlusion(const FigureSettings& settings, const FigureSource& source,
                             const std::filesystem::path& numbers_file) {
  const std::string& method = settings.methods.front();
  const MeasuredCell& cell = source.cell(method, settings.select);
  const Layers layers = source.layers(cell);
  const Image& occlusion = layers.at("ambient_occlusion");
  const Image& radiance = layers.at("radiance");
  ComparisonFigure figure{settings.title, {}, display_caption(settings, source), 3};
  const auto add = [&](const char* label, const Image& image, double exposure) {
    figure.panels.push_back(
        {label, source.colour(method), tone_map(image, exposure, source.mask())});
  };
  add("diffuse light", without_occlusion(radiance, occlusion), source.exposure());
  add("ambient occlusion", grey(occlusion), 1.0);
  add("combined", radiance, source.exposure());
  write_numbers(numbers_file, settings, cell, occlusion_numbers(occlusion, source.mask()));
  return comparison_figure(figure);
}

Image draw_lobes_of(const Experiment& experiment, const FigureSettings& settings,
                    const FigureSource& source, const std::filesystem::path& numbers_file) {
  const std::string& method = settings.methods.front();
  const MeasuredCell& cell = source.cell(method, settings.select);
  const Layers layers = source.layers(cell);
  DrawnLobes drawn = draw_lobes(settings, {.experiment = experiment,
                                           .cell = cell.planned,
                                           .layers = layers,
                                           .mask = source.mask(),
                                           .exposure = source.exposure(),
                                           .colour = source.colour(method)});
  write_numbers(numbers_file, settings, cell, std::move(drawn.numbers));
  return std::move(drawn.image);
}

/// Panels of several benches, all at the exposure of the first one's.
Image draw_grid(const FigureSettings& settings, FigureSources& sources) {
  GridFigure figure;
  figure.title = settings.title;
  const FigureSource& first = sources.at(settings.bench);
  figure.caption = display_caption(settings, first);
  const auto heading = [&](const GridEntry& entry) {
    return GridHeading{entry.label, entry.method.empty() ? ink : sources.colour(entry.method),
                       describe(entry.select), entry.rectangle};
  };
  for (const GridEntry& column : settings.columns) figure.columns.push_back(heading(column));
  for (const GridEntry& row : settings.grid_rows) figure.rows.push_back(heading(row));
  for (const GridPanel& panel : settings.panels) {
    const FigureSource& source = sources.at(panel.bench);
    figure.images.push_back(tone_map(source.radiance(panel.method, panel.select, settings.stage),
                                     first.exposure(), source.mask()));
  }
  return grid_figure(figure);
}

Image draw(const Experiment& experiment, const FigureSettings& settings, FigureSources& sources,
           const std::filesystem::path& folder) {
  const std::filesystem::path numbers_file = folder / (settings.name + ".json");
  const FigureSource& source = sources.at(settings.bench);
  switch (settings.kind) {
    case FigureKind::comparison:
      return draw_comparison(settings, source);
    case FigureKind::closeups:
      return draw_closeups(settings, source);
    case FigureKind::error_map:
      return draw_errors(settings, source);
    case FigureKind::error_budget:
      return draw_budget(settings, source, folder / (settings.name + ".exr"));
    case FigureKind::failure_classes:
      return draw_failures(settings, source);
    case FigureKind::ambient_occlusion:
      return draw_ambient_occlusion(settings, source, numbers_file);
    case FigureKind::lobes:
      return draw_lobes_of(experiment, settings, source, numbers_file);
    case FigureKind::grid:
      return draw_grid(settings, sources);
  }
  return {};
}

}  // namespace

void write_figures(const Experiment& experiment, const std::vector<FigureBench>& benches,
                   const std::filesystem::path& folder) {
  if (experiment.figures.empty()) return;
  for (const FigureBench& bench : benches) {
    if (!bench.cells.empty() && bench.cells.front().planned.role == Role::reference) continue;
    throw InputError(
        fmt::format("{}: key 'figure': figures need a [reference]", experiment.file.string()));
  }
  create_folder(folder);
  FigureSources sources(experiment, benches);
  for (const FigureSettings& settings : experiment.figures) {
    write_png(folder / (settings.name + ".png"), draw(experiment, settings, sources, folder));
  }
}

}  // namespace occlab
