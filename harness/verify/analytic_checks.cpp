#include "harness/verify/analytic_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "harness/statistics.h"
#include "harness/verify/analytic_bench.h"
#include "renderers/gl/context.h"
#include "renderers/methods/method.h"
#include "renderers/scene/data_root.h"
#include "renderers/scene/error.h"
#include "renderers/scene/image_io.h"

namespace occlab {
namespace {

/// One number that is compared, with the uncertainty of its estimate.
struct Compared {
  std::string where;  ///< "[2]" for a channel, "at (8, 6)" for a block; may be ""
  double measured = 0.0;
  double expected = 0.0;
  double standard_error = 0.0;
};

/// Mean over seeds, pixel by pixel, and its squared standard error.
struct MeanImage {
  Image mean;
  Image squared_error;
};

struct Measured {
  std::vector<Compared> compared;
  double degrees = 0.0;  ///< of freedom of the standard errors; 0: nothing is left to chance
  MeanImage image;
  Image expected;
};

MeanImage mean_image(const std::vector<Image>& images) {
  const Image& first = images.front();
  MeanImage result{Image(first.width(), first.height(), first.channels()),
                   Image(first.width(), first.height(), first.channels())};
  std::vector<double> values(images.size());
  for (std::size_t p = 0; p < first.values().size(); ++p) {
    for (std::size_t i = 0; i < images.size(); ++i) values[i] = double(images[i].values()[p]);
    result.mean.values()[p] = float(mean(values));
    result.squared_error.values()[p] =
        images.size() < 2 ? 0.0f : float(variance(values) / double(images.size()));
  }
  return result;
}

/// A rectangle's mean in one channel, one value a seed.
std::vector<double> block_means(const std::vector<Image>& images, int x0, int y0, int columns,
                                int rows, int channel) {
  std::vector<double> means;
  for (const Image& image : images) {
    double sum = 0.0;
    for (int y = y0; y < y0 + rows; ++y) {
      for (int x = x0; x < x0 + columns; ++x) sum += double(image.at(x, y, channel));
    }
    means.push_back(sum / (double(columns) * double(rows)));
  }
  return means;
}

double squared_standard_error(const std::vector<double>& replicates) {
  return variance(replicates) / double(replicates.size());
}

Measured measure_value(AnalyticBench& bench, const AnalyticCase& one) {
  const std::vector<Image> images = bench.render(one, one.quantity, World::plain, 1, one.seeds);
  const Image& first = images.front();
  if (std::size_t(first.channels()) != one.expected.size()) {
    throw InputError(fmt::format("{}.expected: found {} numbers; accepted: {}, one a channel of {}",
                                 one.place, one.expected.size(), first.channels(),
                                 one.quantity.layer));
  }
  Measured measured;
  measured.degrees = double(one.seeds - 1);
  measured.image = mean_image(images);
  measured.expected = Image(first.width(), first.height(), first.channels());
  for (int c = 0; c < first.channels(); ++c) {
    const double expected = one.expected[std::size_t(c)];
    const auto means = block_means(images, 0, 0, first.width(), first.height(), c);
    measured.compared.push_back({first.channels() > 1 ? fmt::format("[{}]", c) : "", mean(means),
                                 expected, std::sqrt(squared_standard_error(means))});
    for (int y = 0; y < first.height(); ++y) {
      for (int x = 0; x < first.width(); ++x) measured.expected.at(x, y, c) = float(expected);
    }
  }
  return measured;
}

/// Pixel by pixel; a layer of one channel stands for as many as the other has.
Measured measure_equality(AnalyticBench& bench, const AnalyticCase& one) {
  Measured measured;
  measured.image = mean_image(bench.render(one, one.quantity, World::plain, 1, 1));
  const Image& image = measured.image.mean;
  const Image other = bench.render(one, *one.other, World::plain, 1, 1).front();
  if (other.channels() != 1 && other.channels() != image.channels()) {
    throw InputError(
        fmt::format("{}.equals: {} has {} channels, {} has {}; accepted: as many, or 1", one.place,
                    one.other->layer, other.channels(), one.quantity.layer, image.channels()));
  }
  measured.expected = Image(image.width(), image.height(), image.channels());
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      for (int c = 0; c < image.channels(); ++c) {
        const float expected = other.at(x, y, other.channels() == 1 ? 0 : c);
        measured.expected.at(x, y, c) = expected;
        measured.compared.push_back({fmt::format("[{}] at ({}, {})", c, x, y),
                                     double(image.at(x, y, c)), double(expected), 0.0});
      }
    }
  }
  return measured;
}

constexpr int block_size = 8;  ///< pixels, a side

Measured measure_invariance(AnalyticBench& bench, const AnalyticCase& one) {
  const World world = one.expectation == Expectation::turned   ? World::turned
                      : one.expectation == Expectation::rolled ? World::rolled
                                                               : World::mirrored;
  const auto plain = bench.render(one, one.quantity, World::plain, 1, one.seeds);
  const auto other = bench.render(one, one.quantity, world, 1 + one.seeds, one.seeds);
  Measured measured;
  // Of the two, the one whose variance is all there is leaves seeds - 1 [Welch's lower limit].
  measured.degrees = double(one.seeds - 1);
  measured.image = mean_image(other);
  const MeanImage expected = mean_image(plain);
  measured.expected = expected.mean;
  for (std::size_t i = 0; i < expected.squared_error.values().size(); ++i) {
    measured.image.squared_error.values()[i] += expected.squared_error.values()[i];
  }
  const Image& first = plain.front();
  for (int y = 0; y < first.height(); y += block_size) {
    for (int x = 0; x < first.width(); x += block_size) {
      const int columns = std::min(block_size, first.width() - x);
      const int rows = std::min(block_size, first.height() - y);
      for (int c = 0; c < first.channels(); ++c) {
        const auto a = block_means(plain, x, y, columns, rows, c);
        const auto b = block_means(other, x, y, columns, rows, c);
        measured.compared.push_back(
            {fmt::format("[{}] of the block at ({}, {})", c, x, y), mean(b), mean(a),
             std::sqrt(squared_standard_error(a) + squared_standard_error(b))});
      }
    }
  }
  return measured;
}

Measured measure(AnalyticBench& bench, const AnalyticCase& one) {
  if (one.expectation == Expectation::value) return measure_value(bench, one);
  if (one.expectation == Expectation::equals) return measure_equality(bench, one);
  return measure_invariance(bench, one);
}

/// How many standard errors one of `tests` Student's t-tests may be off.
double critical_value(int tests, double degrees) {
  return -student_quantile(0.5 * sidak_level(analytic_family_level, tests), degrees);
}

/// Each pixel's two-sided p-value of an error beyond the case's bound, for itself: no correction
/// for how many there are.
Image p_values(const Measured& measured, double bound) {
  const Image& found = measured.image.mean;
  Image p(found.width(), found.height(), found.channels(), 1.0f);
  for (std::size_t i = 0; i < found.values().size(); ++i) {
    const double error =
        std::abs(double(found.values()[i]) - double(measured.expected.values()[i])) - bound;
    if (error <= 0.0) continue;
    const double deviation = std::sqrt(double(measured.image.squared_error.values()[i]));
    p.values()[i] =
        deviation > 0.0 ? float(2.0 * student_cdf(-error / deviation, measured.degrees)) : 0.0f;
  }
  return p;
}

/// A file name's worth of "wall: kappa = .25".
std::string slug(const std::string& text) {
  std::string name;
  for (const char c : text) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-';
    if (plain) name += c;
    if (!plain && !name.empty() && name.back() != '_') name += '_';
  }
  return name;
}

void write_images(const AnalyticCase& one, const Measured& measured,
                  const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw DeviceError(fmt::format("{}: cannot be made: {}", folder.string(), error.message()));
  }
  const Metadata metadata = {{"occlab:case", one.name},
                             {"occlab:method", one.quantity.method},
                             {"occlab:parameters", one.quantity.parameters().to_string()},
                             {"occlab:source", one.source}};
  const auto write = [&](const char* name, Image image) {
    Layers layers;
    layers.add(one.quantity.layer, std::move(image));
    write_exr(folder / fmt::format("{}.exr", name), layers, metadata);
  };
  Image difference = measured.image.mean;
  for (std::size_t i = 0; i < difference.values().size(); ++i) {
    difference.values()[i] -= measured.expected.values()[i];
  }
  write("image", measured.image.mean);
  write("expected", measured.expected);
  write("error", std::move(difference));
  write("p_value", p_values(measured, one.bound));
}

/// The number that comes closest to its bound, or exceeds it most.
Check judge(const AnalyticCase& one, const Measured& measured, const std::string& subject,
            int tests) {
  const double critical = measured.degrees > 0.0 ? critical_value(tests, measured.degrees) : 0.0;
  const auto bound_of = [&](const Compared& c) {
    return one.bound + (c.standard_error > 0.0 ? critical * c.standard_error : 0.0);
  };
  const auto excess = [&](const Compared& c) {
    const double error = std::abs(c.measured - c.expected);
    if (!std::isfinite(error)) return std::numeric_limits<double>::infinity();
    // A bound of 0 is met by equality alone; otherwise the share of the bound that is used.
    return bound_of(c) > 0.0 ? error / bound_of(c) : (error > 0.0 ? HUGE_VAL : 0.0);
  };
  const Compared& worst = *std::ranges::max_element(
      measured.compared,
      [&](const Compared& a, const Compared& b) { return excess(a) < excess(b); });
  std::string rule = one.bound > 0.0 ? fmt::format("{:.2g}: {}", one.bound, one.bound_source)
                                     : std::string("exact");
  if (measured.degrees > 0.0) {
    const std::string chance =
        fmt::format("{:.3g} standard errors (t, {:.0f} d.f., Sidak over {} tests at {:g})",
                    critical, measured.degrees, tests, analytic_family_level);
    rule = one.bound > 0.0 ? fmt::format("{} + {}", rule, chance) : chance;
  }
  return checked(
      {.subject = subject,
       .name = one.name,
       .quantity = fmt::format("{} {}{}", one.quantity.method, one.quantity.layer, worst.where),
       .measured = worst.measured,
       .expected = worst.expected,
       .bound = bound_of(worst),
       .rule = rule,
       .detail = one.source});
}

constexpr const char* reference_subject = "reference";

/// All other methods accumulate a representation in passes.
bool is_reference(const AnalyticCase& one) {
  return find_method(one.quantity.method).representation == nullptr;
}

Checks verify(const AnalyticSettings& settings, const std::string& subject) {
  struct Done {
    AnalyticCase one;
    Measured measured;
  };
  std::vector<Done> all;
  int tests = 0;
  const auto folder = settings.cases.empty() ? data_root() / "scenes" / "analytic" : settings.cases;
  const Context context(settings.device);
  ProgramCache programs;
  for (const std::filesystem::path& path : analytic_files(folder)) {
    AnalyticFile file = read_analytic_file(path);
    std::erase_if(file.cases, [&](const AnalyticCase& one) {
      return is_reference(one) != (subject == reference_subject);
    });
    if (file.cases.empty()) continue;
    AnalyticBench bench(file, programs);
    for (const AnalyticCase& one : file.cases) {
      all.push_back({one, measure(bench, one)});
      if (all.back().measured.degrees > 0.0) tests += int(all.back().measured.compared.size());
    }
  }
  // The level of each test depends on how many there are, so nothing is judged before all are done.
  Checks checks;
  for (const Done& done : all) {
    Check check = judge(done.one, done.measured, subject, tests);
    if (!check.passes) {
      const auto images =
          settings.output / slug(fmt::format("{}-{}", done.one.name, done.one.quantity.method));
      write_images(done.one, done.measured, images);
      check.detail += fmt::format("; images: {}", images.string());
    }
    checks.push_back(std::move(check));
  }
  return checks;
}

}  // namespace

Checks verify_reference(const AnalyticSettings& settings) {
  return verify(settings, reference_subject);
}

Checks verify_passes(const AnalyticSettings& settings) { return verify(settings, "passes"); }

}  // namespace occlab
