#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "harness/claims/statement.h"
#include "renderers/methods/method.h"

namespace occlab {

/// One case of a claim: its statement for one choice of the variables.
struct ClaimCase {
  std::string label;  ///< "N=32, M=ssdo"; "" where there is one case only
  std::optional<ClaimStatement> statement;
  std::optional<ClaimQuantity> value;  ///< what the paper published a number of
  std::optional<double> published;     ///< there with `value`
};

/// One claim of a paper. Formats: configs/FORMAT.md.
struct Claim {
  std::string id;         ///< [a-z0-9_-]+
  std::string paper;      ///< s3ho or ssdo
  std::string place;      ///< "section 4, Table 1"
  std::string text;       ///< in our words
  std::string statement;  ///< as it is in the file; "" if there is none
  std::string value;
  std::string experiment;  ///< whose measurements it is about
  bool hardware = false;   ///< says nothing on a software rasteriser
  std::string untestable;  ///< why it cannot be tested; the rest is empty then
  double level = 0.05;     ///< the adjusted p-value at which it counts
  double tolerance = 0.0;  ///< of a published value: how far from the interval, as a share of it
  double precision = 0.1;  ///< how wide the interval's half may be at most, as a share of it
  std::vector<ClaimCase> cases;
};

/// Where a paper disagrees with itself or with the other one.
struct Contradiction {
  std::string id;
  std::string paper;
  std::string place;
  std::string text;
  std::string reading;  ///< what we take it to mean
};

struct ClaimFile {
  double level = 0.05;  ///< of all claims together
  /// How the measurements of an experiment are made, by its name.
  std::map<std::string, std::string> commands;
  std::vector<Claim> claims;
  std::vector<Contradiction> contradictions;
};

/// Throws InputError that names file, line and key.
ClaimFile load_claims(const std::filesystem::path& path, const std::vector<MethodInfo>& methods);

}  // namespace occlab
