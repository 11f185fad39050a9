#pragma once

#include <optional>
#include <string>
#include <vector>

namespace occlab::history {

/// What `git ARGUMENTS` prints in the current folder, without the last line end; nothing where it
/// fails, there is no git or no repository. Never a shell.
std::optional<std::string> git(std::vector<std::string> arguments);

/// Hash, subject and time (UTC) of a commit of the current folder's repository.
struct Commit {
  std::string hash;
  std::string subject;
  std::string time;
};
std::optional<Commit> find_commit(const std::string& revision);

/// Who decides: git's user.name and user.email, else $USER, else "unknown".
std::string current_user();

}  // namespace occlab::history
