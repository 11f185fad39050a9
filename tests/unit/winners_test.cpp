#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "harness/csv.h"
#include "harness/table_formats.h"
#include "harness/tables.h"
#include "tests/unit/planted_measurements.h"

namespace occlab {
namespace {

std::string winner_of(const std::vector<Measurement>& rows, const std::string& metric = "rmse") {
  const Table table = accuracy_table(rows, "filtered", compare_accuracy(rows, "filtered"));
  std::string winners;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    for (const auto& row : table.rows) {
      const auto* number = std::get_if<TableNumber>(&row[c]);
      if (number && number->winner) {
        EXPECT_EQ(table.columns[c].name, metric);
        winners += std::get<std::string>(row[0]);
      }
    }
  }
  return winners;
}

TEST(Winners, OnlyWhoBeatsAllOthers) {
  const Values best = around(0.1, 0.01);
  const Values second = around(0.2, 0.01, 1);
  const Values last = around(0.3, 0.01, 2);
  EXPECT_EQ(winner_of(measure({{"a", second}, {"b", best}, {"c", last}})), "b");
  EXPECT_EQ(winner_of(measure({{"a", second}, {"b", best}, {"c", last}}, "ssim"), "ssim"), "c");
  EXPECT_EQ(winner_of(measure({{"a", second}, {"b", best}, {"c", last}}, "unheard_of")), "");
  const double nan = std::nan("");
  for (const Values& rival : {best, around(0.102, 0.01, 3), Values{0.9}, Values{},
                              Values{0.9, 0.9, nan, 0.9, 0.9, 0.9, 0.9, 0.9}}) {
    std::vector<Measurement> rows = measure({{"b", best}, {"c", last}});
    EXPECT_EQ(winner_of(rows), "b");
    add(rows, base("rival", "rmse"), rival);
    EXPECT_EQ(winner_of(rows), "") << "equal, unresolved, one seed, not measured, NaN";
  }
  EXPECT_EQ(winner_of(measure({{"a", {0.1}}, {"b", {0.9}}})), "") << "one seed";
  EXPECT_EQ(winner_of(measure({{"a", best}})), "") << "nothing to beat";

  const auto rows = measure({{"a", second}, {"b", best}});
  for (const auto& row : accuracy_table(rows, "filtered").rows) {
    EXPECT_FALSE(std::get<TableNumber>(row.back()).winner) << "not compared";
  }
}

TEST(Winners, OneForEachParameterPoint) {
  std::vector<Measurement> rows;
  for (const char* samples : {"32", "8"}) {
    for (const char* method : {"a", "b"}) {
      Measurement m = base(method, "rmse");
      m.parameters = {{"samples", samples}};
      const bool better = (*method == 'a') == (*samples == '8');
      add(rows, m, around(better ? 0.1 : 0.3, 0.01, std::size_t(*method)));
    }
  }
  EXPECT_EQ(winner_of(rows), "ba");
}

Table small_table() {
  const auto rows = measure({{"a", around(0.1, 0.01)}, {"b", around(-0.3, 0.01, 1)}});
  return accuracy_table(rows, "filtered", compare_accuracy(rows, "filtered"));
}

TEST(Formats, EveryFormatMarksTheWinner) {
  Table table = small_table();
  std::get<TableNumber>(table.rows[1][1]) = {-0.3, -0.31, -0.29, true};
  EXPECT_NE(format_table(table, "md").find("| **-0.300** [-0.310, -0.290] |"), std::string::npos)
      << format_table(table, "md");
  EXPECT_NE(format_table(table, "latex")
                .find("\\textbf{\\boldmath$-0.300$} {\\footnotesize $[-0.310, -0.290]$}"),
            std::string::npos)
      << format_table(table, "latex");
  const auto records = parse_csv(format_table(table, "csv"), "t.csv");
  EXPECT_EQ(records[0].fields, (std::vector<std::string>{"method", "rmse", "rmse lower",
                                                         "rmse upper", "rmse winner"}));
  EXPECT_EQ(records[1].fields.back(), "");
  EXPECT_EQ(records[2].fields[1], "-0.3") << "the number stays a number";
  EXPECT_EQ(records[2].fields.back(), "yes");
  const auto json = nlohmann::json::parse(format_table(table, "json"));
  EXPECT_EQ(json["rows"][1][1]["winner"], true);
  EXPECT_FALSE(json["rows"][0][1].contains("winner"));
}

TEST(Formats, NothingIsMarkedWithoutAWinner) {
  const auto rows = measure({{"a", around(0.1, 0.01)}, {"b", around(0.1, 0.01)}});
  const Table table = accuracy_table(rows, "filtered", compare_accuracy(rows, "filtered"));
  for (const std::string& format : table_formats()) {
    std::string text = format_table(table, format);
    text.resize(std::min(text.size(), text.find("Bold (in CSV")));  // the note explains the mark
    for (const char* mark : {"**", "textbf", "winner"}) {
      EXPECT_EQ(text.find(mark), std::string::npos) << format;
    }
  }
}

TEST(Winners, TooFewSeedsAreSaid) {
  const auto rows = measure({{"a", {0.1, 0.11, 0.1}}, {"b", {0.3, 0.31, 0.32}}});
  const Comparisons comparisons = compare_accuracy(rows, "filtered");
  EXPECT_NE(comparisons_table(comparisons, "c", "c").notes.back().find("no p-value below 0.11"),
            std::string::npos);
  const Table table = accuracy_table(rows, "filtered", comparisons);
  EXPECT_NE(table.notes.back().find("No winner is marked: these seeds give no p-value below 0.11"),
            std::string::npos);
}

}  // namespace
}  // namespace occlab
