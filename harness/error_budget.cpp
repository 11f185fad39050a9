#include "harness/error_budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "harness/cells.h"
#include "renderers/methods/failure_classes.h"

namespace occlab {
namespace {

/// What all variants of a budget cell share, and what tells its variants apart.
std::string march_of(const ParameterSet& parameters) {
  return parameters.to_string({Factor::visibility});
}
std::string variant_of(const PlannedCell& cell) {
  return cell.method + " " +
         cell.parameters.to_string({Factor::visibility, Factor::representation, Factor::lighting});
}

std::vector<ConvergedMethod> converged_methods(const BudgetCell& cell) {
  std::vector<ConvergedMethod> methods;
  for (const BudgetVariant& variant : cell.variants) {
    methods.push_back({find_method(variant.planned.method).representation,
                       pass_constants(variant.planned.parameters)});
  }
  return methods;
}

void add_converged(const BudgetCell& cell, const std::string& source,
                   std::vector<Converged> converged, Layers& layers, Metadata& facts) {
  for (std::size_t v = 0; v < converged.size(); ++v) {
    const std::string name = cell.variants[v].name + "_" + source;
    facts[name + "_standard_error"] = fmt::format("{}", converged[v].standard_error);
    facts[name + "_directions"] = std::to_string(converged[v].directions);
    facts[name + "_reached"] = converged[v].reached ? "yes" : "no";
    layers.add(name, std::move(converged[v].radiance));
  }
}

}  // namespace

bool has_budget(const PlannedCell& cell) {
  const Representation* const representation = find_method(cell.method).representation;
  // What blockers send is not converged here.
  return cell.role == Role::test && representation && !representation->bounce &&
         !traces(cell.parameters);
}

const BudgetVariant* find_variant(const BudgetCell& budget, const PlannedCell& cell) {
  if (!has_budget(cell)) return nullptr;
  const auto found = std::ranges::find_if(budget.variants, [&](const BudgetVariant& variant) {
    return variant_of(variant.planned) == variant_of(cell);
  });
  return found == budget.variants.end() ? nullptr : &*found;
}

std::vector<BudgetPart> budget_parts(const Layers& budget, const BudgetVariant& variant,
                                     const Image& reference, const Layers& cell) {
  const Image& traced = budget.at(variant.name + "_traced");
  const Image& depth = budget.at(variant.name + "_depth");
  const Image* unfiltered = cell.find("radiance_unfiltered");
  const Image& radiance = cell.at("radiance");
  std::vector<BudgetPart> parts = {{"representation", &traced, &reference},
                                   {"visibility", &depth, &traced},
                                   {"sampling", unfiltered ? unfiltered : &radiance, &depth}};
  if (unfiltered) parts.push_back({"filter", &radiance, unfiltered});
  return parts;
}

std::vector<BudgetCell> plan_budget(const std::vector<PlannedCell>& cells) {
  std::vector<BudgetCell> budget;
  std::map<std::string, std::size_t> marches;
  std::map<std::string, bool> variants;
  for (const PlannedCell& cell : cells) {
    if (!has_budget(cell) || !variants.emplace(variant_of(cell), true).second) continue;
    const auto [march, is_new] = marches.emplace(march_of(cell.parameters), budget.size());
    if (is_new) budget.emplace_back();
    std::vector<BudgetVariant>& list = budget[march->second].variants;
    const auto again = std::ranges::count(
        list, cell.method, [](const BudgetVariant& variant) { return variant.planned.method; });
    list.push_back({again == 0 ? cell.method : fmt::format("{}_{}", cell.method, again + 1), cell});
  }
  return budget;
}

CellKey budget_key(CellKey key, const BudgetCell& cell, const BudgetSettings& settings) {
  for (const BudgetVariant& variant : cell.variants) {
    key.add("budget of " + variant.name, variant_of(variant.planned));
  }
  key.add("tolerance", fmt::format("{}", settings.tolerance));
  key.add("budget_seconds", fmt::format("{}", settings.budget_seconds));
  return key;
}

Layers render_budget(Workbench& bench, const BudgetCell& cell, const BudgetSettings& settings,
                     Metadata& facts) {
  const Frame& frame = bench.frame();
  const std::vector<ConvergedMethod> methods = converged_methods(cell);
  const PassConstants& constants = methods.front().constants;
  const GBufferImages& surface =
      frame.surface(gbuffer_bits(cell.variants.front().planned.parameters));
  const TracedScene& traced = frame.traced();
  const Convergence convergence{.tolerance = settings.tolerance,
                                .budget_seconds = settings.budget_seconds};
  Layers layers;
  add_converged(cell, "traced",
                converge(surface, frame.lighting, traced_visibility(traced, frame.view, constants),
                         methods, convergence),
                layers, facts);
  const ParameterSet& parameters = cell.variants.front().planned.parameters;
  add_converged(
      cell, "depth",
      converge(surface, frame.lighting, visibility_source(frame, parameters), methods, convergence),
      layers, facts);
  std::optional<HiddenSettings> hidden = hidden_settings(parameters);
  if (hidden) hidden->complete = true;
  Failures failures =
      classify_failures(surface, frame.view, traced, frame.lighting, constants, convergence,
                        hidden ? &frame.hidden_images(*hidden) : nullptr);
  facts["classes_standard_error"] = fmt::format("{}", failures.standard_error);
  facts["classes_directions"] = std::to_string(failures.directions);
  facts["classes_reached"] = failures.reached ? "yes" : "no";
  for (std::size_t c = 0; c < failure_class_names.size(); ++c) {
    const std::string name(failure_class_names[c]);
    layers.add(name + "_occlusion", std::move(failures.classes[c].occlusion));
    layers.add(name + "_radiance", std::move(failures.classes[c].radiance));
  }
  return layers;
}

}  // namespace occlab
