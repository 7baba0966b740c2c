// SPDX-License-Identifier: MIT
// Internal variables at the points: committed and trial values, in place with a snapshot, order of cells and lanes.
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <dolfinx_impact/operators/PointHistory.h>
#include <limits>
#include <stdexcept>
#include <vector>

using dolfinx_impact::operators::PointHistory;

namespace
{
const impact_output outputs[] = {{"strain", 2, 8, 0}, {"stress", 1, 14, -1}};

impact_kernel kernel_of_points(int num_points)
{
  impact_kernel k{};
  k.name = "test";
  k.num_points = num_points;
  k.num_outputs = 2;
  k.outputs = outputs;
  return k;
}

/// As a kernel would: trial values of all batches are the committed ones plus x.
void evaluate(PointHistory& h, std::size_t num_batches, double x)
{
  for (std::size_t b = 0; b < num_batches; ++b)
  {
    const std::vector<double> read(h.committed(0, b), h.committed(0, b) + h.batch_size(0));
    std::transform(read.begin(), read.end(), h.trial(0, b), [x](double y) { return y + x; });
  }
  h.set_evaluated();
}

const std::vector<std::int32_t> cells{4, 1, 9, 0, 2};
} // namespace

TEST_CASE("only a commit changes committed values")
{
  PointHistory h(kernel_of_points(3), cells, 4);
  evaluate(h, 2, 1.0);
  CHECK(std::ranges::count(h.values(0), 0.0) == 30);
  CHECK(std::ranges::count(h.values(0, true), 1.0) == 30);
  h.commit();
  h.commit(); // nothing was evaluated since
  CHECK(std::ranges::count(h.values(0), 1.0) == 30);
  evaluate(h, 2, 5.0);
  evaluate(h, 2, 2.0); // starts from the committed values again
  CHECK(std::ranges::count(h.values(0, true), 3.0) == 30);
  h.revert();
  h.commit();
  CHECK(std::ranges::count(h.values(0), 1.0) == 30);
}

TEST_CASE("values are in the order of the cells; lanes left over repeat the last cell")
{
  PointHistory h(kernel_of_points(3), cells, 4);
  std::vector<double> values(30);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = i;
  h.set_values(0, values);
  CHECK(h.values(0) == values);
  // Cell 1, point 2, component 1 stands at its lane; so does cell 4 in all lanes of the second batch.
  CHECK(h.committed(0, 0)[(2 * 2 + 1) * 4 + 1] == 1 * 6 + 2 * 2 + 1);
  for (int lane = 0; lane < 4; ++lane)
    CHECK(h.committed(0, 1)[(2 * 2 + 1) * 4 + lane] == 4 * 6 + 2 * 2 + 1);
}

TEST_CASE("in place, evaluations add up and a snapshot brings them back")
{
  PointHistory h(kernel_of_points(3), cells, 4);
  CHECK_THROWS_AS(h.store_snapshot(), std::logic_error);
  h.set_in_place(true);
  CHECK_THROWS_AS(h.restore_snapshot(), std::logic_error);
  evaluate(h, 2, 1.0);
  h.store_snapshot();
  evaluate(h, 2, 1.0);
  h.commit(); // has nothing to do
  CHECK(std::ranges::count(h.values(0), 2.0) == 30);
  h.restore_snapshot();
  CHECK(std::ranges::count(h.values(0), 1.0) == 30);
}

TEST_CASE("batches whose committed values are all zero are known, whatever has changed them")
{
  PointHistory h(kernel_of_points(3), cells, 4);
  const auto known = [&] { return std::vector<int>(h.batches_with_history(), h.batches_with_history() + 2); };
  const std::vector<int> none{0, 0}, second{0, 1}, both{1, 1};
  std::vector<double> values(30, 0.0);
  CHECK(known() == none);
  values[4 * 6] = -0.0; // of the last cell: a kernel that reads it may tell it from zero
  h.set_values(0, values);
  CHECK(known() == second);
  values[4 * 6] = 0.0;
  h.set_values(0, values);
  CHECK(known() == none);
  evaluate(h, 2, 1.0);
  h.revert();
  CHECK(known() == none);
  h.set_in_place(true);
  h.store_snapshot();
  *h.trial(0, 1) = 1.0; // what is not a sweep of a kernel writes here
  CHECK(known() == second);
  evaluate(h, 2, 1.0);
  CHECK(known() == both);
  h.restore_snapshot();
  CHECK(known() == none);
  h.set_in_place(false);
  evaluate(h, 2, 1.0);
  h.commit();
  CHECK(known() == both);
  // A state refers to committed values: once it is set, `revert` says so.
  std::fill_n(h.overwritten(0), 2 * h.batch_size(0), 0.0);
  h.revert();
  CHECK(known() == none);
}

TEST_CASE("values that do not fit are refused")
{
  PointHistory h(kernel_of_points(3), cells, 4);
  CHECK_THROWS_AS(h.set_values(0, std::vector<double>(29)), std::invalid_argument);
  CHECK_THROWS_AS(h.set_values(0, std::vector<double>(30, std::numeric_limits<double>::quiet_NaN())),
                  std::invalid_argument);
  CHECK_THROWS_AS(h.find("strains"), std::invalid_argument);
  CHECK(h.is_history(0));
  CHECK_FALSE(h.is_history(1));
  // Committed and trial strain, one array of stress: 2 batches of 4 lanes and 3 points.
  CHECK(h.memory() == (2 * 2 + 1) * 2 * 4 * 3 * sizeof(double));
  CHECK_THROWS_AS(PointHistory(impact_kernel{.name = "no outputs"}, cells, 4), std::invalid_argument);
}
