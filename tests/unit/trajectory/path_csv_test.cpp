#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <clocale>
#include <fstream>
#include <locale>
#include <numbers>

#include "driveline/trajectory/path.hpp"
#include "support.hpp"

namespace driveline::trajectory {
namespace {

using testing::ElementsAre;

constexpr double kPi = std::numbers::pi;

Path parse(std::string_view text) {
  auto path = parse_path_csv(text, "p.csv");
  if (!path) {
    throw std::runtime_error(path.error().message());
  }
  return std::move(*path);
}

TEST(PathCsv, ConvertsEveryUnitToSi) {
  const Path path =
      parse("time[ms],a[rad],b[deg],c[rev],d[m],e[mm],f[um]\n0,1,180,1,1,1,1\n1500,-2,-90,0.5,-2,250,1e6\n");
  EXPECT_THAT(path.times_s(), ElementsAre(0.0, 1.5));
  EXPECT_THAT(path.positions(0), ElementsAre(1.0, kPi, 2.0 * kPi, 1.0, 1e-3, 1e-6));
  EXPECT_THAT(path.positions(1), ElementsAre(-2.0, -kPi / 2.0, kPi, -2.0, 0.25, 1.0));
  std::string kinds;
  for (const PathAxis& axis : path.axes()) {
    kinds += axis.name + (axis.kind == AxisKind::kRotary ? "=rotary " : "=linear ");
  }
  EXPECT_EQ(kinds, "a=rotary b=rotary c=rotary d=linear e=linear f=linear ");
}

TEST(PathCsv, ReadsTimesInEveryUnit) {
  EXPECT_THAT(parse("time[s],x[m]\n0.125,0\n0.25,0\n").times_s(), ElementsAre(0.125, 0.25));
  EXPECT_THAT(parse("time[ms],x[m]\n1,0\n3,0\n").times_s(), ElementsAre(0.001, 0.003));
  EXPECT_THAT(parse("time[us],x[m]\n125,0\n250,0\n").times_s(), ElementsAre(0.000125, 0.00025));
}

TEST(PathCsv, TimeMayBeAnyColumn) {
  const Path path = parse("x[rad],time[s],y[rad]\n1,0,2\n3,1,4\n");
  EXPECT_THAT(path.times_s(), ElementsAre(0.0, 1.0));
  EXPECT_THAT(path.positions(1), ElementsAre(3.0, 4.0));
}

TEST(PathCsv, ToleratesCommentsBlanksCrlfAndByteOrderMark) {
  const Path path = parse(
      "\xEF\xBB\xBF# made by hand\r\n"
      "\r\n"
      " time [s] ,\tx[ rad ]\r\n"
      "  # indented comment, with, commas\r\n"
      "0 , 1\r\n"
      " \t \r\n"
      "1,\t-2.5e-1 \r\n"
      "2,3");  // the last line has no end
  EXPECT_THAT(path.times_s(), ElementsAre(0.0, 1.0, 2.0));
  EXPECT_EQ(path.positions(1).front(), -0.25);
  EXPECT_EQ(path.positions(2).front(), 3.0);
  EXPECT_EQ(path.axes().front().name, "x");
}

TEST(PathCsv, SecondAndThirdColumnsOfAnAxisGiveItsDerivatives) {
  const Path path = parse(
      "y[mm/s^2],time[s],x[rad],y[mm],x[deg/s],y[m/s]\n"
      "5,0,1,2000,180,4\n"
      "6,1,2,3000,-90,8\n");
  ASSERT_EQ(path.axes().size(), 2U);
  EXPECT_EQ(path.axes()[0].name, "x");
  EXPECT_TRUE(path.axes()[0].gives_velocity);
  EXPECT_FALSE(path.axes()[0].gives_acceleration);
  EXPECT_TRUE(path.axes()[1].gives_velocity && path.axes()[1].gives_acceleration);
  EXPECT_EQ(path.axes()[1].unit->name, "mm") << "of its positions";
  EXPECT_THAT(path.positions(1), ElementsAre(2.0, 3.0));
  EXPECT_THAT(path.velocities(0), ElementsAre(kPi, 4.0));
  EXPECT_THAT(path.velocities(1), ElementsAre(-kPi / 2.0, 8.0));
  EXPECT_THAT(path.accelerations(0), ElementsAre(0.0, 5e-3));
  EXPECT_THAT(path.accelerations(1), ElementsAre(0.0, 6e-3));
}

TEST(PathCsv, WithoutSuchColumnsThereAreNoDerivatives) {
  const Path path = parse("time[s],x[rad]\n0,1\n1,2\n");
  EXPECT_FALSE(path.axes()[0].gives_velocity);
  EXPECT_TRUE(path.velocities(0).empty());
  EXPECT_TRUE(path.accelerations(1).empty());
}

class CommaPoint : public std::numpunct<char> {
 protected:
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST(PathCsv, DoesNotDependOnTheLocale) {
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new CommaPoint));
  // Only on machines that have it; the C++ locale above always works.
  std::setlocale(LC_NUMERIC, "de_DE.UTF-8");
  const Path path = parse("time[s],x[rad]\n0,1234.5\n1,0.5\n");
  const std::string error = parse_path_csv("time[s],x[rad]\n1500.5,0\n1500.5,0\n", "p.csv").error().message();
  std::setlocale(LC_NUMERIC, "C");
  std::locale::global(before);
  EXPECT_EQ(path.positions(0).front(), 1234.5);
  EXPECT_EQ(error, "p.csv:3: time 1500.5 s does not come after the previous time 1500.5 s");
}

struct BadInput {
  const char* text;
  const char* message;
};

class PathCsvBadInput : public testing::TestWithParam<BadInput> {};

TEST_P(PathCsvBadInput, IsRefusedWithPlaceAndReason) {
  const auto path = parse_path_csv(GetParam().text, "p.csv");
  ASSERT_FALSE(path.has_value());
  EXPECT_EQ(path.error().message(), GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Header, PathCsvBadInput,
    testing::Values(
        BadInput{"", "p.csv:1: the file has no header row such as time[s],x[rad]"},
        BadInput{"\xEF\xBB\xBF", "p.csv:1: the file has no header row such as time[s],x[rad]"},
        BadInput{"# only\n\n#comments\n", "p.csv:1: the file has no header row such as time[s],x[rad]"},
        BadInput{"# a\n0,1,2\n1,2,3\n", "p.csv:2:1: expected a header row such as time[s],x[rad], found '0'"},
        BadInput{" time,x\n", "p.csv:1:2: expected a header row such as time[s],x[rad], found 'time'"},
        BadInput{"time[s],x[furlong]\n",
                 "p.csv:1:9: unknown unit 'furlong' of column 'x'; expected s, ms, us, rad, deg, rev, m, mm or um"},
        BadInput{"time[s],x[]\n",
                 "p.csv:1:9: unknown unit '' of column 'x'; expected s, ms, us, rad, deg, rev, m, mm or um"},
        BadInput{"time[s],x[Rad]\n",
                 "p.csv:1:9: unknown unit 'Rad' of column 'x'; expected s, ms, us, rad, deg, rev, m, mm or um"},
        BadInput{"time[s],x\n", "p.csv:1:9: column 'x' must be a name and a unit such as x[rad]"},
        BadInput{"time[s],x[rad\n", "p.csv:1:9: column 'x[rad' must be a name and a unit such as x[rad]"},
        BadInput{"time[s],x[rad],\n", "p.csv:1:16: column '' must be a name and a unit such as x[rad]"},
        BadInput{"t[s],x[rad]\n",
                 "p.csv:1:1: axis 't' must be in rad, deg, rev, m, mm or um, not in s; the column of the time is "
                 "called time"},
        BadInput{"x[rad],y[mm]\n",
                 "p.csv:1: the header has no time column; one column must be time[s], time[ms] or time[us]"},
        BadInput{"time[rad],x[rad]\n", "p.csv:1:1: the time column must be in s, ms or us, not in rad"},
        BadInput{"time[s],time[ms],x[rad]\n", "p.csv:1:9: the time column appears twice"},
        BadInput{"time[s]\n0\n1\n", "p.csv:1: the header has a time column but no axis"},
        BadInput{"time[s],x[rad], x[mm]\n", "p.csv:1:17: axis name 'x' appears twice"},
        BadInput{"time[s],[rad]\n",
                 "p.csv:1:9: axis name '' must be 1 to 31 characters out of letters a to z and A to Z, digits and _-., "
                 "and not be time"},
        BadInput{
            "time[s],\xCF\x86[rad]\n",
            "p.csv:1:9: axis name '?\?' must be 1 to 31 characters out of letters a to z and A to Z, digits and _-., "
            "and not be time"}));

INSTANTIATE_TEST_SUITE_P(
    Derivatives, PathCsvBadInput,
    testing::Values(
        BadInput{"time[s],x[rad],y[rad/s]\n", "p.csv:1:16: there are no positions for the velocities of axis 'y'"},
        BadInput{"time[s],x[rad/s]\n", "p.csv:1:9: there are no positions for the velocities of axis 'x'"},
        BadInput{"time[s],x[rad],x[rad/s^2]\n", "p.csv:1:9: axis 'x' has accelerations but no velocities"},
        BadInput{"time[s],x[rad],x[deg/s],x[rad/s]\n", "p.csv:1:25: the velocities of axis 'x' appear twice"},
        BadInput{"time[s],x[rad],x[mm/s]\n",
                 "p.csv:1:16: the velocities of axis 'x' must fit its positions in rad, not be in mm/s"},
        BadInput{"time[s],x[mm],x[mm/s],x[rev/s^2]\n",
                 "p.csv:1:23: the accelerations of axis 'x' must fit its positions in mm, not be in rev/s^2"},
        BadInput{"time[s],x[rad],x[rad/min]\n",
                 "p.csv:1:16: unknown unit 'rad/min' of column 'x'; expected s, ms, us, rad, deg, rev, m, mm or um, "
                 "with /s for velocities and /s^2 for accelerations"},
        BadInput{"time[s],x[rad],x[rad/s^2/s]\n",
                 "p.csv:1:16: unknown unit 'rad/s^2/s' of column 'x'; expected s, ms, us, rad, deg, rev, m, mm or um, "
                 "with /s for velocities and /s^2 for accelerations"},
        BadInput{"time[s],x[rad],x[s/s]\n",
                 "p.csv:1:16: unknown unit 's/s' of column 'x'; expected s, ms, us, rad, deg, rev, m, mm or um, "
                 "with /s for velocities and /s^2 for accelerations"},
        BadInput{"time[rad/s],x[rad]\n", "p.csv:1:1: the time column must be in s, ms or us, not in rad/s"},
        BadInput{"time[s],x[rad],x[rad/s]\n0,1\n", "p.csv:2: expected 3 fields as in the header, found 2"},
        BadInput{"time[s],x[rad],x[rad/s]\n0,1,fast\n", "p.csv:2:5: 'fast' is not a number"},
        BadInput{"time[s],x[rad],x[rad/s]\n0,1,nan\n", "p.csv:2:5: 'nan' is not a finite number"},
        BadInput{"time[s],x[mm],x[m/s]\n0,1,0\n1,1,-2e12\n",
                 "p.csv:3: velocity -2e+12 m/s of axis 'x' is not within +-1e+12 m/s"},
        BadInput{"time[s],x[rad],x[rad/s],x[rev/s^2]\n0,1,0,1e15\n",
                 "p.csv:2: acceleration 6283185307179586 rad/s^2 of axis 'x' is not within +-1e+15 rad/s^2"}));

INSTANTIATE_TEST_SUITE_P(
    Rows, PathCsvBadInput,
    testing::Values(
        BadInput{"time[s],x[rad]\n0,1\n1\n", "p.csv:3: expected 2 fields as in the header, found 1"},
        BadInput{"time[s],x[rad]\n0,1,\n",
                 "p.csv:2: expected 2 fields as in the header, found 3; the separator is a comma, and numbers have a "
                 "decimal point"},
        BadInput{"time[s],x[rad]\n0,0\n0,5,1,25\n",
                 "p.csv:3: expected 2 fields as in the header, found 4; the separator is a comma, and numbers have a "
                 "decimal point"},
        BadInput{"time[s],x[rad]\n0;1\n",
                 "p.csv:2: expected 2 fields as in the header, found 1; the separator is a comma, and numbers have a "
                 "decimal point"},
        BadInput{"time[s];x[rad]\n0,5;1,25\n",
                 "p.csv:1: the separator is a comma, and numbers have a decimal point: time[s],x[rad]"},
        BadInput{"time[s]\tx[rad]\n0\t1\n",
                 "p.csv:1: the separator is a comma, and numbers have a decimal point: time[s],x[rad]"},
        BadInput{"time[s],x[rad]\n0,1\n\n# c\n1,abc\n", "p.csv:5:3: 'abc' is not a number"},
        BadInput{"time[s],x[rad]\n0,  1.5x\n", "p.csv:2:5: '1.5x' is not a number"},
        BadInput{"time[s],x[rad]\n0,\n", "p.csv:2:3: '' is not a number"},
        BadInput{"time[s],x[rad]\n0,+1\n", "p.csv:2:3: '+1' is not a number"},
        BadInput{"time[s],x[rad]\n0,0x10\n", "p.csv:2:3: '0x10' is not a number"},
        BadInput{"time[s],x[rad]\n0,1 2\n", "p.csv:2:3: '1 2' is not a number"},
        BadInput{"time[s],x[rad]\n0,\"1\"\n", "p.csv:2:3: '\"1\"' is not a number"},
        BadInput{"time[s],x[rad]\n0,nan\n", "p.csv:2:3: 'nan' is not a finite number"},
        BadInput{"time[s],x[rad]\n-inf,0\n", "p.csv:2:1: '-inf' is not a finite number"},
        BadInput{"time[s],x[rad]\n0,1e999\n", "p.csv:2:3: '1e999' is beyond the range of a double"},
        BadInput{"time[s],x[rev]\n0,1e308\n", "p.csv:2: position inf rad of axis 'x' is not within +-1e+09 rad"},
        BadInput{"time[s],x[mm]\n0,2e12\n", "p.csv:2: position 2e+09 m of axis 'x' is not within +-1e+09 m"},
        BadInput{"time[s],x[rad]\n2e5,0\n", "p.csv:2: time 2e+05 s is not within +-1e+05 s"},
        BadInput{"time[ms],x[rad]\n500,1\n500,2\n", "p.csv:3: time 0.5 s does not come after the previous time 0.5 s"},
        BadInput{"time[s],x[rad]\n0,1\n2,1\n1,2\n", "p.csv:4: time 1 s does not come after the previous time 2 s"},
        BadInput{"time[us],x[rad]\n0,1\n0.0005,2\n",
                 "p.csv:3: time 5e-10 s comes less than 1 ns after the previous time 0 s"},
        BadInput{"time[s],x[rad]\n", "p.csv: a path needs at least 2 points, found 0"},
        BadInput{"time[s],x[rad]\n0,1\n", "p.csv: a path needs at least 2 points, found 1"}));

TEST(PathCsv, AnErrorIsOneLineWhateverTheFileHolds) {
  const std::string text("time[s],x[rad]\n0,\x00\x1B[31m\xFF\n", 24);
  EXPECT_EQ(parse_path_csv(text, "p.csv").error().message(), "p.csv:2:3: '?\?[31m?' is not a number");
}

TEST(PathCsv, TooManyAxesNameTheColumn) {
  std::string header = "time[s]";
  for (int i = 0; i <= 256; ++i) {
    header.append(",x").append(std::to_string(100 + i)).append("[m]");
  }
  EXPECT_EQ(parse_path_csv(header, "p.csv").error().message(), "p.csv:1:2057: a path may have at most 256 axes");
}

TEST(PathCsv, DamagedTextIsRefusedOrStillAValidPath) {
  const std::string valid =
      "# c\r\ntime[ms],x[rad],y[mm],x[rad/s],x[rad/s^2]\n0,1.5,-2e3,1,1\n1,0.25,7,2,2\n2.5,-1,8,3,3\n";
  constexpr std::string_view kAlphabet("0123456789.-+eEnaif,[]#\r\n \tmsrd/^\xEF\x00", 35);
  test::Random random;
  std::size_t accepted = 0;
  for (int round = 0; round < 20000; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    std::string text = valid;
    for (std::size_t edits = random.index(1, 4); edits > 0; --edits) {
      const std::size_t where = random.index(0, text.size() - 1);
      const char replacement = kAlphabet[random.index(0, kAlphabet.size() - 1)];
      if (random.index(0, 1) == 0) {
        text[where] = replacement;
      } else {
        text.insert(where, 1, replacement);
      }
    }
    const auto path = parse_path_csv(text, "p.csv");
    if (!path) {
      ASSERT_EQ(path.error().message().rfind("p.csv", 0), 0U);
      continue;
    }
    ++accepted;
    ASSERT_GE(path->points(), 2U);
    for (std::size_t k = 0; k < path->points(); ++k) {
      ASSERT_TRUE(k == 0 || path->times_s()[k] > path->times_s()[k - 1]);
      for (const double position : path->positions(k)) {
        ASSERT_LE(std::abs(position), kMaxPathPosition);
      }
    }
  }
  EXPECT_GT(accepted, 100U);
}

TEST(LoadPath, ReadsAFileAndNamesItInErrors) {
  const std::string file = testing::TempDir() + "driveline_load_path_test.csv";
  std::ofstream(file, std::ios::binary) << "time[s],x[rad]\r\n0,1\r\n1,2\r\n";
  const auto path = load_path(file);
  std::ofstream(file, std::ios::binary) << "time[s],x[rad]\n0,1\n1,z\n";
  const auto bad = load_path(file);
  std::remove(file.c_str());
  ASSERT_TRUE(path.has_value());
  EXPECT_EQ(path->positions(1).front(), 2.0);
  EXPECT_EQ(bad.error().message(), file + ":3:3: 'z' is not a number");
}

TEST(LoadPath, AFileWithTooManyRowsIsRefusedBeforeItIsParsed) {
  const std::string file = testing::TempDir() + "driveline_long_path_test.csv";
  // Its second row is wrong, too, which only a parser would find.
  std::ofstream(file, std::ios::binary) << "time[s],x[rad]\nwrong\n" + std::string(1'000'000, '\n');
  const auto path = load_path(file);
  std::ofstream(file, std::ios::binary) << "time[s],x[rad]\n0,1\n1,2\n" + std::string(999'997, '\n');
  const auto longest = load_path(file);
  std::remove(file.c_str());
  ASSERT_FALSE(path);
  EXPECT_EQ(path.error().message(), file + ": has more than 1000000 lines");
  EXPECT_TRUE(longest) << longest.error().message();
}

TEST(LoadPath, SaysWhyAFileCannotBeRead) {
  EXPECT_EQ(load_path("/nonexistent/p.csv").error().message(),
            "/nonexistent/p.csv: cannot be read: No such file or directory");
  EXPECT_EQ(load_path("/tmp").error().message(), "/tmp: cannot be read: Is a directory");
  EXPECT_EQ(load_path("/dev/zero").error().message(), "/dev/zero: is larger than 128 MiB");
}

}  // namespace
}  // namespace driveline::trajectory
