// SPDX-License-Identifier: MIT
// Functions of time from tables of times and values.
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <dolfinx_impact/problems/AmplitudeTable.h>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <vector>

using namespace dolfinx_impact::problems;

namespace
{
double table_at(const AmplitudeTable& table, double time)
{
  double value = 0.0;
  table.sample({&time, 1}, {&value, 1});
  return value;
}
} // namespace

TEST_CASE("a table is met at its times and straight between them, or smooth without slope at its times")
{
  const std::vector<double> times{0.0, 0.5, 2.0}, values{1.0, 3.0, -2.0};
  for (const Interpolation kind : {Interpolation::linear, Interpolation::smooth})
  {
    const AmplitudeTable table(times, values, {kind});
    for (std::size_t k = 0; k < times.size(); ++k)
      CHECK(table_at(table, times[k]) == values[k]);
    CHECK(table_at(table, -1.0) == 1.0);
    CHECK(table_at(table, 9.0) == -2.0);
    CHECK(table_at(table, 0.25) == Catch::Approx(2.0));
  }
  const AmplitudeTable linear(times, values), smooth(times, values, {Interpolation::smooth});
  CHECK(table_at(linear, 0.1) == Catch::Approx(1.4));
  const double r = 0.2, step = r * r * r * (10 - 15 * r + 6 * r * r), h = 1e-4;
  CHECK(table_at(smooth, 0.1) == Catch::Approx(1.0 + 2.0 * step));
  // Of third order in the distance, so that first and second derivatives vanish: 10 (h / 0.5)^3 times the step of 2.
  CHECK(std::abs(table_at(smooth, h) - 1.0) < 21.0 * std::pow(h / 0.5, 3));
  CHECK(std::abs(table_at(smooth, 0.5 - h) - 3.0) < 21.0 * std::pow(h / 0.5, 3));
}

TEST_CASE("vectors of two components are functions of time with a third one")
{
  const AmplitudeTable table({0.0, 1.0}, {0.0, 1.0, 2.0, 5.0});
  const FunctionOfTime f = table.function();
  REQUIRE(table.size() == 2);
  REQUIRE(f.size() == 3);
  std::vector<double> out(6, 7.0), times{0.5, 1.0};
  f.sample(times, out);
  CHECK(out == std::vector<double>{1.0, 3.0, 0.0, 2.0, 5.0, 0.0});
}

TEST_CASE("times outside are refused where that was asked for, and tables that are none")
{
  AmplitudeTable::Options options;
  options.before = options.after = Outside::refuse;
  options.name = "pulse";
  const AmplitudeTable table({0.0, 1.0}, {0.0, 1.0}, options);
  CHECK(table_at(table, 1.0) == 1.0);
  CHECK_THROWS_AS(table_at(table, 1.1), std::invalid_argument);
  CHECK_THROWS_AS(table_at(table, -0.1), std::invalid_argument);
  CHECK_THROWS_AS(table_at(table, std::nan("")), std::invalid_argument);
  CHECK_THROWS_AS(AmplitudeTable({}, {}), std::invalid_argument);
  CHECK_THROWS_AS(AmplitudeTable({0.0, 0.0}, {0.0, 1.0}), std::invalid_argument);
  CHECK_THROWS_AS(AmplitudeTable({0.0, 1.0}, {0.0, 1.0, 2.0}), std::invalid_argument);
  CHECK_THROWS_AS(AmplitudeTable({0.0}, {1.0, 2.0, 3.0, 4.0}), std::invalid_argument);
  CHECK_THROWS_AS(AmplitudeTable({0.0, 1.0}, {0.0, INFINITY}), std::invalid_argument);
}

TEST_CASE("tables are read from text files")
{
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "impact_amplitude_table.csv";
  const auto write = [&](const char* text) { std::ofstream(file) << text; };
  write("time [s];force [N]\n# measured\n0;1.5\r\n\n 1e-3 ; +2\n");
  const AmplitudeTable table = AmplitudeTable::from_csv(file);
  CHECK(std::vector<double>(table.times().begin(), table.times().end()) == std::vector<double>{0.0, 1e-3});
  CHECK(std::vector<double>(table.values().begin(), table.values().end()) == std::vector<double>{1.5, 2.0});
  for (const char* wrong : {"t, a\nt, b\n0, 1\n", "0, 1\n1\n", "0, 1\n1, 2, 3\n", "0, 1\n1, 1.0e\n", "# nothing\n"})
  {
    write(wrong);
    CHECK_THROWS_AS(AmplitudeTable::from_csv(file), std::invalid_argument);
  }
  std::filesystem::remove(file);
  CHECK_THROWS_AS(AmplitudeTable::from_csv(file), std::runtime_error);
}
