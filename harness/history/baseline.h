#pragma once

#include <string>
#include <vector>

#include "harness/history/gate.h"
#include "harness/history/store.h"

namespace occlab::history {

/// Fills in the commit, its subject and time where they are empty: the commit is that of the
/// program that made the run, else HEAD of the current folder; subject and time are git's, where it
/// has the commit. Throws InputError where no commit is known.
void complete_commit(RunFacts& facts);

/// What RESULTS are compared with.
struct ChosenBaseline {
  GateSide side;
  /// Runs of other commits of the same experiment, by commit: how times vary from run to run.
  std::vector<std::vector<RunData>> others;
};

/// `against`: the name of an accepted baseline, a results folder or file of measurements, or a
/// commit whose run is in the history (`database`, nullptr: there is none) or that git knows there
/// by another name; or several results, repeated runs of one experiment. Runs of that commit and
/// experiment are taken together. Throws InputError saying what there is.
ChosenBaseline choose_baseline(const Sqlite* database, const std::vector<std::string>& against,
                               const std::string& experiment);

}  // namespace occlab::history
