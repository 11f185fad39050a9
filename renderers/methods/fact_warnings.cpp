#include "renderers/methods/fact_warnings.h"

#include <fmt/format.h>

namespace occlab {

std::vector<std::string> fact_warnings(const ParameterSet& parameters, const Metadata& facts) {
  const auto count = [&](const char* name) {
    const auto fact = facts.find(name);
    return fact == facts.end() ? std::string("0") : fact->second;
  };
  std::vector<std::string> warnings;
  if (const std::string pixels = count("open_mesh_pixels"); pixels != "0") {
    warnings.push_back(fmt::format(
        "visibility=peeled: {} pixels show open meshes (open_mesh_pixels); where a back "
        "is missing, all that is behind the front counts as solid",
        pixels));
  }
  if (const std::string cameras = count("cameras_blind"); cameras != "0") {
    warnings.push_back(fmt::format(
        "visibility=multiview: {} of the cameras see no surface (cameras_blind)", cameras));
  }
  if (parameters.has("bounce_lights") && parameters.integer("bounce_lights") > 0 &&
      count("virtual_lights") == "0") {
    warnings.emplace_back(
        "virtual_lights is 0: no lamp or sun reaches a surface that reflects, and the "
        "environment's "
        "light does not bounce");
  }
  return warnings;
}

}  // namespace occlab
