#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "harness/report/cells.h"

namespace occlab::report {

// What the page takes from the experiment's text in run.json. Where a key is missing or odd, so is
// what would have been shown of it: the text was checked when it was run.

/// Of every figure: name, kind, title, stage, scale, methods.
nlohmann::json figures_of(const std::string& configuration);

/// Of every row of a closeup figure: figure, label, rectangle in pixels, select (texts by name).
nlohmann::json closeups_of(const std::string& configuration, int width, int height);

/// Order-4 SH of the experiment's probe in view space, as S3HO reads it (c[env] of its eq. 4):
/// {"sh": [R, G, B] of 16 each}, or {"missing": why}. `facts` are a cell's: the probe and the scene
/// must still be the files that the cell was lit by.
nlohmann::json light_of(const std::string& configuration, const NamedTexts& facts);

}  // namespace occlab::report
