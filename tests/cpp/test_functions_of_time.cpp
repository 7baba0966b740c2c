// SPDX-License-Identifier: MIT
// Functions of time as columns of one table.
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <dolfinx_impact/problems/FunctionsOfTime.h>
#include <limits>
#include <stdexcept>
#include <vector>

using namespace dolfinx_impact::problems;

TEST_CASE("numbers have one column, vectors three, in the order in which they were added")
{
  FunctionsOfTime functions;
  CHECK(functions.add(FunctionOfTime([](double t) { return 2.0 * t; })) == 0);
  CHECK(functions.add(FunctionOfTime([](double t) { return std::array{t, t * t, -1.0}; })) == 1);
  CHECK(functions.add(FunctionOfTime([](double) { return 7.0; }, "seven")) == 4);
  CHECK(functions.num_columns() == 5);
  const std::vector<double> times{0.0, 3.0}, expected{0.0, 0.0, 0.0, -1.0, 7.0, 6.0, 3.0, 9.0, -1.0, 7.0};
  CHECK(functions.table(times) == expected);
  CHECK(functions.table_on_all_ranks(MPI_COMM_SELF, times) == expected);
  CHECK(functions.functions()[0].at(3.0) == 6.0);
  CHECK(functions.functions()[2].name() == "seven");
}

TEST_CASE("a source samples all functions at once, until it is taken away")
{
  FunctionsOfTime functions;
  functions.add(FunctionOfTime([](double t) { return t; }));
  functions.set_source([](std::span<const double> times) { return std::vector<double>(times.size(), 5.0); });
  const std::vector<double> times{1.0, 2.0};
  CHECK(functions.table_on_all_ranks(MPI_COMM_SELF, times) == std::vector<double>{5.0, 5.0});
  functions.set_source({});
  CHECK(functions.table_on_all_ranks(MPI_COMM_SELF, times) == times);
}

TEST_CASE("values that are not finite are refused")
{
  FunctionsOfTime functions;
  functions.add(FunctionOfTime([](double t) { return t < 1.0 ? t : std::numeric_limits<double>::quiet_NaN(); }));
  CHECK_NOTHROW(functions.table(std::vector<double>{0.5}));
  CHECK_THROWS_AS(functions.table(std::vector<double>{0.5, 1.5}), std::invalid_argument);
}
