// Plots on logarithmic axes: what is drawn where.

#include "harness/figures/log_plot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr DisplayColour red = {0.9f, 0.0f, 0.0f};
constexpr DisplayColour blue = {0.0f, 0.0f, 0.9f};

LogPoint point(double x, double y) { return {x, y, y, y}; }

LogPlotFigure figure_of(std::vector<LogSeries> series) {
  return {"A title", {{"time, ms", "samples", std::move(series), {}}}, "A caption.", 1280};
}

/// Centres of the connected columns of pixels of exactly this colour that are at least `least`
/// high.
std::vector<std::pair<double, double>> markers(const Image& image, const DisplayColour& colour) {
  const auto is_colour = [&](int x, int y) {
    for (int c = 0; c < 3; ++c) {
      if (std::abs(image.at(x, y, c) - colour[std::size_t(c)]) > 1e-3f) return false;
    }
    return true;
  };
  std::vector<std::pair<double, double>> found;
  for (int x = 0; x < image.width(); ++x) {
    for (int y = 100; y < image.height(); ++y) {  // below the legend
      int end = y;
      while (end < image.height() && is_colour(x, end)) ++end;
      if (end - y >= 9) found.emplace_back(x, 0.5 * (y + end));
      y = end;
    }
  }
  return found;
}

TEST(LogPlot, EqualRatiosAreEqualDistances) {
  // 10, 100, 1000: on a line, at equal steps.
  const Image image =
      log_plot_figure(figure_of({{"a", red, {point(10, 5), point(1000, 500), point(100, 50)}}}));
  std::vector<std::pair<double, double>> found = markers(image, red);
  ASSERT_GE(found.size(), 3u);
  std::vector<std::pair<double, double>> centres;  // columns of one marker are neighbours
  std::vector<std::pair<double, double>> group;
  found.emplace_back(1e9, 0);
  for (const auto& column : found) {
    if (!group.empty() && column.first > group.back().first + 1.5) {
      centres.emplace_back(0.5 * (group.front().first + group.back().first), group.front().second);
      group.clear();
    }
    group.push_back(column);
  }
  ASSERT_EQ(centres.size(), 3u);
  EXPECT_NEAR(centres[1].first - centres[0].first, centres[2].first - centres[1].first, 2.0);
  EXPECT_NEAR(centres[1].second - centres[0].second, centres[2].second - centres[1].second, 2.0);
  EXPECT_GT(centres[0].second, centres[2].second + 100) << "more is above";
}

TEST(LogPlot, AsWideAsAskedAndInRange) {
  const Image image = log_plot_figure(
      {"Title",
       {{"left", "x", {{"a", red, {point(1, 1), point(2, 3)}}, {"b", blue, {point(1, 2)}}}, {}},
        {"right", "x", {{"a", red, {point(1, 1e-3), point(9, 1e6)}}}, {}}},
       "Caption",
       1280});
  EXPECT_NEAR(image.width(), 1280, 40);
  for (const float value : image.values()) {
    ASSERT_GE(value, 0.0f);
    ASSERT_LE(value, 1.0f);
  }
}

TEST(LogPlot, Refusals) {
  EXPECT_THROW(log_plot_figure({"t", {}, "c", 1280}), InputError);
  EXPECT_THROW(log_plot_figure(figure_of({})), InputError);
  EXPECT_THROW(log_plot_figure(figure_of({{"a", red, {}}})), InputError);
  for (const double bad : {0.0, -1.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
    EXPECT_THROW(log_plot_figure(figure_of({{"a", red, {point(bad, 1)}}})), InputError) << bad;
    EXPECT_THROW(log_plot_figure(figure_of({{"a", red, {point(1, bad)}}})), InputError) << bad;
    EXPECT_THROW(log_plot_figure(figure_of({{"a", red, {{1, 1, bad, 1}}}})), InputError) << bad;
  }
}

}  // namespace
}  // namespace occlab
