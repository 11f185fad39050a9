#pragma once

#include "harness/verify/check.h"

namespace occlab {

/// The metrics against closed forms and published or independently computed values. Subject
/// "metrics"; takes some hundredths of a second.
Checks verify_metrics();

}  // namespace occlab
