#include "harness/measurements.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <utility>

#include "harness/csv.h"
#include "harness/files.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr std::string_view parameter_prefix = "parameter.";

/// The columns before and after the parameters'.
const std::vector<std::string> head = {"experiment", "scene", "view",
                                       "resolution", "probe", "method"};
const std::vector<std::string> tail = {"seed",  "stage",          "metric", "unit",   "value",
                                       "lower", "upper",          "n",      "device", "clock",
                                       "cells", "reference_cell", "reason"};

bool is_number(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

/// What is wrong with a measurement, "" if nothing.
std::string defect(const Measurement& m) {
  if (m.experiment.empty()) return "experiment is empty";
  if (m.metric.empty()) return "metric is empty";
  if (m.seed != "all" && !is_number(m.seed)) {
    return fmt::format("seed is '{}'; accepted is a number or all", m.seed);
  }
  constexpr std::array<std::string_view, 3> stages = {"", "filtered", "unfiltered"};
  if (std::ranges::find(stages, m.stage) == stages.end()) {
    return fmt::format("stage is '{}'; accepted is filtered, unfiltered or nothing", m.stage);
  }
  for (const auto& number : {m.value, m.lower, m.upper}) {
    if (number && std::isnan(*number)) return "a number is NaN";
  }
  if (m.lower.has_value() != m.upper.has_value()) return "lower and upper come together";
  if (m.lower && !m.value) return "there is an interval but no value";
  if (m.lower && *m.lower > *m.upper) return "lower is above upper";
  if (!m.value && m.reason.empty()) return "there is neither a value nor a reason for its absence";
  if (m.value && !m.reason.empty()) return "there are both a value and a reason for its absence";
  if (m.n < 0) return "n is negative";
  for (const std::string& cell : m.cells) {
    if (cell.empty() || cell.find(';') != std::string::npos) return "a cell's id is empty or has ;";
  }
  for (std::size_t i = 0; i < m.parameters.size(); ++i) {
    const auto& [name, value] = m.parameters[i];
    if (name.empty() || value.empty()) return "a parameter's name or value is empty";
    if (name == "seed") return "seed is a column of its own, not a parameter";
    if (find_parameter(m, name) != &value) return fmt::format("{} is given twice", name);
  }
  return "";
}

std::string optional_text(const std::optional<double>& number) {
  return number ? number_text(*number) : "";
}

std::vector<std::string> split_cells(const std::string& text) {
  std::vector<std::string> cells;
  if (text.empty()) return cells;
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find(';', begin);
    cells.push_back(text.substr(begin, end - begin));
    if (end == std::string::npos) return cells;
    begin = end + 1;
  }
}

/// The names of the parameters, after checking all columns.
std::vector<std::string> parse_header(const std::vector<std::string>& header,
                                      const std::string& name) {
  const auto fail = [&] {
    throw InputError(fmt::format("{}:1: the columns must be {},parameter.NAME...,{}", name,
                                 fmt::join(head, ","), fmt::join(tail, ",")));
  };
  if (header.size() < head.size() + tail.size() ||
      !std::equal(head.begin(), head.end(), header.begin()) ||
      !std::equal(tail.rbegin(), tail.rend(), header.rbegin())) {
    fail();
  }
  std::vector<std::string> parameters;
  for (std::size_t i = head.size(); i < header.size() - tail.size(); ++i) {
    if (!header[i].starts_with(parameter_prefix)) fail();
    parameters.push_back(header[i].substr(parameter_prefix.size()));
    if (std::ranges::count(parameters, parameters.back()) > 1) {
      throw InputError(fmt::format("{}:1: column {} is there twice", name, header[i]));
    }
  }
  return parameters;
}

Measurement parse_record(const CsvRecord& record, const std::vector<std::string>& parameters,
                         const std::string& place) {
  std::size_t next = 0;
  const auto text = [&] { return record.fields[next++]; };
  const auto number = [&](std::string_view column) -> std::optional<double> {
    const std::string& field = record.fields[next++];
    if (field.empty()) return std::nullopt;
    return parse_number(field, fmt::format("{}: {}", place, column));
  };
  Measurement m;
  for (std::string* field :
       {&m.experiment, &m.scene, &m.view, &m.resolution, &m.probe, &m.method}) {
    *field = text();
  }
  for (const std::string& parameter : parameters) {
    if (std::string value = text(); !value.empty()) {
      m.parameters.emplace_back(parameter, std::move(value));
    }
  }
  for (std::string* field : {&m.seed, &m.stage, &m.metric, &m.unit}) *field = text();
  m.value = number("value");
  m.lower = number("lower");
  m.upper = number("upper");
  const std::string n = text();
  const auto [rest, error] = std::from_chars(n.data(), n.data() + n.size(), m.n);
  if (error != std::errc() || rest != n.data() + n.size()) {
    throw InputError(fmt::format("{}: n: found '{}'; accepted is an integer", place, n));
  }
  m.device = text();
  m.clock = text();
  m.cells = split_cells(text());
  m.reference_cell = text();
  m.reason = text();
  return m;
}

std::string header_line(const std::vector<std::string>& parameters) {
  std::vector<std::string> header = head;
  for (const std::string& name : parameters) header.push_back(std::string(parameter_prefix) + name);
  header.insert(header.end(), tail.begin(), tail.end());
  return csv_line(header);
}

std::string row_line(const Measurement& m, const std::vector<std::string>& parameters) {
  if (const std::string what = defect(m); !what.empty()) {
    throw InputError(fmt::format("measurement '{}' of method '{}', seed {}: {}", m.metric, m.method,
                                 m.seed, what));
  }
  std::vector<std::string> fields = {m.experiment, m.scene, m.view,
                                     m.resolution, m.probe, m.method};
  for (const std::string& name : parameters) {
    const std::string* const value = find_parameter(m, name);
    fields.push_back(value ? *value : "");
  }
  for (const std::string& field :
       {m.seed, m.stage, m.metric, m.unit, optional_text(m.value), optional_text(m.lower),
        optional_text(m.upper), fmt::format("{}", m.n), m.device, m.clock,
        fmt::format("{}", fmt::join(m.cells, ";")), m.reference_cell, m.reason}) {
    fields.push_back(field);
  }
  return csv_line(fields);
}

}  // namespace

MeasurementsFile::MeasurementsFile(std::filesystem::path path, std::vector<std::string> parameters)
    : path_(std::move(path)), parameters_(std::move(parameters)) {
  temporary_ = path_.parent_path() / fmt::format(".{}.{}", path_.filename().string(), ::getpid());
  file_ = std::fopen(temporary_.c_str(), "wb");
  if (!file_) {
    throw DeviceError(
        fmt::format("{}: cannot be created: {}", temporary_.string(), std::strerror(errno)));
  }
  write(header_line(parameters_));
}

MeasurementsFile::~MeasurementsFile() {
  if (!file_) return;
  std::fclose(file_);
  ::unlink(temporary_.c_str());
}

void MeasurementsFile::write(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), file_) == text.size()) return;
  throw DeviceError(
      fmt::format("{}: writing failed: {}", temporary_.string(), std::strerror(errno)));
}

void MeasurementsFile::add(const std::vector<Measurement>& rows) {
  for (const Measurement& row : rows) {
    for (const auto& [name, value] : row.parameters) {
      if (std::ranges::find(parameters_, name) != parameters_.end()) continue;
      throw InputError(
          fmt::format("measurement '{}' of method '{}': there is no column for its "
                      "parameter '{}'",
                      row.metric, row.method, name));
    }
    write(row_line(row, parameters_));
  }
  rows_ += rows.size();
}

void MeasurementsFile::finish() {
  const bool flushed = std::fflush(file_) == 0;
  const int reason = errno;
  std::fclose(std::exchange(file_, nullptr));
  if (!flushed) {
    ::unlink(temporary_.c_str());
    throw DeviceError(
        fmt::format("{}: writing failed: {}", temporary_.string(), std::strerror(reason)));
  }
  sync_path(temporary_);
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) {
    throw DeviceError(
        fmt::format("{}: cannot be written: {}", path_.string(), std::strerror(errno)));
  }
  sync_path(path_.parent_path());
}

void merge_names(std::vector<std::string>& names,
                 const std::vector<std::pair<std::string, std::string>>& values) {
  std::ptrdiff_t after = 0;
  for (const auto& [name, value] : values) {
    std::ptrdiff_t place = std::ranges::find(names, name) - names.begin();
    if (place == std::ssize(names)) {
      place = after;
      names.insert(names.begin() + place, name);
    }
    after = std::max(after, place + 1);
  }
}

const std::string* find_parameter(const Measurement& measurement, std::string_view name) {
  for (const auto& [parameter, value] : measurement.parameters) {
    if (parameter == name) return &value;
  }
  return nullptr;
}

std::string measurements_to_csv(const std::vector<Measurement>& measurements) {
  std::vector<std::string> parameters;
  for (const Measurement& m : measurements) merge_names(parameters, m.parameters);
  std::string csv = header_line(parameters);
  for (const Measurement& m : measurements) csv += row_line(m, parameters);
  return csv;
}

std::vector<Measurement> measurements_from_csv(std::string_view text, const std::string& name) {
  const std::vector<CsvRecord> records = parse_csv(text, name);
  if (records.empty()) throw InputError(fmt::format("{}: empty; measurements are expected", name));
  const std::vector<std::string> parameters = parse_header(records.front().fields, name);
  std::vector<Measurement> measurements;
  for (std::size_t i = 1; i < records.size(); ++i) {
    const std::string place = fmt::format("{}:{}", name, records[i].line);
    measurements.push_back(parse_record(records[i], parameters, place));
    if (const std::string what = defect(measurements.back()); !what.empty()) {
      throw InputError(fmt::format("{}: {}", place, what));
    }
  }
  return measurements;
}

void write_measurements(const std::filesystem::path& path,
                        const std::vector<Measurement>& measurements) {
  write_text_atomically(path, measurements_to_csv(measurements));
}

std::vector<Measurement> read_measurements(const std::filesystem::path& path) {
  return measurements_from_csv(read_text(path), path.string());
}

}  // namespace occlab
