// Tables of a given width: what is broken where, and that nothing is lost.
#include "harness/table_layout.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

namespace occlab {
namespace {

Table two_metrics() {
  Table table{"t",
              "Accuracy of some methods, filtered",
              {{"method", ""}, {"samples", "", Alignment::right}},
              {},
              {}};
  for (const char* metric : {"rmse", "flip_hdr"}) {
    table.columns.push_back({metric, "mean luminance", Alignment::right});
  }
  table.rows.push_back(
      {"s3ho", "32", TableNumber{0.12345, 0.1232, 0.1237, true}, TableNumber{-0.5, -0.52, -0.48}});
  table.rows.push_back({"ssao", "8", TableMissing{"nothing was there to be measured"},
                        TableNumber{0.25, 0.2432, 0.2568}});
  table.notes = {"A note that is long enough to be broken: élégant, naïve, and so on and on"};
  return table;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::size_t longest(const std::string& text) {
  std::size_t width = 0;
  for (const std::string& line : lines_of(text)) width = std::max(width, text_width(line));
  return width;
}

TEST(TableLayout, WhatFitsStaysAsItIs) {
  const SpelledTable table = spell_markdown(two_metrics());
  EXPECT_EQ(table.keys, 2u);
  const std::size_t width = longest(lay_out(table));
  EXPECT_EQ(lay_out(table, width), lay_out(table));
  EXPECT_NE(lay_out(table, width - 1), lay_out(table));
}

TEST(TableLayout, NoLineIsLongerAndNoNumberIsCut) {
  const SpelledTable table = spell_markdown(two_metrics());
  for (std::size_t columns = 30; columns < 120; ++columns) {
    const std::string text = lay_out(table, columns);
    EXPECT_LE(longest(text), columns) << text;
    for (const char* number : {"**0.12345**", "[0.12320, 0.12370]", "-0.500", "[-0.520, -0.480]",
                               "0.2500", "[0.2432, 0.2568]", "– (1)"}) {
      EXPECT_NE(text.find(number), std::string::npos) << number << " at " << columns << '\n'
                                                      << text;
    }
  }
}

TEST(TableLayout, CellsAreBrokenFirstThenColumnsAreDealtOut) {
  const SpelledTable table = spell_markdown(two_metrics());
  const auto count = [&](std::size_t columns) {
    const auto lines = lines_of(lay_out(table, columns));
    return std::ranges::count_if(
        lines, [](const std::string& line) { return line.starts_with("| method"); });
  };
  EXPECT_EQ(count(75), 1);
  EXPECT_EQ(count(50), 2) << lay_out(table, 50);
  EXPECT_EQ(count(28), 0) << lay_out(table, 28);
  const std::string list = lay_out(table, 28);
  EXPECT_NE(list.find("- method: s3ho\n  samples: 32\n"), std::string::npos) << list;
}

TEST(TableLayout, AWordThatIsTooLongIsNotCut) {
  Table table{"t", "T", {{"what", ""}}, {{"abcdefghijklmnopqrstuvwxyz"}}, {}};
  EXPECT_NE(lay_out(spell_markdown(table), 10).find("abcdefghijklmnopqrstuvwxyz"),
            std::string::npos);
}

}  // namespace
}  // namespace occlab
