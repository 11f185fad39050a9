#include "harness/measurements.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <random>

#include "harness/csv.h"
#include "harness/files.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

namespace fs = std::filesystem;

Measurement example() {
  Measurement m;
  m.experiment = "s3ho";
  m.scene = "gallery";
  m.view = "main";
  m.resolution = "1280x720";
  m.probe = "cathedral, filtered 3 deg";
  m.method = "ssdo";
  m.parameters = {{"samples", "32"}, {"steps", "2"}};
  m.seed = "all";
  m.stage = "filtered";
  m.metric = "rmse";
  m.value = 0.1;
  m.lower = 0.09;
  m.upper = 0.11;
  m.n = 8;
  m.device = "llvmpipe (software)";
  m.cells = {"00112233aabbccdd", "ffeeddccbbaa9988"};
  m.reference_cell = "0123456789abcdef";
  return m;
}

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Csv, FollowsRfc4180) {
  const auto records = parse_csv("a,\"b,\"\"c\"\"\nd\",\r\n1,2,3\n", "x.csv");
  ASSERT_EQ(records.size(), 2u);
  EXPECT_EQ(records[0].fields, (std::vector<std::string>{"a", "b,\"c\"\nd", ""}));
  EXPECT_EQ(records[1].fields, (std::vector<std::string>{"1", "2", "3"}));
  EXPECT_EQ(records[1].line, 3);
  EXPECT_EQ(csv_line({"a", "b,\"c\"\nd", ""}), "a,\"b,\"\"c\"\"\nd\",\r\n");
  EXPECT_EQ(parse_csv("a,b", "x.csv").size(), 1u) << "the last line end may be missing";
  EXPECT_TRUE(parse_csv("", "x.csv").empty());
  EXPECT_EQ(parse_csv("\"\"\n", "x.csv")[0].fields, std::vector<std::string>{""});
}

TEST(Csv, RefusesWhatIsNotCsv) {
  const auto parse = [](const char* text) { return error_of([&] { parse_csv(text, "x.csv"); }); };
  EXPECT_EQ(parse("a,b\n\"c,d\n"), "x.csv:2: a quoted field is not closed");
  EXPECT_EQ(parse("a,b\n\"c\"d,e\n"), "x.csv:2: text after a quoted field");
  EXPECT_EQ(parse("a,b\nc\"d,e\n").substr(0, 10), "x.csv:2: a");
  EXPECT_EQ(parse("a,b\n1,2\n3\n"), "x.csv:3: 1 fields; the first line has 2");
  EXPECT_EQ(parse("a,b\n\n"), "x.csv:2: 1 fields; the first line has 2");
}

TEST(Csv, NumbersReadBackExactly) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 100000; ++i) {
    const double value = std::bit_cast<double>(random());
    if (std::isnan(value)) continue;
    ASSERT_EQ(parse_number(number_text(value), "here"), value);
  }
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(number_text(infinity), "inf");
  EXPECT_EQ(parse_number("-inf", "here"), -infinity);
  EXPECT_TRUE(std::signbit(parse_number(number_text(-0.0), "here")));
  for (const char* bad : {"", "nan", "1x", " 1", "1,5", "0x10", "--1", "1e999"}) {
    EXPECT_NE(error_of([&] { parse_number(bad, "here"); }).find("here: found '"), std::string::npos)
        << bad;
  }
}

TEST(Measurements, RoundTrip) {
  std::vector<Measurement> rows(4, example());
  rows[1].parameters = {{"samples", "8"}, {"steps", "2"}, {"cone_angle", "linear"}};
  rows[1].value = std::numeric_limits<double>::infinity();
  rows[1].lower = rows[1].upper = std::nullopt;
  rows[1].unit = "dB";
  rows[2].value = rows[2].lower = rows[2].upper = std::nullopt;
  rows[2].reason = "only \"12\" of 900, pixels\nare in shadow";
  rows[2].parameters = {{"rays_per_pixel", "64"}};
  rows[2].cells.clear();
  rows[2].seed = "3";
  rows[3].value = 1.0 / 3.0;
  rows[3].lower = -std::numeric_limits<double>::denorm_min();
  rows[3].upper = std::numeric_limits<double>::max();
  rows[3].stage = "";
  rows[3].metric = "time_ms.occlusion";
  rows[3].clock = "wall";
  const std::string csv = measurements_to_csv(rows);
  EXPECT_TRUE(
      csv.starts_with("experiment,scene,view,resolution,probe,method,"
                      "parameter.rays_per_pixel,parameter.samples,parameter.steps,"
                      "parameter.cone_angle,seed,stage,metric,unit,value,lower,upper,n,"
                      "device,clock,cells,reference_cell,reason\r\n"))
      << csv;
  EXPECT_EQ(measurements_from_csv(csv, "m.csv"), rows);
}

TEST(Measurements, FilesAreReplacedWhole) {
  const fs::path folder = fs::temp_directory_path() / fmt::format("occlab_measure_{}", getpid());
  fs::create_directories(folder);
  const fs::path path = folder / "measurements.csv";
  write_measurements(path, {example()});
  write_measurements(path, {example(), example()});
  EXPECT_EQ(read_measurements(path).size(), 2u);

  Measurement bad = example();
  bad.value = std::nan("");
  EXPECT_THROW(write_measurements(path, {bad}), InputError);
  EXPECT_EQ(read_measurements(path).size(), 2u) << "as it was";
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1) << "nothing beside it";

  EXPECT_THROW(write_measurements(path / "below_a_file.csv", {example()}), DeviceError);
  EXPECT_THROW(write_measurements(folder / "none" / "m.csv", {example()}), DeviceError);
  EXPECT_THROW(read_measurements(folder / "none.csv"), InputError);
  fs::remove_all(folder);
}

TEST(Measurements, RowsThatBreakTheRulesAreNotWritten) {
  const auto refused = [](const std::function<void(Measurement&)>& change) {
    Measurement m = example();
    change(m);
    return error_of([&] { measurements_to_csv({m}); });
  };
  EXPECT_EQ(error_of([] { measurements_to_csv({example()}); }), "no error");
  EXPECT_EQ(refused([](Measurement& m) { m.value = std::nan(""); }),
            "measurement 'rmse' of method 'ssdo', seed all: a number is NaN");
  for (const auto& change : std::vector<std::function<void(Measurement&)>>{
           [](Measurement& m) { m.experiment = ""; }, [](Measurement& m) { m.metric = ""; },
           [](Measurement& m) { m.seed = "-1"; }, [](Measurement& m) { m.seed = ""; },
           [](Measurement& m) { m.stage = "raw"; }, [](Measurement& m) { m.lower.reset(); },
           [](Measurement& m) { m.lower = 0.2; }, [](Measurement& m) { m.value.reset(); },
           [](Measurement& m) { m.value = m.lower = m.upper = std::nullopt; },
           [](Measurement& m) { m.reason = "why"; }, [](Measurement& m) { m.n = -1; },
           [](Measurement& m) { m.cells = {"a;b"}; }, [](Measurement& m) { m.cells = {""}; },
           [](Measurement& m) { m.parameters[0].second = ""; },
           [](Measurement& m) { m.parameters[1].first = "samples"; },
           [](Measurement& m) { m.parameters[1].first = "seed"; }}) {
    EXPECT_NE(refused(change), "no error");
  }
}

TEST(Measurements, BadFilesNameTheirLine) {
  const std::string good = measurements_to_csv({example(), example()});
  const auto damaged = [&](const std::string& from, const std::string& to) {
    std::string csv = good;
    const std::size_t at = csv.rfind(from);  // in the last row
    EXPECT_NE(at, std::string::npos);
    csv.replace(at, from.size(), to);
    return error_of([&] { measurements_from_csv(csv, "m.csv"); });
  };
  EXPECT_EQ(damaged(",0.1,", ",0.1.2,"),
            "m.csv:3: value: found '0.1.2'; accepted is a number, inf or -inf");
  EXPECT_EQ(damaged(",0.1,", ",nan,").substr(0, 9), "m.csv:3: ");
  EXPECT_EQ(damaged(",0.1,", ",,"), "m.csv:3: there is an interval but no value");
  EXPECT_EQ(damaged(",8,", ",8.5,"), "m.csv:3: n: found '8.5'; accepted is an integer");
  EXPECT_EQ(damaged(",filtered,", ",blurred,").substr(0, 27), "m.csv:3: stage is 'blurred'");
  EXPECT_EQ(damaged(",filtered,", ","), "m.csv:3: 20 fields; the first line has 21");
  EXPECT_EQ(damaged("reference_cell", "ref").substr(0, 30), "m.csv:1: the columns must be e");
  EXPECT_EQ(damaged("parameter.steps", "steps").substr(0, 28), "m.csv:1: the columns must be");
  EXPECT_EQ(damaged("parameter.steps", "parameter.samples"),
            "m.csv:1: column parameter.samples is there twice");
  EXPECT_EQ(error_of([] { measurements_from_csv("", "m.csv"); }),
            "m.csv: empty; measurements are expected");
}

TEST(Sha256, KnownDigests) {
  // FIPS 180-2, appendix B.
  EXPECT_EQ(sha256_text("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_text("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256_text(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  const fs::path path = fs::temp_directory_path() / fmt::format("occlab_sha_{}", getpid());
  std::ofstream(path) << std::string(1000000, 'a');  // appendix B.3, and longer than one block
  EXPECT_EQ(sha256_file(path), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  fs::remove(path);
  EXPECT_THROW(sha256_file(path), InputError);
  EXPECT_THROW(sha256_file(fs::temp_directory_path()), InputError);
}

}  // namespace
}  // namespace occlab
