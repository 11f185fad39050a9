// A file that is opened as a history: everything that is read of it, then an acceptance.
#include "harness/history/schema.h"
#include "harness/history/store.h"
#include "renderers/scene/error.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace occlab;
  using namespace occlab::history;
  static const fuzz::Folder folder;
  const std::filesystem::path file = folder.write("h.sqlite", fuzz::text_of(data, size));
  try {
    const Sqlite database = open_history(file, false);
    for (const StoredRun& run : list_runs(database)) {
      for (const SeriesValues& values : read_run(database, run).series) {
        fuzz::require(series_key(values.series).size() == 16);
      }
      (void)runs_of_commit(database, run.commit);
    }
    (void)list_baselines(database);
    for (const Intended& mark : list_intended(database)) add_intended(database, mark);
  } catch (const InputError&) {
  } catch (const DeviceError&) {
  }
  std::filesystem::remove_all(folder.path() / "h.sqlite-journal");
  std::filesystem::remove_all(folder.path() / "h.sqlite-wal");
  return 0;
}
