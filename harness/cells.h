#pragma once

#include <string>
#include <vector>

#include "harness/config.h"
#include "harness/store.h"
#include "harness/workbench.h"

namespace occlab {

/// Names and values in declared order, without `seed`: what a measurement's parameters are.
std::vector<std::pair<std::string, std::string>> named_parameters(const ParameterSet& parameters);

/// What determines the pixels of everything that is made on a workbench, beside the code.
struct BenchFacts {
  std::string scene_hash;
  std::string view;
  Resolution resolution;
  std::string probe_hash;
  ProbeSettings probe;
  std::string device;  ///< DeviceInfo::renderer
  std::string driver;  ///< DeviceInfo::version
};
BenchFacts bench_facts(const Workbench& bench);

/// Scene, view, light, device and code.
CellKey bench_key(const BenchFacts& facts);
CellKey workbench_key(const Workbench& bench);

/// What determines a cell's pixels on this workbench.
CellKey cell_key(const BenchFacts& facts, const PlannedCell& cell);
CellKey cell_key(const Workbench& bench, const PlannedCell& cell);

/// Renders the cell with its method. A reference cell also holds the `mask` of its surface points;
/// of a method's reseeded runs only seed 0 keeps the method's own layers (16 channels for S3HO).
/// `facts` gets what the method reports and the wall time.
Layers render_cell(Workbench& bench, const PlannedCell& cell, OcclusionMethod& method,
                   Metadata& facts);

/// What an EXR says of where it was made.
Metadata workbench_metadata(const Workbench& bench);

/// What the EXR says of itself.
Metadata cell_metadata(const Workbench& bench, const PlannedCell& cell, const Metadata& facts);

}  // namespace occlab
