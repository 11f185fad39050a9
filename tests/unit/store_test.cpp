#include "harness/store.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <limits>
#include <thread>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr int child_cells = 100000;

CellKey numbered_key(int number) {
  CellKey key;
  key.add("method", "ssao");
  key.add("number", fmt::format("{}", number));
  return key;
}

/// Two layers, with the values that a careless writer would lose.
Layers numbered_layers(int number, int size = 24) {
  Layers layers;
  Image radiance(size, size, 3, float(number) / 3.0f);
  radiance.at(1, 2, 0) = 1e-30f;
  radiance.at(3, 2, 1) = -65505.5f;
  layers.add("radiance", std::move(radiance));
  layers.add("ambient_occlusion", Image(size, size, 1, 0.25f));
  return layers;
}

class StoreTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / fmt::format("occlab_store_test_{}", getpid());
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(CellStore& store, int number) {
    return store.write(numbered_key(number), numbered_layers(number), {{"occlab:method", "ssao"}},
                       {{"wall_ms", 12.5}});
  }
  /// Files and folders directly below `folder`, sorted.
  static std::vector<std::string> entries(const fs::path& folder) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder)) {
      names.push_back(entry.path().filename().string());
    }
    std::ranges::sort(names);
    return names;
  }

  fs::path folder_;
};

std::string read_file(const fs::path& path) { return read_text(path); }

void edit_file(const fs::path& path, const std::string& from, const std::string& to) {
  std::string text = read_file(path);
  const std::size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos);
  std::ofstream(path, std::ios::binary) << text.replace(at, from.size(), to);
}

void flip_byte(const fs::path& path, std::size_t at) {
  std::string bytes = read_file(path);
  ASSERT_LT(at, bytes.size());
  bytes[at] = char(bytes[at] ^ 0x40);
  std::ofstream(path, std::ios::binary) << bytes;
}

TEST(CellKey, EveryFactAndTheirOrderCount) {
  CellKey key = numbered_key(1);
  EXPECT_EQ(key.hash(), sha256_text(R"([["method","ssao"],["number","1"]])"));
  EXPECT_EQ(key.hash().size(), 64u);
  EXPECT_EQ(key.id(), key.hash().substr(0, 16));
  EXPECT_NE(key.hash(), numbered_key(2).hash());
  CellKey swapped;
  swapped.add("number", "1");
  swapped.add("method", "ssao");
  EXPECT_NE(swapped.hash(), key.hash());
  CellKey joined;  // names and values do not run into each other
  joined.add("method", "ssao\",\"number");
  EXPECT_NE(joined.hash(), key.hash());
  CellKey bytes;
  bytes.add("file", "\xff");
  EXPECT_THROW(bytes.hash(), InputError);
}

TEST_F(StoreTest, ReadsBackWhatWasWritten) {
  CellStore store(folder_);
  EXPECT_FALSE(store.has(numbered_key(1)));
  EXPECT_FALSE(store.read(numbered_key(1)).cell);
  const fs::path cell_folder = write(store, 1);
  EXPECT_EQ(cell_folder, folder_ / "cells" / numbered_key(1).id());
  EXPECT_EQ(entries(cell_folder), (std::vector<std::string>{"cell.json", "layers.exr"}));
  EXPECT_TRUE(store.has(numbered_key(1)));
  EXPECT_FALSE(store.has(numbered_key(2)));

  const ReadCell read = CellStore(folder_).read(numbered_key(1));
  ASSERT_TRUE(read.cell);
  EXPECT_EQ(read.warning, "");
  EXPECT_EQ(read.cell->id, numbered_key(1).id());
  EXPECT_EQ(read.cell->metadata.at("occlab:method"), "ssao");
  EXPECT_EQ(read.cell->extra["wall_ms"], 12.5);
  const Layers expected = numbered_layers(1);
  ASSERT_EQ(read.cell->layers.all().size(), 2u);
  for (const auto& layer : expected.all()) {
    EXPECT_EQ(read.cell->layers.at(layer.name), layer.image) << layer.name;
  }
  const auto description = nlohmann::json::parse(read_file(cell_folder / "cell.json"));
  EXPECT_EQ(description["key"], numbered_key(1).hash());
  EXPECT_EQ(description["facts"][1][1], "1");
  EXPECT_EQ(description["layers.exr"]["sha256"], sha256_file(cell_folder / "layers.exr"));
}

TEST_F(StoreTest, AFinishedCellIsNeverChanged) {
  CellStore store(folder_);
  const fs::path cell = write(store, 1);
  const std::string before = read_file(cell / "cell.json");
  store.write(numbered_key(1), numbered_layers(7), {}, {{"wall_ms", 99}});
  EXPECT_EQ(read_file(cell / "cell.json"), before);
  EXPECT_EQ(entries(folder_ / "cells").size(), 1u) << "the second writer leaves nothing";
}

TEST_F(StoreTest, DamagedCellsAreMovedAsideAndMissing) {
  CellStore store(folder_);
  const std::vector<std::pair<std::string, std::function<void(const fs::path&)>>> damages = {
      {"the checksum of layers.exr is wrong",
       [](const fs::path& cell) { flip_byte(cell / "layers.exr", 400); }},
      {"layers.exr has 0 bytes instead of",
       [](const fs::path& cell) { std::ofstream(cell / "layers.exr").close(); }},
      {"layers.exr is missing", [](const fs::path& cell) { fs::remove(cell / "layers.exr"); }},
      {"cell.json is missing", [](const fs::path& cell) { fs::remove(cell / "cell.json"); }},
      {"cell.json is not JSON",
       [](const fs::path& cell) { fs::resize_file(cell / "cell.json", 40); }},
      {"cell.json is not JSON",
       [](const fs::path& cell) { std::ofstream(cell / "cell.json") << std::string(3, '\0'); }},
      {"cell.json is incomplete",
       [](const fs::path& cell) { std::ofstream(cell / "cell.json") << "{\"facts\": []}"; }}};
  int number = 0;
  for (const auto& [reason, damage] : damages) {
    const fs::path cell = write(store, ++number);
    damage(cell);
    const bool pixels_only = number == 1;
    EXPECT_EQ(store.has(numbered_key(number)), pixels_only) << "has() does not read the pixels";
    const ReadCell read = store.read(numbered_key(number));
    EXPECT_FALSE(read.cell);
    EXPECT_NE(read.warning.find(reason), std::string::npos) << read.warning;
    EXPECT_NE(read.warning.find(cell.string()), std::string::npos) << read.warning;
    EXPECT_FALSE(fs::exists(cell));
    EXPECT_EQ(entries(folder_ / "damaged").size(), std::size_t(number));
    EXPECT_FALSE(store.has(numbered_key(number)));
    write(store, number);
    EXPECT_TRUE(store.read(numbered_key(number)).cell);
  }
}

TEST_F(StoreTest, WritingOverADamagedCellReplacesIt) {
  CellStore store(folder_);
  const fs::path cell = write(store, 1);
  fs::remove(cell / "layers.exr");
  write(store, 1);
  EXPECT_TRUE(store.read(numbered_key(1)).cell);
  EXPECT_EQ(entries(folder_ / "damaged").size(), 1u);
  fs::remove_all(cell);
  std::ofstream(cell) << "a file where a cell should be";
  write(store, 1);
  EXPECT_TRUE(store.read(numbered_key(1)).cell);
}

TEST_F(StoreTest, AnEditedDescriptionIsDamaged) {
  CellStore store(folder_);
  for (const auto& [from, to] : {std::pair{"\"ssao\"", "\"s3ho\""}, std::pair{"12.5", "13.5"},
                                 std::pair{"\"format\": 1", "\"format\": 2"}}) {
    edit_file(write(store, 1) / "cell.json", from, to);
    const ReadCell read = store.read(numbered_key(1));
    EXPECT_FALSE(read.cell) << from;
    EXPECT_NE(read.warning.find("the checksum of cell.json is wrong"), std::string::npos)
        << read.warning;
  }
}

TEST_F(StoreTest, AnotherKeyInTheCellIsAnError) {
  CellStore store(folder_);
  const fs::path cell = store.cell_folder(numbered_key(1));
  fs::rename(write(store, 2), cell);
  try {
    store.has(numbered_key(1));
    FAIL();
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find((cell / "cell.json").string()), std::string::npos) << message;
    EXPECT_NE(message.find(R"(["number","2"] where ["number","1"])"), std::string::npos) << message;
  }
  EXPECT_THROW(store.read(numbered_key(1)), InputError);
  EXPECT_THROW(write(store, 1), InputError);
  EXPECT_EQ(entries(folder_ / "cells").size(), 1u) << "the temporary is gone, the cell is not";
}

TEST_F(StoreTest, FoldersThatCannotBeUsed) {
  const auto error_of = [](const fs::path& folder) -> std::string {
    try {
      CellStore store(folder);
    } catch (const DeviceError& error) {
      return error.what();
    }
    return "no error";
  };
  fs::create_directories(folder_);
  std::ofstream(folder_ / "file") << "x";
  EXPECT_NE(error_of(folder_ / "file").find((folder_ / "file").string()), std::string::npos);
  EXPECT_NE(error_of(folder_ / "file").find("Not a directory"), std::string::npos);
  EXPECT_NE(error_of("/proc/occlab").find("/proc/occlab"), std::string::npos);
  if (geteuid() != 0) {  // the superuser may write everywhere
    fs::create_directories(folder_ / "sealed/cells");
    fs::permissions(folder_ / "sealed/cells", fs::perms::owner_read | fs::perms::owner_exec);
    EXPECT_NE(error_of(folder_ / "sealed").find("Permission denied"), std::string::npos);
  }
}

/// Files may not grow beyond `bytes` while this lives: a full disk for one process.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    handler_ = signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

TEST_F(StoreTest, AFullDiskLeavesNothingHalfWritten) {
  CellStore store(folder_);
  std::size_t failures = 0;
  // 100 bytes stop cell.json or the EXR's header, 5000 the pixels.
  for (const rlim_t bytes : {rlim_t{100}, rlim_t{1500}, rlim_t{5000}}) {
    Layers noise;
    Image image(64, 64, 3);
    unsigned state = 1;
    for (float& value : image.values())
      value = float((state = state * 1664525u + 1013904223u) >> 8);
    noise.add("radiance", std::move(image));
    const FileSizeLimit limit(bytes);
    try {
      store.write(numbered_key(1), noise, {});
    } catch (const DeviceError& error) {
      ++failures;
      EXPECT_NE(std::string(error.what()).find(folder_.string()), std::string::npos)
          << error.what();
    }
  }
  EXPECT_EQ(failures, 3u);
  EXPECT_TRUE(entries(folder_ / "cells").empty());
  write(store, 1);
  EXPECT_TRUE(store.read(numbered_key(1)).cell);
}

TEST_F(StoreTest, InterruptedTextFilesStayAsTheyWere) {
  fs::create_directories(folder_);
  const fs::path path = folder_ / "run.json";
  write_text_atomically(path, "old");
  {
    const FileSizeLimit limit(10);
    EXPECT_THROW(write_text_atomically(path, std::string(1000, 'x')), DeviceError);
  }
  EXPECT_EQ(read_file(path), "old");
  EXPECT_EQ(entries(folder_).size(), 1u);
}

/// Starts this program as `--write-cells FOLDER`.
pid_t start_writer(const fs::path& folder) {
  std::string self = fs::read_symlink("/proc/self/exe").string();
  std::string verb = "--write-cells";
  std::string argument = folder.string();
  char* arguments[] = {self.data(), verb.data(), argument.data(), nullptr};
  pid_t process = 0;
  EXPECT_EQ(posix_spawn(&process, self.c_str(), nullptr, nullptr, arguments, environ), 0);
  return process;
}

TEST_F(StoreTest, AKilledWriterLeavesNoHalfCell) {
  std::size_t left_overs = 0;
  int intact = 0;
  for (int round = 0; round < 12; ++round) {
    const pid_t process = start_writer(folder_);
    // Long enough that every round adds cells, at a different phase of a write each time.
    while (!fs::exists(folder_ / "cells") || entries(folder_ / "cells").size() < 3) {
      ASSERT_EQ(waitpid(process, nullptr, WNOHANG), 0) << "the writer ended by itself";
      std::this_thread::sleep_for(1ms);
    }
    std::this_thread::sleep_for(round * 1700us);
    ASSERT_EQ(kill(process, SIGKILL), 0);
    ASSERT_EQ(waitpid(process, nullptr, 0), process);

    for (const std::string& name : entries(folder_ / "cells")) left_overs += name.starts_with(".");
    CellStore young(folder_);  // left-overs of less than a minute may be somebody's
    CellStore store(folder_, 0s);
    for (const std::string& name : entries(folder_ / "cells")) {
      EXPECT_FALSE(name.starts_with(".")) << name;
    }
    intact = 0;
    for (int number = 0; number < child_cells && store.has(numbered_key(number)); ++number) {
      const ReadCell read = store.read(numbered_key(number));
      ASSERT_TRUE(read.cell) << read.warning;
      EXPECT_EQ(read.cell->layers.at("radiance"), numbered_layers(number, 128).at("radiance"));
      ++intact;
    }
    EXPECT_EQ(entries(folder_ / "cells").size(), std::size_t(intact));
    EXPECT_FALSE(fs::exists(folder_ / "damaged"));
    fs::remove_all(folder_);
  }
  EXPECT_GT(intact, 0);
  EXPECT_GT(left_overs, 0u) << "no round hit the middle of a write: the test shows nothing";
}

TEST_F(StoreTest, LeftOversOfLivingYoungOrForeignWritersStay) {
  CellStore store(folder_);
  const pid_t process = start_writer(folder_ / "elsewhere");
  char host[256] = {};
  gethostname(host, sizeof host - 1);
  const auto left_over = [&](const std::string& machine, pid_t writer) {
    const fs::path path = folder_ / "cells" / fmt::format(".tmp-{}-{}-0", machine, writer);
    fs::create_directories(path);
    std::ofstream(path / "layers.exr") << "half";
    return path;
  };
  const auto open_again = [&](std::chrono::seconds age) { const CellStore again(folder_, age); };
  const fs::path living = left_over(host, process);
  const fs::path foreign = left_over(std::string(host) + "x", process);
  open_again(0s);
  EXPECT_TRUE(fs::exists(living));
  kill(process, SIGKILL);
  waitpid(process, nullptr, 0);
  open_again(60s);
  EXPECT_TRUE(fs::exists(living)) << "too young";
  open_again(0s);
  EXPECT_FALSE(fs::exists(living));
  EXPECT_TRUE(fs::exists(foreign));
}

TEST_F(StoreTest, WritersOfOneCellAgree) {
  CellStore store(folder_);
  std::vector<std::jthread> writers;
  for (int i = 0; i < 8; ++i) writers.emplace_back([&] { write(store, 1); });
  writers.clear();
  EXPECT_EQ(entries(folder_ / "cells").size(), 1u);
  EXPECT_TRUE(store.read(numbered_key(1)).cell);
  EXPECT_FALSE(fs::exists(folder_ / "damaged"));
}

}  // namespace

int write_cells(const char* folder) {
  CellStore store(folder);
  for (int number = 0; number < child_cells; ++number) {
    store.write(numbered_key(number), numbered_layers(number, 128), {});
  }
  return 0;
}

}  // namespace occlab

int main(int argc, char** argv) {
  if (argc == 3 && std::string(argv[1]) == "--write-cells") return occlab::write_cells(argv[2]);
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
