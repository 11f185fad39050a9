#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <regex>
#include <sstream>

#include "renderers/gl/embedded_shaders.h"
#include "renderers/gl/program.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

/// The quoted path of an `#include "path"` line, or "".
std::string included_path(const std::string& line) {
  static const std::regex include(R"(^\s*#\s*include\s*\"([^\"]+)\")");
  std::smatch match;
  return std::regex_search(line, match, include) ? match[1].str() : std::string();
}

void expand(std::string_view path, ShaderSource& source) {
  source.files.emplace_back(path);
  const std::size_t file = source.files.size() - 1;
  source.text += fmt::format("#line 1 {}\n", file);
  std::istringstream lines{std::string(shader_file(path))};
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.starts_with("#pragma once")) line.clear();
    const std::string include = included_path(line);
    if (include.empty()) {
      source.text += line + "\n";
    } else if (std::ranges::find(source.files, include) == source.files.end()) {
      try {
        expand(include, source);
      } catch (const InputError& error) {
        throw InputError(fmt::format("{}:{}: {}", path, number, error.what()));
      }
      source.text += fmt::format("#line {} {}\n", number + 1, file);
    } else {
      source.text += "\n";
    }
  }
}

}  // namespace

std::string_view shader_file(std::string_view path) {
  const auto file = std::ranges::find(embedded_shaders(), path, &EmbeddedShader::path);
  if (file == embedded_shaders().end()) {
    throw InputError(fmt::format("shader file '{}' is not among the embedded sources", path));
  }
  return file->text;
}

ShaderSource expand_shader(std::string_view path, std::string_view preamble) {
  ShaderSource source;
  source.text = fmt::format("#version 450 core\n{}", preamble);
  expand(path, source);
  return source;
}

std::string locate_messages(const std::string& log, const std::vector<std::string>& files) {
  // Mesa: "2:14(5): error"; NVIDIA: "2(14) : error"; AMD: "ERROR: 2:14: ".
  static const std::regex position(R"((\b\d+)(?::(\d+)\(\d+\)|\((\d+)\)|:(\d+)(?=:)))");
  std::string located;
  auto rest = log.cbegin();
  std::smatch match;
  while (std::regex_search(rest, log.cend(), match, position)) {
    located.append(rest, match[0].first);
    const std::size_t file = std::stoul(match[1].str());
    const std::string line = match[2].str() + match[3].str() + match[4].str();
    located += file < files.size() ? files[file] + ":" + line : match[0].str();
    rest = match[0].second;
  }
  return located.append(rest, log.cend());
}

}  // namespace occlab
