#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "harness/claims/verdicts.h"

namespace occlab {

/// What a claim was when somebody accepted it.
struct RecordedClaim {
  ClaimVerdict verdict = ClaimVerdict::not_reproduced;
  std::string statement;  ///< what was tested: the statement and the value
  std::string device;     ///< on which it was measured
};

/// The verdicts that are expected, by the ids of the claims.
struct ClaimRecord {
  std::string commit;  ///< of the occlab that wrote it
  std::map<std::string, RecordedClaim> claims;
};

/// An empty record where there is no such file. Throws InputError that names file and key.
ClaimRecord read_record(const std::filesystem::path& path);
void write_record(const std::filesystem::path& path, const ClaimRecord& record);

/// The record after these verdicts: claims that cannot be tested now keep what they had.
ClaimRecord accept(const ClaimRecord& before, const JudgedClaims& claims,
                   const std::string& commit);

/// How the verdicts differ from the record.
struct RecordComparison {
  /// Of claims that were reproduced and are not any more, or are gone: a failure.
  std::vector<std::string> lost;
  /// What is worth saying: new verdicts, other devices, other statements.
  std::vector<std::string> remarks;
  std::size_t untested = 0;  ///< how many were reproduced and cannot be tested now
};
/// A claim about times that was accepted on another device is not compared, nor one whose statement
/// has changed.
RecordComparison compare(const ClaimRecord& record, const JudgedClaims& claims);

}  // namespace occlab
