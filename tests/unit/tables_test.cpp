#include "harness/tables.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "harness/csv.h"
#include "harness/table_formats.h"
#include "harness/timing_tables.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

namespace fs = std::filesystem;

Measurement make(const std::string& method, long samples, const std::string& metric, double value,
                 std::optional<double> half_width = {}) {
  Measurement m;
  m.experiment = "s3ho";
  m.scene = "gallery";
  m.resolution = "1280x720";
  m.probe = "cathedral";
  m.method = method;
  m.parameters = {{"samples", fmt::format("{}", samples)}, {"steps", "2"}};
  m.seed = "all";
  m.stage = metric.starts_with("time") ? "" : "filtered";
  m.metric = metric;
  m.unit = metric.starts_with("time_ms") ? "ms" : "";
  m.value = value;
  if (half_width) {
    m.lower = value - *half_width;
    m.upper = value + *half_width;
  }
  m.n = 8;
  m.device = "llvmpipe (software)";
  m.clock = metric.starts_with("time") ? "wall" : "";
  return m;
}

std::vector<std::string> names(const Table& table) {
  std::vector<std::string> result;
  for (const TableColumn& column : table.columns) result.push_back(column.name);
  return result;
}

const TableCell& cell(const Table& table, std::size_t row, const std::string& column) {
  const auto all = names(table);
  return table.rows.at(row).at(std::size_t(std::ranges::find(all, column) - all.begin()));
}
std::string text(const Table& table, std::size_t row, const std::string& column) {
  return std::get<std::string>(cell(table, row, column));
}
TableNumber number(const Table& table, std::size_t row, const std::string& column) {
  return std::get<TableNumber>(cell(table, row, column));
}

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

bool has_note(const Table& table, const std::string& part) {
  return std::ranges::any_of(
      table.notes, [&](const std::string& note) { return note.find(part) != std::string::npos; });
}

TEST(AccuracyTable, OneRowForEachVariantOneColumnForEachMetric) {
  std::vector<Measurement> rows = {make("ssao", 32, "rmse", 0.2, 0.01),
                                   make("ssao", 32, "psnr", 20),
                                   make("ssao", 8, "rmse", 0.3, 0.01),
                                   make("ssbn", 32, "rmse", 0.1, 0.01),
                                   make("ssbn", 32, "noise", 0.01),
                                   make("ssbn", 32, "time_ms.frame", 3),
                                   make("ssbn", 32, "noise_ratio.ssdo/s3ho", 2)};
  rows[3].parameters.emplace_back("cone_angle", "linear");
  rows[4].parameters.emplace_back("cone_angle", "linear");
  rows.push_back(make("ssao", 32, "rmse", 9));
  rows.back().seed = "0";
  rows.push_back(make("ssao", 32, "rmse", 9));
  rows.back().stage = "unfiltered";
  rows.push_back(make("ssdo", 32, "rmse", 0));
  rows.back().value.reset();
  rows.back().reason = "NaN pixels";

  const Table table = accuracy_table(rows, "filtered");
  EXPECT_EQ(names(table), (std::vector<std::string>{"method", "samples", "rmse", "psnr"}));
  ASSERT_EQ(table.rows.size(), 4u);
  EXPECT_EQ(text(table, 0, "method"), "ssao");
  EXPECT_EQ(text(table, 1, "samples"), "8");
  EXPECT_DOUBLE_EQ(number(table, 0, "rmse").value, 0.2);
  EXPECT_DOUBLE_EQ(*number(table, 0, "rmse").upper, 0.21);
  EXPECT_DOUBLE_EQ(number(table, 0, "psnr").value, 20);
  EXPECT_FALSE(number(table, 0, "psnr").lower);
  EXPECT_EQ(std::get<TableMissing>(cell(table, 1, "psnr")).reason, "not measured");
  EXPECT_EQ(std::get<TableMissing>(cell(table, 3, "rmse")).reason, "NaN pixels");
  EXPECT_TRUE(has_note(table, "scene = gallery, resolution = 1280x720, probe = cathedral"));
  EXPECT_TRUE(has_note(table, "steps = 2, cone_angle = linear"));
  EXPECT_TRUE(has_note(table, "n = 8"));

  const Table unfiltered = accuracy_table(rows, "unfiltered");
  ASSERT_EQ(unfiltered.rows.size(), 1u);
  EXPECT_DOUBLE_EQ(number(unfiltered, 0, "rmse").value, 9);
  EXPECT_TRUE(accuracy_table({}, "filtered").rows.empty());
}

TEST(AccuracyTable, AmbiguousMeasurementsAreErrors) {
  const Measurement m = make("ssao", 32, "rmse", 0.2);
  EXPECT_NE(error_of([&] {
              accuracy_table({m, m}, "filtered");
            }).find("'rmse' is there twice"),
            std::string::npos);
  Measurement other = make("ssbn", 32, "rmse", 0.2);
  other.unit = "W";
  EXPECT_NE(error_of([&] {
              accuracy_table({m, other}, "filtered");
            }).find("the units '' and 'W'"),
            std::string::npos);
}

TEST(AccuracyTable, WhatDiffersBecomesAColumn) {
  std::vector<Measurement> rows = {make("ssao", 32, "rmse", 0.2), make("ssao", 32, "rmse", 0.3)};
  rows[1].probe = "sky_sun";
  const Table table = accuracy_table(rows, "filtered");
  EXPECT_EQ(names(table), (std::vector<std::string>{"probe", "method", "rmse"}));
  EXPECT_EQ(text(table, 1, "probe"), "sky_sun");
  EXPECT_TRUE(has_note(table, "samples = 32"));
}

TEST(NoiseTable, NoiseAndBiasOnly) {
  const Table table =
      noise_table({make("ssao", 32, "rmse", 0.2), make("ssao", 32, "noise", 0.1, 0.01),
                   make("ssao", 32, "bias", 0.05, 0.02)},
                  "filtered");
  EXPECT_EQ(names(table), (std::vector<std::string>{"method", "noise", "bias"}));
  EXPECT_DOUBLE_EQ(*number(table, 0, "bias").lower, 0.03);
}

PublishedTimes s3ho_table() {
  return read_published_times(fs::path(OCCLAB_SOURCE_DIR) / "results/published/s3ho_table1.csv");
}

TEST(TimingTable, BesideThePublishedTimes) {
  std::vector<Measurement> rows;
  for (const long samples : {16L, 4L}) {
    for (const char* method : {"ssao", "s3ho"}) {
      const double time = method == std::string("ssao") ? 100 : 110;
      rows.push_back(make(method, samples, "time_ms.occlusion", time, 2));
      rows.push_back(make(method, samples, "time_ratio.occlusion", time / 100, 0.01));
      rows.push_back(make(method, samples, "time_ms.filter", 20, 1));
    }
  }
  const Table table = timing_table(rows, {"ssao", ""}, s3ho_table());
  EXPECT_EQ(names(table),
            (std::vector<std::string>{"method", "samples", "occlusion", "occlusion / ssao",
                                      "filter", "published", "published / ssao"}));
  EXPECT_EQ(table.title, "Times on llvmpipe (software), by wall");
  EXPECT_DOUBLE_EQ(number(table, 1, "occlusion").value, 110);
  EXPECT_DOUBLE_EQ(*number(table, 1, "occlusion / ssao").lower, 1.09);
  EXPECT_DOUBLE_EQ(number(table, 1, "published").value, 14.1) << "Table 1, not the text's 16.5";
  EXPECT_NEAR(number(table, 1, "published / ssao").value, 1.060, 5e-4);
  EXPECT_EQ(std::get<TableMissing>(cell(table, 3, "published")).reason, "not published");
  EXPECT_TRUE(has_note(table, "Nvidia GTX 470, 1280x720"));
  EXPECT_TRUE(has_note(table, "s3ho 16.5 ms for 16 samples and 2 steps, 1.107 times ssao"));
  EXPECT_TRUE(has_note(table, "ssao 14.9 ms"));
  EXPECT_TRUE(has_note(table, "bilateral filter is not stated"));
  EXPECT_TRUE(has_note(table, "'Table 4'"));

  const Table alone = timing_table(rows, {"ssao", ""}, std::nullopt);
  EXPECT_EQ(names(alone).back(), "filter");
  rows.back().device = "a GPU";
  EXPECT_NE(error_of([&] {
              timing_table(rows, {"ssao", ""}, {});
            }).find("devices"),
            std::string::npos);
  rows.back().device = rows.front().device;
  rows.back().clock = "query";
  EXPECT_NE(error_of([&] {
              timing_table(rows, {"ssao", ""}, {});
            }).find("clocks"),
            std::string::npos);
  EXPECT_TRUE(timing_table({}, {"ssao", ""}, s3ho_table()).rows.empty());
}

TEST(Published, TableOfThePaper) {
  const PublishedTimes table = s3ho_table();
  const auto time = [&](const char* method, long samples) {
    for (const PublishedTime& t : table.times) {
      if (t.method == method && t.samples == samples && t.origin == "Table 1") return t.time_ms;
    }
    return 0.0;
  };
  // The sums of the columns of Table 1, computed by hand.
  EXPECT_NEAR(time("ssao", 32) + time("ssao", 16) + time("ssao", 8), 46.5, 1e-9);
  EXPECT_NEAR(time("s3ho", 32) + time("s3ho", 16) + time("s3ho", 8), 49.3, 1e-9);
  EXPECT_NEAR(time("ssdo", 32) + time("ssdo", 16) + time("ssdo", 8), 71.1, 1e-9);
  EXPECT_NEAR(time("ssbn", 32) + time("ssbn", 16) + time("ssbn", 8), 47.5, 1e-9);
  EXPECT_EQ(table.times.size(), 14u);
}

TEST(Published, BadFilesNameTheirLine) {
  const fs::path path =
      fs::temp_directory_path() / fmt::format("occlab_published_{}.csv", getpid());
  const std::string header =
      "source,method,width,height,device,samples,steps,time_ms,origin,remark\n";
  const std::string row = "P,ssao,1280,720,GPU,32,2,26.3,Table 1,\n";
  const auto read = [&](const std::string& content) {
    std::ofstream(path) << content;
    std::string message = error_of([&] { read_published_times(path); });
    const std::size_t at = message.find(path.string());
    return at == 0 ? message.substr(path.string().size()) : message;
  };
  EXPECT_EQ(read(header + row), "no error");
  EXPECT_EQ(read(header), ": no rows");
  EXPECT_EQ(read("").substr(0, 4), ":1: ");
  EXPECT_EQ(read("a,b\n").substr(0, 28), ":1: the columns must be sour");
  EXPECT_EQ(read(header + row + row).substr(0, 28), ":3: the time of 'ssao' for 3");
  EXPECT_EQ(read(header + "P,ssao,1280,720,GPU,32,2,-1,Table 1,\n").substr(0, 20),
            ":2: time_ms: found -");
  EXPECT_EQ(read(header + "P,ssao,1280,720,GPU,3.5,2,1,Table 1,\n").substr(0, 16),
            ":2: samples: fou");
  EXPECT_EQ(read(header + "P,,1280,720,GPU,3,2,1,Table 1,\n").substr(0, 16), ":2: method: empt");
  EXPECT_EQ(read(header + row + "Q,ssao,1280,720,GPU,16,2,1,Table 1,\n").substr(0, 12),
            ":3: source: ");
  fs::remove(path);
  EXPECT_NE(error_of([&] { read_published_times(path); }), "no error");
}

TEST(OrderingsTable, HoldsDoesNotHoldUnresolved) {
  std::vector<Measurement> rows = {make("ssdo", 32, "noise_ratio.ssdo/s3ho", 1.8, 0.1),
                                   make("s3ho", 32, "noise_ratio.s3ho/ssbn", 1.0, 0.1),
                                   make("ssbn", 32, "rgb_angle_ratio.ssbn/s3ho", 0.8, 0.1),
                                   make("ssdo", 8, "noise_ratio.ssdo/s3ho", 1.8),
                                   make("ssdo", 16, "noise_ratio.ssdo/s3ho", 1.8)};
  rows[4].value.reset();
  rows[4].reason = "no noise";
  const Table table = orderings_table(rows);
  EXPECT_EQ(names(table), (std::vector<std::string>{"statement", "samples", "ratio", "verdict"}));
  EXPECT_EQ(text(table, 0, "statement"), "noise ssdo > noise s3ho");
  EXPECT_EQ(text(table, 0, "verdict"), "holds");
  EXPECT_EQ(text(table, 1, "verdict"), "unresolved");
  EXPECT_EQ(text(table, 2, "statement"), "rgb_angle ssbn > rgb_angle s3ho");
  EXPECT_EQ(text(table, 2, "verdict"), "does not hold");
  EXPECT_EQ(text(table, 3, "verdict"), "unresolved") << "no interval";
  EXPECT_EQ(text(table, 4, "verdict"), "unresolved");
  EXPECT_EQ(std::get<TableMissing>(cell(table, 4, "ratio")).reason, "no noise");
  EXPECT_TRUE(has_note(table, "stage = filtered"));
}

Table awkward_table() {
  const double infinity = std::numeric_limits<double>::infinity();
  return {"awkward",
          "50% of A_B & C",
          {{"name", "", Alignment::left}, {"x|y", "ms", Alignment::right}},
          {{std::string("[a_b] \"q\" | 1"), TableNumber{1.05678, 1.0512, 1.0634}},
           {std::string("{\\}~^#$<>"), TableNumber{infinity, {}, {}}},
           {std::string("m"), TableMissing{"because, 5%"}}},
          {"note_1"}};
}

TEST(TableFormats, Markdown) {
  EXPECT_EQ(format_table(awkward_table(), "md"),
            R"(## 50% of A_B \& C

| name             |               x\|y (ms) |
| ---------------- | ----------------------: |
| \[a_b\] "q" \| 1 | 1.0568 [1.0512, 1.0634] |
| {\\}\~^#$\<>     |                     inf |
| m                |                   – (1) |

- (1) because, 5%
- note_1
)");
}

TEST(TableFormats, Csv) {
  const std::string csv = format_table(awkward_table(), "csv");
  const auto records = parse_csv(csv, "t.csv");
  ASSERT_EQ(records.size(), 4u);
  EXPECT_EQ(records[0].fields, (std::vector<std::string>{"name", "x|y (ms)", "x|y (ms) lower",
                                                         "x|y (ms) upper", "x|y (ms) missing"}));
  EXPECT_EQ(records[1].fields,
            (std::vector<std::string>{"[a_b] \"q\" | 1", "1.05678", "1.0512", "1.0634", ""}));
  EXPECT_EQ(records[2].fields[1], "inf");
  EXPECT_EQ(records[3].fields, (std::vector<std::string>{"m", "", "", "", "because, 5%"}));
}

TEST(TableFormats, Json) {
  const auto json = nlohmann::json::parse(format_table(awkward_table(), "json"));
  EXPECT_EQ(json["title"], "50% of A_B & C");
  EXPECT_EQ(json["columns"][1]["unit"], "ms");
  EXPECT_EQ(json["rows"][0][1]["lower"], 1.0512);
  EXPECT_EQ(json["rows"][1][1]["value"], "inf");
  EXPECT_FALSE(json["rows"][1][1].contains("lower"));
  EXPECT_EQ(json["rows"][2][1]["missing"], "because, 5%");
  Table bad = awkward_table();
  bad.title = "\xff";
  EXPECT_THROW(format_table(bad, "json"), InputError);
}

TEST(TableFormats, Latex) {
  const std::string latex = format_table(awkward_table(), "latex");
  for (const char* part :
       {"\\caption{50\\% of A\\_B \\& C}", "\\label{tab:awkward}", "\\begin{tabular}{lr}",
        "\\toprule\nname & x\\textbar{}y (ms) \\\\\n\\midrule\n",
        "{[}a\\_b{]} \\textquotedbl{}q\\textquotedbl{} \\textbar{} 1 & "
        "$1.0568$ {\\footnotesize $[1.0512, 1.0634]$} \\\\\n",
        "\\{\\textbackslash{}\\}\\textasciitilde{}\\textasciicircum{}\\#\\$\\textless{}"
        "\\textgreater{} & $\\infty$ \\\\\n",
        "m & --\\textsuperscript{1} \\\\\n\\bottomrule\n", "because, 5\\%", "note\\_1"}) {
    EXPECT_NE(latex.find(part), std::string::npos) << part << "\n" << latex;
  }
  EXPECT_EQ(escape_latex("1–2 × ≥ é"), "1--2 $\\times$ $\\geq$ é");
}

TEST(TableFormats, RoundingFollowsTheInterval) {
  const auto rounded = [](const TableNumber& n) {
    const Table table{"t", "t", {{"x", "", Alignment::right}}, {{n}}, {}};
    const auto text = format_table(table, "md");
    const std::size_t row = text.find('|', text.rfind("|\n", text.size() - 3));
    const std::size_t begin = text.find_first_not_of("| \n", row);
    return text.substr(begin, text.find(" |", begin) - begin);
  };
  EXPECT_EQ(rounded({26.32, 25.1, 27.9}), "26.3 [25.1, 27.9]");
  EXPECT_EQ(rounded({1.0000001, 0.98, 1.02}), "1.000 [0.980, 1.020]");
  EXPECT_EQ(rounded({1234.5, 1034.5, 1434.5}), "1234 [1034, 1434]");
  EXPECT_EQ(rounded({2e-6, 1e-6, 3e-6}), "2.0e-06 [1.0e-06, 3.0e-06]");
  EXPECT_EQ(rounded({0.5, 0.5, 0.5}), "0.5 [0.5, 0.5]");
  EXPECT_EQ(rounded({-0.02, -0.03, -0.01}), "-0.020 [-0.030, -0.010]");
  EXPECT_EQ(rounded({1.23456, {}, {}}), "1.235");
}

TEST(TableFormats, Names) {
  EXPECT_EQ(table_formats(), (std::vector<std::string>{"md", "csv", "json", "latex"}));
  EXPECT_EQ(table_extension("latex"), ".tex");
  EXPECT_EQ(error_of([] { format_table({}, "jsn"); }),
            "unknown table format 'jsn'; did you mean 'json'? accepted: md, csv, json, latex");
}

}  // namespace
}  // namespace occlab
