#pragma once

#include "harness/tables.h"

namespace occlab {

/// Each method's error at one stage by its parts (error_budget.h): RMS, signed mean and share of
/// the mean squared error. Shares and means of a row's parts add up to those of its total.
Table budget_table(const std::vector<Measurement>& measurements, const std::string& stage);

/// What the march through the depth buffer gets wrong, by class (methods/failure_classes.h).
Table failure_table(const std::vector<Measurement>& measurements);

}  // namespace occlab
