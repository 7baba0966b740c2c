// SPDX-License-Identifier: MIT
// Penalty contact refuses what does not belong together.
#include <catch2/catch_test_macros.hpp>
#include <dolfinx_impact/enforcement/penalty/penalty.h>
#include <stdexcept>
#include <string>

using namespace dolfinx_impact;
using namespace dolfinx_impact::enforcement;

namespace
{
/// One segment of the plane with one point above a plane.
struct OnePoint
{
  surface::Facets slave = segment(), master = segment();
  gap::Points points = gap::make_points(slave, std::vector{0.5}, std::vector{1.0}, false);
  PenaltyHistory history = make_history(points);
  std::vector<double> increment = std::vector<double>(4, 0.0);
  const gap::Rigid plane{.kind = gap::Rigid::Kind::plane, .gdim = 2, .direction = {0, 1, 0}};

  static surface::Facets segment()
  {
    surface::Facets f;
    f.gdim = 2;
    f.displacement = f.geometry = {surface::FacetShape::interval, 1};
    f.nodes = {0, 1};
    f.X = f.x = {0.0, -0.1, 1.0, -0.1};
    f.orientation = {1};
    f.id = {0};
    return f;
  }

  /// What `evaluate` says about it.
  std::string error(const surface::Facets& own, const surface::Facets* other, PenaltyParameters parameters) const
  {
    try
    {
      evaluate(PenaltyPair{points, own, other, parameters, history, increment});
    }
    catch (const std::invalid_argument& e)
    {
      return e.what();
    }
    return "";
  }
};
} // namespace

TEST_CASE("a pair is of one slave and one master")
{
  OnePoint one;
  CHECK(one.error(one.slave, nullptr, {1.0}) == "these points were not updated for a rigid master");
  gap::update(one.points, one.slave, one.plane);
  CHECK(one.error(one.slave, nullptr, {1.0}).empty());
  const PenaltyState state = evaluate(PenaltyPair{one.points, one.slave, nullptr, {2.0}, one.history, {}});
  CHECK(state.pressure[0] == 2.0 * 0.1);
  CHECK(one.error(one.slave, nullptr, {0.0}) == "a penalty is positive, a friction coefficient not negative");
  CHECK(one.error(one.slave, nullptr, {1.0, 0.0, 0.3}) == "friction needs a positive tangential penalty");
  one.increment.clear();
  CHECK(one.error(one.slave, nullptr, {1.0, 1.0, 0.3}) == "friction needs the increments of displacement of all nodes");
  surface::Facets two = one.slave;
  two.orientation = {1, 1};
  CHECK(one.error(two, nullptr, {1.0}) == "the points belong to another slave");
  // A point that was found on a facet which the master does not have.
  one.points.master = {5};
  CHECK(one.error(one.slave, &one.master, {1.0}) == "these points were updated for another master");
  surface::Facets space = one.master;
  space.gdim = 3;
  one.points.master = {0};
  CHECK(one.error(one.slave, &space, {1.0}) == "these points were updated for another master");
  one.history.multiplier.clear();
  CHECK(one.error(one.slave, nullptr, {1.0}) == "the history belongs to other points");
}
