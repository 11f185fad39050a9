#include "harness/history/gate_settings.h"

#include <fmt/format.h>

#include "harness/csv.h"
#include "harness/history/gate_formats.h"
#include "harness/toml_reader.h"
#include "renderers/scene/error.h"

namespace occlab::history {

void read_gate_settings(const std::string& path, GateSettings& gate) {
  const toml::table root = parse_toml(path, {});
  TomlTable table(root, "", path);
  gate.level = table.real("level", 1e-6, 0.5, gate.level);
  if (table.has("minimum_effect")) {
    TomlTable effects = table.table("minimum_effect");
    for (const std::string& name : effects.others()) {
      gate.minimum.set(name, effects.real(name, 0.0, 1e6, std::nullopt),
                       path + ": key 'minimum_effect'");
    }
  }
  table.refuse_others();
}

void apply_minimum_effects(const std::vector<std::string>& settings, MinimumEffects& minimum) {
  for (const std::string& setting : settings) {
    const std::string where = "--minimum-effect " + setting;
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos) {
      throw InputError(where + ": accepted is CLASS=VALUE, such as error=0.02");
    }
    minimum.set(setting.substr(0, equals), parse_number(setting.substr(equals + 1), where), where);
  }
}

nlohmann::json accepted_findings(const GateReport& report) {
  nlohmann::json all = nlohmann::json::array();
  for (const Finding& finding : report.findings) {
    if (finding.outcome > Outcome::missing) continue;
    all.push_back(
        {{"series", series_key(finding.series)},
         {"verdict", to_string(finding.outcome)},
         {"what", series_label(finding.series, {})},
         {"effect", finding.effect ? effect_text(*finding.effect, finding.relative) : ""}});
  }
  for (const std::string& input : report.inputs) {
    all.push_back({{"series", ""}, {"verdict", "CHANGED"}, {"what", input}, {"effect", ""}});
  }
  return all;
}

}  // namespace occlab::history
