#pragma once

#include <spawn.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace occlab {

// What starting programs without a shell needs.

/// posix_spawn's file actions, destroyed with this object.
class SpawnActions {
 public:
  SpawnActions() { posix_spawn_file_actions_init(&actions_); }
  ~SpawnActions() { posix_spawn_file_actions_destroy(&actions_); }
  SpawnActions(const SpawnActions&) = delete;
  SpawnActions& operator=(const SpawnActions&) = delete;

  void open(int descriptor, const char* path, int flags) {
    posix_spawn_file_actions_addopen(&actions_, descriptor, path, flags, 0644);
  }
  void duplicate(int from, int to) { posix_spawn_file_actions_adddup2(&actions_, from, to); }
  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_;
};

/// As posix_spawn takes them; `texts` outlive the result.
std::vector<char*> spawn_words(std::vector<std::string>& texts);

/// The PATH, or what stands for it where there is none.
std::string search_path();

bool is_program(const std::filesystem::path& file);

/// The program that a shell would start for `name`, which has no '/'.
std::optional<std::filesystem::path> find_on_path(const std::string& name);

}  // namespace occlab
