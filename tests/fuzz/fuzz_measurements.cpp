// measurements.csv: what is read must be written and read again as the same rows.
#include "harness/measurements.h"
#include "renderers/scene/error.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace occlab;
  std::vector<Measurement> rows;
  try {
    rows = measurements_from_csv(fuzz::text_of(data, size), "measurements.csv");
  } catch (const InputError&) {
    return 0;
  }
  fuzz::require(measurements_from_csv(measurements_to_csv(rows), "again") == rows);
  return 0;
}
