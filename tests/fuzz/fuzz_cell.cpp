// CellStore::read of a cell whose cell.json stands before the first NUL and whose layers.exr
// follows. "$SHA256" and "$BYTES" become those of layers.exr, which no fuzzer would guess.
#include "harness/store.h"
#include "renderers/scene/error.h"
#include "renderers/scene/limits.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

std::string with(std::string text, std::string_view name, const std::string& value) {
  const std::size_t place = text.find(name);
  return place == std::string::npos ? text : text.replace(place, name.size(), value);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace occlab;
  static const fuzz::Folder folder;
  static const bool set_up = [] {
    set_limits("image_pixels=32768,image_channels=64,image_bytes=8388608");
    return true;
  }();
  const fuzz::TwoParts parts = fuzz::split(fuzz::text_of(data, size));
  CellKey key;
  key.add("method", "ssao");
  key.add("samples", "4");
  const std::filesystem::path store = folder.path() / "store";
  const std::filesystem::path cell = store / "cells" / key.id();
  std::filesystem::create_directories(cell);
  const std::string place = "store/cells/" + key.id();
  folder.write(place + "/layers.exr", parts.second);
  folder.write(place + "/cell.json",
               with(with(std::string(parts.first), "$SHA256", sha256_text(parts.second)), "$BYTES",
                    std::to_string(parts.second.size())));
  try {
    const ReadCell found = CellStore(store).read(key);
    fuzz::require(set_up && found.cell.has_value() == found.warning.empty());
    if (found.cell) fuzz::require(!found.cell->layers.all().empty());
  } catch (const InputError&) {
  }
  std::filesystem::remove_all(store);
  return 0;
}
