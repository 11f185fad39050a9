#include "harness/history/measurement_index.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <map>
#include <unordered_map>

#include "harness/measurements.h"
#include "renderers/scene/error.h"

namespace occlab::history {
namespace fs = std::filesystem;
namespace {

constexpr int index_format = 1;
constexpr std::size_t block_bytes = std::size_t(8) << 20;

const std::vector<std::string> head = {"experiment", "scene", "view",
                                       "resolution", "probe", "method"};
const std::vector<std::string> tail = {"seed",  "stage", "metric",         "unit",  "device",
                                       "clock", "cells", "reference_cell", "reason"};
constexpr std::string_view parameter_prefix = "parameter.";

/// What the index was made of.
std::string stamp_of(const fs::path& csv) {
  struct stat status {};
  if (::stat(csv.c_str(), &status) != 0) {
    throw InputError(
        fmt::format("{}: no such file; 'occlab run' and 'occlab time' write one", csv.string()));
  }
  return fmt::format("{} {} {} {}.{:09} {}.{:09}", index_format, status.st_ino, status.st_size,
                     status.st_mtim.tv_sec, status.st_mtim.tv_nsec, status.st_ctim.tv_sec,
                     status.st_ctim.tv_nsec);
}

/// Calls `use` with measurements.csv in blocks of whole records, each with the header before it.
class CsvBlocks {
 public:
  explicit CsvBlocks(const fs::path& path) : path_(path), file_(path, std::ios::binary) {}

  template <typename Use>
  void for_each(const Use& use) {
    std::string rest;
    std::string header;
    long line = 1;
    while (file_ || !rest.empty()) {
      std::string block(block_bytes, '\0');
      file_.read(block.data(), std::streamsize(block.size()));
      block.resize(std::size_t(file_.gcount()));
      const bool last = block.empty();
      rest += block;
      if (header.empty()) {
        const std::size_t end = rest.find('\n');
        header = rest.substr(0, end == std::string::npos ? rest.size() : end + 1);
        rest.erase(0, header.size());
        if (rest.empty() && last) return use(header, place(line));
      }
      const std::size_t end = last ? rest.size() : end_of_records(rest);
      if (end > 0) use(header + rest.substr(0, end), place(line));
      line += std::count(rest.begin(), rest.begin() + std::ptrdiff_t(end), '\n');
      rest.erase(0, end);
      if (last) return;
    }
  }

 private:
  std::string place(long line) const {
    return line == 1 ? path_.string() : fmt::format("{}, from line {}", path_.string(), line);
  }

  /// After the last line end that is in no quotes.
  static std::size_t end_of_records(const std::string& text) {
    bool quoted = false;
    std::size_t end = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '"') quoted = !quoted;
      if (text[i] == '\n' && !quoted) end = i + 1;
    }
    return end;
  }

  const fs::path& path_;
  std::ifstream file_;
};

std::vector<std::string> names_in(const fs::path& csv) {
  std::ifstream file(csv);
  std::string header;
  std::getline(file, header);
  std::vector<std::string> names = head;
  std::size_t begin = 0;
  while (begin < header.size()) {
    const std::size_t end = std::min(header.find(',', begin), header.size());
    std::string name = header.substr(begin, end - begin);
    if (name.starts_with(parameter_prefix)) names.push_back(std::move(name));
    begin = end + 1;
  }
  names.insert(names.end(), tail.begin(), tail.end());
  for (std::string& name : names) std::erase_if(name, [](char c) { return c == '"' || c == '\r'; });
  return names;
}

/// A column and where its text is in a measurement.
struct Column {
  std::string name;
  std::function<std::string(const Measurement&)> text;
};

Column parameter_column(const std::string& name) {
  return {name, [parameter = name.substr(parameter_prefix.size())](const Measurement& row) {
            const std::string* const value = find_parameter(row, parameter);
            return value ? *value : std::string();
          }};
}

std::vector<Column> columns_of(const std::vector<std::string>& names) {
  const std::map<std::string, std::function<std::string(const Measurement&)>> texts = {
      {"experiment", &Measurement::experiment},
      {"scene", &Measurement::scene},
      {"view", &Measurement::view},
      {"resolution", &Measurement::resolution},
      {"probe", &Measurement::probe},
      {"method", &Measurement::method},
      {"seed", &Measurement::seed},
      {"stage", &Measurement::stage},
      {"metric", &Measurement::metric},
      {"unit", &Measurement::unit},
      {"device", &Measurement::device},
      {"clock", &Measurement::clock},
      {"reason", &Measurement::reason},
      {"reference_cell", &Measurement::reference_cell},
      {"cells",
       [](const Measurement& row) { return fmt::format("{}", fmt::join(row.cells, ";")); }}};
  std::vector<Column> columns;
  for (const std::string& name : names) {
    const auto text = texts.find(name);
    columns.push_back(text == texts.end() ? parameter_column(name) : Column{name, text->second});
  }
  return columns;
}

/// Texts by the number that stands for them; 1 is "".
class TextNumbers {
 public:
  explicit TextNumbers(const Sqlite& database)
      : insert_(database, "INSERT INTO texts(id, text) VALUES (?, ?)") {
    number("");
  }
  std::int64_t number(const std::string& text) {
    const auto [known, is_new] = numbers_.try_emplace(text, std::ssize(numbers_) + 1);
    if (is_new) insert_.bind(known->second).bind(std::string_view(text)).run();
    return known->second;
  }

 private:
  Statement insert_;
  std::unordered_map<std::string, std::int64_t> numbers_;
};

std::string quoted(const std::string& column) { return "\"" + column + "\""; }

void build(const Sqlite& database, const fs::path& csv) {
  const std::vector<Column> columns = columns_of(names_in(csv));
  Transaction transaction(database);
  database.execute(
      "DROP TABLE IF EXISTS rows; DROP TABLE IF EXISTS texts; DROP TABLE IF EXISTS source;"
      "CREATE TABLE source(stamp TEXT NOT NULL);"
      "CREATE TABLE texts(id INTEGER PRIMARY KEY, text TEXT NOT NULL);");
  std::string declared = "value REAL, lower REAL, upper REAL, n INTEGER NOT NULL";
  std::string places = "?, ?, ?, ?";
  for (const Column& column : columns) {
    declared += fmt::format(", {} INTEGER NOT NULL", quoted(column.name));
    places += ", ?";
  }
  database.execute(fmt::format("CREATE TABLE rows(id INTEGER PRIMARY KEY, {})", declared));
  Statement insert(database, fmt::format("INSERT INTO rows VALUES (NULL, {})", places));
  TextNumbers texts(database);
  CsvBlocks(csv).for_each([&](const std::string& block, const std::string& name) {
    for (const Measurement& row : measurements_from_csv(block, name)) {
      insert.bind(row.value).bind(row.lower).bind(row.upper).bind(std::int64_t(row.n));
      for (const Column& column : columns) insert.bind(texts.number(column.text(row)));
      insert.run();
    }
  });
  database.execute(
      "CREATE UNIQUE INDEX text_ids ON texts(text);"
      "CREATE INDEX metrics ON rows(metric, method);");
  Statement stamp(database, "INSERT INTO source VALUES (?)");
  stamp.bind(std::string_view(stamp_of(csv))).run();
  transaction.commit();
}

bool is_fresh(const Sqlite& database, const std::string& stamp) {
  if (database.integer("SELECT count(*) FROM sqlite_master WHERE name = 'source'") == 0) {
    return false;
  }
  Statement statement(database, "SELECT stamp FROM source");
  return statement.step() && statement.text(0) == stamp;
}

/// Opens the index; a file that is no index, or a damaged one, is made again.
Sqlite open_fresh(const fs::path& csv, bool rebuild) {
  const fs::path path = fs::path(csv).replace_extension(".sqlite");
  const std::string stamp = stamp_of(csv);
  std::string why = rebuild ? "as asked for" : "";
  try {
    Sqlite database(path, true);
    database.execute("PRAGMA synchronous = OFF");
    if (!rebuild && is_fresh(database, stamp)) return database;
  } catch (const InputError& error) {
    why = error.what();
  }
  fmt::print(stderr, "{}: made from {}{}{}\n", path.string(), csv.filename().string(),
             why.empty() ? "" : ": ", why);
  fs::remove(path);
  Sqlite database(path, true);
  // It can be made again: a crash in the middle costs nothing but that.
  database.execute("PRAGMA synchronous = OFF; PRAGMA journal_mode = MEMORY");
  build(database, csv);
  return database;
}

std::vector<std::string> stored_columns(const Sqlite& database) {
  std::vector<std::string> columns;
  Statement statement(database,
                      "SELECT name FROM pragma_table_info('rows') WHERE name NOT IN "
                      "('id', 'value', 'lower', 'upper', 'n') ORDER BY cid");
  while (statement.step()) columns.push_back(statement.text(0));
  return columns;
}

}  // namespace

MeasurementIndex::MeasurementIndex(const fs::path& results, bool rebuild)
    : csv_(results / "measurements.csv"),
      database_(open_fresh(csv_, rebuild)),
      columns_(stored_columns(database_)) {}

std::int64_t MeasurementIndex::rows() const {
  return database_.integer("SELECT count(*) FROM rows");
}

std::string MeasurementIndex::column_of(const std::string& name) const {
  for (const std::string& candidate : {name, std::string(parameter_prefix) + name}) {
    if (std::ranges::find(columns_, candidate) != columns_.end()) return candidate;
  }
  std::vector<std::string> accepted;
  for (const std::string& column : columns_) {
    const bool parameter = column.starts_with(parameter_prefix);
    accepted.push_back(parameter ? column.substr(parameter_prefix.size()) : column);
  }
  throw InputError(
      fmt::format("--where {}: there is no such column{}", name, accepted_words(name, accepted)));
}

std::int64_t MeasurementIndex::text_id(const Condition& condition,
                                       const std::string& column) const {
  Statement find(database_, fmt::format("SELECT t.id FROM texts t WHERE t.text = ? AND EXISTS "
                                        "(SELECT 1 FROM rows WHERE {} = t.id)",
                                        quoted(column)));
  find.bind(std::string_view(condition.second));
  if (find.step()) return find.integer(0);
  constexpr int most_named = 200;
  Statement list(database_, fmt::format("SELECT DISTINCT t.text FROM rows r JOIN texts t ON t.id = "
                                        "r.{} LIMIT {}",
                                        quoted(column), most_named));
  std::vector<std::string> values;
  while (list.step()) values.push_back(list.text(0));
  throw InputError(fmt::format("--where {}={}: no measurement has that{}", condition.first,
                               condition.second, accepted_words(condition.second, values)));
}

Table MeasurementIndex::query(const std::vector<Condition>& conditions, std::size_t limit) const {
  std::vector<std::string> wanted;
  std::vector<std::int64_t> ids;
  for (const Condition& condition : conditions) {
    const std::string column = column_of(condition.first);
    wanted.push_back(quoted(column) + " = ?");
    ids.push_back(text_id(condition, column));
  }
  std::string names;
  for (const std::string& column : columns_) names += ", " + quoted(column);
  Statement select(database_,
                   fmt::format("SELECT value, lower, upper, n{} FROM rows{}{} ORDER BY id LIMIT {}",
                               names, wanted.empty() ? "" : " WHERE ",
                               fmt::format("{}", fmt::join(wanted, " AND ")), limit));
  for (const std::int64_t id : ids) select.bind(id);

  Statement find_text(database_, "SELECT text FROM texts WHERE id = ?");
  std::unordered_map<std::int64_t, std::string> known;
  const auto text = [&](std::int64_t id) -> const std::string& {
    const auto [entry, is_new] = known.try_emplace(id);
    if (is_new) {
      find_text.reset();
      find_text.bind(id);
      if (find_text.step()) entry->second = find_text.text(0);
    }
    return entry->second;
  };

  struct Row {
    TableCell number;
    std::int64_t n;
    std::vector<std::int64_t> texts;
  };
  const auto place = [&](const char* name) {
    return std::size_t(std::ranges::find(columns_, name) - columns_.begin());
  };
  const std::size_t reason = place("reason");
  std::vector<Row> rows;
  std::vector<bool> differs(columns_.size(), false);
  while (select.step()) {
    Row row{{}, select.integer(3), {}};
    for (std::size_t i = 0; i < columns_.size(); ++i)
      row.texts.push_back(select.integer(4 + int(i)));
    if (const auto value = select.number(0)) {
      row.number = TableNumber{*value, select.number(1), select.number(2)};
    } else {
      row.number = TableMissing{text(row.texts[reason])};
    }
    if (!rows.empty()) {
      for (std::size_t i = 0; i < columns_.size(); ++i) {
        if (row.texts[i] != rows.front().texts[i]) differs[i] = true;
      }
    }
    rows.push_back(std::move(row));
  }
  differs[reason] = false;  // it is with the missing number

  Table table{
      .name = "measurements", .title = "Measurements", .columns = {}, .rows = {}, .notes = {}};
  const auto label = [](const std::string& column) {
    return column.starts_with(parameter_prefix) ? column.substr(parameter_prefix.size()) : column;
  };
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (differs[i]) {
      table.columns.push_back({.name = label(columns_[i]), .unit = ""});
    } else if (!rows.empty() && i != reason && !text(rows.front().texts[i]).empty()) {
      table.notes.push_back(fmt::format("{}: {}", label(columns_[i]), text(rows.front().texts[i])));
    }
  }
  table.columns.push_back({.name = "value", .unit = "", .alignment = Alignment::right});
  table.columns.push_back({.name = "n", .unit = "", .alignment = Alignment::right});
  for (const Row& row : rows) {
    std::vector<TableCell> cells;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (differs[i]) cells.emplace_back(text(row.texts[i]));
    }
    cells.push_back(row.number);
    cells.emplace_back(TableNumber{double(row.n), {}, {}});
    table.rows.push_back(std::move(cells));
  }
  table.notes.push_back(
      fmt::format("{} of {} measurements{}", table.rows.size(), this->rows(),
                  table.rows.size() == limit ? "; --limit may have left some out" : ""));
  return table;
}

}  // namespace occlab::history
