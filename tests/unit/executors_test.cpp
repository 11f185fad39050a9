#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "harness/executors/child_process.h"
#include "harness/executors/slurm.h"
#include "harness/executors/slurm_queue.h"
#include "harness/files.h"
#include "harness/work_locks.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class FolderTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("occlab_executors_test_" + std::to_string(::getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

class ClaimsTest : public FolderTest {};
class SlurmSettingsTest : public FolderTest {};

TEST_F(ClaimsTest, OneHolderAtATime) {
  const WorkLocks mine(folder_);
  const WorkLocks theirs(folder_);
  const std::string hash = sha256_text("a cell");
  {
    const auto lock = mine.take(hash);
    ASSERT_TRUE(lock);
    EXPECT_FALSE(theirs.take(hash));
    EXPECT_TRUE(theirs.take(sha256_text("another cell")));
    EXPECT_EQ(WorkLocks::taken(folder_, hash), true);
    EXPECT_FALSE(theirs.wait(hash, 0s));
  }
  EXPECT_EQ(WorkLocks::taken(folder_, hash), false);
  EXPECT_TRUE(theirs.take(hash));
}

TEST_F(ClaimsTest, AFolderWithoutClaimsIsNotKnown) {
  EXPECT_EQ(WorkLocks::taken(folder_ / "none", sha256_text("x")), std::nullopt);
  EXPECT_THROW(WorkLocks(folder_ / "none"), DeviceError);
}

TEST(ChildProcess, PassesArgumentsAsTheyAre) {
  const ChildResult result =
      run_child({"printf", "%s|", "a b", "$(exit 7)", "`x`", "\"'", "a\nb", "*"});
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(result.out, "a b|$(exit 7)|`x`|\"'|a\nb|*|");
  EXPECT_EQ(run_child({"sh", "-c", "echo out; echo err >&2; exit 7"}).code, 7);
  EXPECT_EQ(run_child({"sh", "-c", "echo out; echo err >&2; exit 7"}).err, "err\n");
  EXPECT_EQ(run_child({"sh", "-c", "kill -9 $$"}).code, 137);
  EXPECT_THROW(run_child({"/nonexistent/program"}), DeviceError);
  // More than a pipe holds, on both.
  EXPECT_EQ(
      run_child({"sh", "-c", "head -c 300000 /dev/zero >&2; head -c 300000 /dev/zero"}).out.size(),
      300000u);
}

/// Whatever is in a word, a shell hands it on unchanged.
TEST(ShellWord, SurvivesAShell) {
  std::mt19937 random(3);
  std::string words = "printf '%s' ";
  std::string expected;
  for (int i = 0; i < 300; ++i) {
    std::string text;
    for (int n = 0; n < 12; ++n) {
      const char letters[] = "'\"\\$`;&|<>(){}[]*?!#~% \t\nab-";
      text += random() % 3 ? letters[random() % (sizeof letters - 1)] : char(1 + random() % 255);
    }
    words += shell_word(text) + " ";
    expected += text;
  }
  EXPECT_EQ(run_child({"sh", "-c", words}).out, expected);
  EXPECT_EQ(shell_word(""), "''");
}

TEST(Slurm, IndicesAreRuns) {
  EXPECT_EQ(array_indices({1, 2, 3, 7, 9, 10}), "1-3,7,9-10");
  EXPECT_EQ(array_indices({5}), "5");
  EXPECT_EQ(array_indices({}), "");
}

TEST(Slurm, TheScriptQuotesAll) {
  const SlurmRun run{.results = "/r/it's",
                     .folder = "/f $(x)",
                     .command = {"/bin/occlab", "run", "a 'b'.toml", "--set", "x=\n#SBATCH -p y"},
                     .name = "n",
                     .key = "k"};
  const std::string script = slurm_script(run, 4);
  EXPECT_TRUE(
      script.ends_with("cd '/f $(x)' || exit 3\nexec '/bin/occlab' 'run' --shard "
                       "\"$SLURM_ARRAY_TASK_ID/4\" 'a '\\''b'\\''.toml' '--set' "
                       "'x=\n#SBATCH -p y'\n"))
      << script;
  EXPECT_LT(script.find("cd "), script.find("#SBATCH"))
      << "sbatch reads directives above the first command only";
  EXPECT_NE(slurm_script(run, 0).find("status '/r/it'\\''s' --rendered || exit 3\nexec"),
            std::string::npos);
  EXPECT_EQ(slurm_script(run, 0).find("--shard"), std::string::npos);
}

TEST(Slurm, TheQueueIsRead) {
  const auto queue =
      parse_queue("12_1|RUNNING|None\n12_2|PENDING|Resources\n13|PENDING|(x|y)\nz\n");
  ASSERT_EQ(queue.size(), 3u);
  EXPECT_EQ(queue.at("12_1").state, "RUNNING");
  EXPECT_EQ(queue.at("12_2").reason, "Resources");
  EXPECT_EQ(queue.at("13").reason, "(x|y)");
}

TEST(Slurm, MessagesAreOneLine) {
  EXPECT_EQ(one_line("sbatch: error: invalid partition specified: x\nsbatch: error: Batch job "
                     "submission failed: Invalid partition name specified\n"),
            "invalid partition specified: x; Batch job submission failed: Invalid partition name "
            "specified");
  EXPECT_EQ(one_line("\n \n"), "it said nothing");
}

TEST_F(SlurmSettingsTest, AreReadStrictly) {
  const fs::path path = folder_ / "cluster.toml";
  const auto read = [&](const std::string& text) {
    std::ofstream(path) << text;
    return read_slurm_settings(path);
  };
  const SlurmSettings settings = read(
      "[slurm]\npartition = \"gpu\"\ntime = \"1:00:00\"\ngpus = \"a100:1\"\nshards = 40\n"
      "at_once = 8\noptions = [\"--account=light\"]\n");
  EXPECT_EQ(settings.partition, "gpu");
  EXPECT_EQ(settings.time, "1:00:00");
  EXPECT_EQ(settings.gpus, "a100:1");
  EXPECT_EQ(settings.shards, 40u);
  EXPECT_EQ(settings.at_once, 8u);
  EXPECT_EQ(settings.options, std::vector<std::string>{"--account=light"});
  EXPECT_EQ(read("[slurm]\n").shards, 16u);
  for (const char* text : {"", "[slrum]\n", "[slurm]\npartitoin = \"gpu\"\n",
                           "[slurm]\nshards = 0\n", "[slurm]\n[other]\n"}) {
    EXPECT_THROW(read(text), InputError) << text;
  }
}

}  // namespace
}  // namespace occlab
