// SPDX-License-Identifier: MIT
// The collaborators of NodeTracker, each alone: bounds hold, lists expire and nodes are activated in time.
#include <algorithm>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <dolfinx_impact/common/vectors.h>
#include <dolfinx_impact/search/closest_point/SurfaceSearch.h>
#include <dolfinx_impact/search/node_tracker/NodeTracker.h>
#include <dolfinx_impact/search/node_tracker/SkipBound.h>
#include <random>

using Catch::Approx;
using namespace dolfinx_impact::search;
using dolfinx_impact::dot;
using dolfinx_impact::surface::FacetElement;
using dolfinx_impact::surface::Facets;
using dolfinx_impact::surface::FacetShape;

namespace
{
constexpr double never = std::numeric_limits<double>::infinity();

/// A square of n x n quadrilaterals of size one at a height, with normals up or down.
Facets square(int n, double height, bool up, std::int32_t first_node)
{
  Facets out;
  out.gdim = 3;
  out.displacement = out.geometry = FacetElement{FacetShape::quadrilateral, 1};
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
    {
      for (int b : {0, 1})
        for (int a : {0, 1})
        {
          out.nodes.push_back(first_node + (j + b) * (n + 1) + i + a);
          out.X.insert(out.X.end(), {double(i + a), double(j + b), height});
        }
      out.orientation.push_back(up ? 1 : -1);
      out.id.push_back(8 * (j * n + i));
    }
  out.x = out.X;
  return out;
}

/// A master of 3 x 3 facets and, above it, a slave of 2 x 2 facets. Of the slave's 9 nodes, 7 are followed.
struct Model
{
  static constexpr int gdim = 3, num_masters = 16, num_slaves = 9, num = num_masters + num_slaves;
  static constexpr double height = 0.8;
  Facets master = square(3, 0.0, true, 0), slave = square(2, height, false, num_masters);
  std::vector<std::int32_t> nodes{16, 17, 18, 19, 20, 22, 24};
  std::vector<double> X, u, du;
  std::mt19937 random{1};

  Model() : u(gdim * num, 0.0), du(gdim * num, 0.0)
  {
    for (std::int32_t node : nodes)
      for (int c = 0; c < gdim; ++c)
        X.push_back(reference(node)[c]);
  }
  const double* reference(std::int32_t node) const
  {
    const Facets& facets = node < num_masters ? master : slave;
    const auto at = std::find(facets.nodes.begin(), facets.nodes.end(), node);
    return facets.X.data() + gdim * (at - facets.nodes.begin());
  }
  double uniform(double size) { return std::uniform_real_distribution<double>(-size, size)(random); }
  /// All nodes fly together, and each moves on its own.
  void move(double together, double alone)
  {
    const double common[3] = {together, -0.5 * together, 0.3 * together};
    for (std::size_t k = 0; k < u.size(); ++k)
    {
      du[k] = common[k % gdim] + uniform(alone);
      u[k] += du[k];
    }
  }
  double position(std::int32_t node, int c) const { return reference(node)[c] + u[gdim * node + c]; }
  double distance(const TrackedSurface& surface, std::int32_t node, std::int32_t facet) const
  {
    double corners[12], x[3];
    surface.positions(facet, {u.data()}, corners);
    for (int c = 0; c < gdim; ++c)
      x[c] = position(node, c);
    return surface.project(facet, corners, x, nullptr).distance;
  }
};
} // namespace

TEST_CASE("facets move with their displacement, whatever the degrees of geometry and field")
{
  // The arc y = x (2 - x) / 4 from (0, 0) to (2, 0), or its chord; nodes of an interval: both ends, then the middle.
  const std::vector<double> arc{0.0, 0.0, 2.0, 0.0, 1.0, 0.25};
  for (int geometry : {1, 2})
    for (int field = 1; field <= geometry; ++field) // make_surface takes no lower degree for the geometry
    {
      Facets facets;
      facets.gdim = 2;
      facets.geometry = FacetElement{FacetShape::interval, geometry};
      facets.displacement = FacetElement{FacetShape::interval, field};
      facets.X.assign(arc.begin(), arc.begin() + 2 * (geometry + 1));
      facets.x = facets.X;
      facets.nodes = field == 1 ? std::vector<std::int32_t>{1, 0} : std::vector<std::int32_t>{1, 0, 2};
      facets.orientation = {1};
      facets.id = {0};
      const std::vector<double> u{0.5, 0.125, -0.25, 1.0, 3.0, -2.0}; // of the nodes 0, 1, 2
      TrackedSurface surface;
      surface.reset(facets);
      std::vector<double> x(facets.X.size());
      surface.positions(0, {u.data()}, x.data());
      for (int c = 0; c < 2; ++c)
      {
        CHECK(x[c] == Approx(arc[c] + u[2 + c]));
        CHECK(x[2 + c] == Approx(arc[2 + c] + u[c]));
        if (geometry == 2)
          CHECK(x[4 + c] == Approx(arc[4 + c] + (field == 2 ? u[4 + c] : (u[c] + u[2 + c]) / 2)));
      }
    }
}

TEST_CASE("relative motion bounds changes of distances, whatever the common translation")
{
  Model m;
  TrackedSurface surface;
  surface.reset(m.master);
  RelativeMotion motion(Model::gdim, m.X);
  motion.reset(m.nodes, std::vector<std::int32_t>{21, 23}, surface);
  struct Past
  {
    std::vector<double> paths, distances;
  };
  std::vector<Past> past;
  const double rounding = 1e-12;
  std::vector<double> fitted, renewed;
  double least_step = never, most_path = 0.0;
  for (int step = 0; step < 60; ++step)
  {
    m.move(0.7, step % 7 ? 0.01 : 0.05);
    motion.advance(m.u.data(), m.du.data(), surface);
    CHECK(motion.restarted() == (step == 0));
    for (std::size_t k = 0; k < surface.nodes().size(); ++k)
      CHECK(surface.node_data()[k].x[1] == m.position(surface.nodes()[k], 1));
    if (step == 0 || step == 20)
    {
      motion.renew(m.u.data(), surface);
      renewed = m.u;
    }
    if (step == 0 || step == 30)
    {
      motion.fit();
      fitted = m.u;
    }
    // Distances of all nodes and facets at all times.
    Past now;
    for (std::size_t i = 0; i < motion.size(); ++i)
    {
      now.paths.push_back(motion.path(i));
      for (std::int32_t f = 0; f < 9; ++f)
        now.distances.push_back(m.distance(surface, m.nodes[i], f));
    }
    for (const Past& then : past)
      for (std::size_t k = 0; k < now.distances.size(); ++k)
        if (std::abs(now.distances[k] - then.distances[k]) > now.paths[k / 9] - then.paths[k / 9] + rounding)
          FAIL("a distance has changed by more than the path");
    if (step > 0)
    {
      for (std::size_t k = 0; k < now.distances.size(); ++k)
        if (std::abs(now.distances[k] - past.back().distances[k]) > motion.step() + rounding)
          FAIL("a distance has changed by more than the step");
      least_step = std::min(least_step, motion.step());
    }
    past.push_back(now);
    most_path = *std::max_element(now.paths.begin(), now.paths.end());
    // The surface, the translation left out, since the tree was fitted.
    for (std::int32_t node = 0; node < Model::num_masters; ++node)
    {
      double d[3];
      for (int c = 0; c < 3; ++c)
        d[c] = m.u[3 * node + c] - fitted[3 * node + c] - motion.shift()[c];
      CHECK(std::sqrt(dot(d, d, 3)) <= motion.since_fit() + rounding);
    }
    // Two nodes of a side move against each other by no more than twice its deformation.
    for (std::int32_t a = 0; a < Model::num; ++a)
      for (std::int32_t b = 0; b < a; ++b)
      {
        if ((a < Model::num_masters) != (b < Model::num_masters))
          continue;
        double d[3];
        for (int c = 0; c < 3; ++c)
          d[c] = m.u[3 * a + c] - renewed[3 * a + c] - (m.u[3 * b + c] - renewed[3 * b + c]);
        const double deformation = a < Model::num_masters ? motion.master_deformation() : motion.slave_deformation();
        if (std::sqrt(dot(d, d, 3)) > 2 * deformation + rounding)
          FAIL("a side has deformed by more than its bound");
      }
  }
  // The bodies have flown by some forty lengths: what they have in common is not counted.
  CHECK(least_step < 0.1);
  CHECK(most_path < 10.0);
  SECTION("the first step after a reset goes by the increments")
  {
    motion.reset(m.nodes, std::vector<std::int32_t>{21, 23}, surface);
    m.move(0.7, 0.01);
    motion.advance(m.u.data(), m.du.data(), surface);
    CHECK(motion.restarted());
    CHECK(motion.path(3) == 0.0);
    CHECK(motion.step() < 0.05);
    for (std::size_t k = 0; k < past.back().distances.size(); ++k)
      CHECK(std::abs(m.distance(surface, m.nodes[k / 9], k % 9) - past.back().distances[k]) <=
            motion.step() + rounding);
  }
}

TEST_CASE("renewals are asked for only once something has deformed")
{
  Model m;
  TrackedSurface surface;
  surface.reset(m.master);
  RelativeMotion motion(Model::gdim, m.X);
  motion.reset(m.nodes, {}, surface);
  motion.advance(m.u.data(), m.du.data(), surface);
  motion.renew(m.u.data(), surface);
  motion.request_renewal();
  CHECK_FALSE(motion.renewal_due());
  m.move(0.0, 0.1);
  motion.advance(m.u.data(), m.du.data(), surface);
  CHECK(motion.deformation() > 0.1);
  motion.request_renewal();
  CHECK(motion.renewal_due());
  motion.renew(m.u.data(), surface);
  CHECK_FALSE(motion.renewal_due());
  CHECK(motion.deformation() == 0.0);
}

TEST_CASE("stored normals of the slave never give a wrong answer, and are seldom evaluated")
{
  Model m;
  TrackedSurface surface;
  surface.reset(m.master);
  SlaveNormals normals(Model::gdim, m.nodes.size());
  normals.reset(m.slave, m.nodes);
  CHECK(std::vector<std::int32_t>(normals.others().begin(), normals.others().end()) ==
        std::vector<std::int32_t>{21, 23});
  RelativeMotion motion(Model::gdim, m.X);
  motion.reset(m.nodes, normals.others(), surface);
  int asked = 0, facing = 0, renewals = 0;
  for (int step = 0; step < 300; ++step)
  {
    m.move(0.2, 1e-2);
    motion.advance(m.u.data(), m.du.data(), surface);
    if (step == 0 || motion.renewal_due())
    {
      motion.renew(m.u.data(), surface);
      normals.renew();
      ++renewals;
    }
    for (std::size_t i = 0; i < m.nodes.size(); ++i)
    {
      double n[3], expected[3];
      for (double& component : n)
        component = m.uniform(1.0);
      const double length = std::sqrt(dot(n, n, 3));
      for (double& component : n)
        component /= length;
      normals.evaluate(i, {m.u.data()}, expected);
      const bool faces = normals.faces(i, n, m.u.data(), motion);
      if (faces != (dot(n, expected, 3) < -right_angle))
        FAIL("a stored normal gave another answer than that of the present configuration");
      double d[3];
      for (int c = 0; c < 3; ++c)
        d[c] = normals.stored(i)[c] - expected[c];
      if (const double bound = normals.rotation(i, motion); bound <= NormalRotation::most)
        CHECK(std::sqrt(dot(d, d, 3)) <= bound + 1e-12);
      ++asked;
      facing += faces;
    }
  }
  CHECK(facing > asked / 4);
  CHECK(renewals > 1);
  CHECK(normals.evaluations() < asked / 2);
}

TEST_CASE("near facets know up to which distance none is missing")
{
  std::mt19937 random(2);
  for (int num : {5, 60, 300})
  {
    NearFacets near;
    std::vector<double> distances;
    for (int f = 0; f < num; ++f)
    {
      distances.push_back(std::uniform_real_distribution<double>(0.0, 1.0)(random));
      near.add(f, distances.back());
    }
    const int most = 24;
    const double complete = 0.9;
    near.select(most, complete, 1e-9);
    CHECK(near.complete() <= complete);
    const int size = std::min(most, near.size());
    for (int f = 0; f < num; ++f)
    {
      const bool listed = std::any_of(near.begin(), near.begin() + size, [&](const NearFacets::Facet& at)
                                      { return at.facet == f && at.distance == distances[f]; });
      CHECK((listed || distances[f] >= near.complete()));
    }
    CHECK(size >=
          std::min(most, int(std::count_if(distances.begin(), distances.end(), [&](double d) { return d < 0.9; }))));
  }
}

TEST_CASE("a list of candidates has the nearest facet until it expires")
{
  // Distances of 60 facets from one node change at random, by no more than the path grows.
  std::mt19937 random(3);
  const auto uniform = [&](double low, double high)
  { return std::uniform_real_distribution<double>(low, high)(random); };
  CandidateLists lists(2);
  CHECK(lists.expired(0, 0.0));
  std::vector<double> distances(60);
  for (double& d : distances)
    d = uniform(0.1, 3.0);
  double path = 0.0;
  int fills = 0, alone = 0;
  const int steps = 2000;
  for (int step = 0; step < steps; ++step)
  {
    const double grown = uniform(0.0, 0.01);
    path += grown;
    for (double& d : distances)
      d = std::max(0.0, d + uniform(-grown, grown));
    const std::int32_t nearest = std::int32_t(std::min_element(distances.begin(), distances.end()) - distances.begin());
    if (lists.expired(1, path))
    {
      NearFacets near;
      for (int f = 0; f < int(distances.size()); ++f)
        near.add(f, distances[f]);
      near.select(CandidateLists::max_facets, 2.0, 0.0);
      lists.fill(1, near, nearest, path, 0.5 * (near.complete() - distances[nearest]));
      CHECK_FALSE(lists.expired(1, path));
      ++fills;
    }
    CHECK(lists.expired(0, path)); // that of another node
    bool listed = false;
    std::int32_t last = -1;
    for (CandidateLists::Entry& entry : lists.entries(1))
    {
      if (entry.bound - path > distances[entry.facet])
        FAIL("a listed facet is nearer than its bound tells");
      CHECK(entry.facet > last);
      last = entry.facet;
      listed = listed || entry.facet == nearest;
    }
    if (!listed)
      FAIL("the nearest facet is not listed");
    // If no other facet can be nearer, the winner is the nearest.
    const std::int32_t winner = lists.winner(1);
    if (lists.others(1) - path > distances[winner])
    {
      ++alone;
      CHECK(winner == nearest);
      continue;
    }
    for (CandidateLists::Entry& entry : lists.entries(1))
      CandidateLists::set_distance(entry, distances[entry.facet], path);
    lists.set_winner(1, nearest);
  }
  CHECK(fills > 5);
  CHECK(fills < steps / 10);
  CHECK(alone > steps / 10);
  lists.clear();
  CHECK(lists.expired(1, path));
  CHECK(lists.winner(1) == -1);
}

TEST_CASE("a node is active before it can be in contact")
{
  // Five nodes at random distances approach at random; a node is skipped until its path has used the distance up.
  std::mt19937 random(4);
  const auto uniform = [&](double high) { return std::uniform_real_distribution<double>(0.0, high)(random); };
  const std::size_t num = 5;
  SkipSchedule schedule(num);
  std::vector<double> gaps, paths(num, 0.0);
  std::vector<bool> was_active(num, false);
  for (std::size_t i = 0; i < num; ++i)
  {
    CHECK_FALSE(schedule.skipped(i, 0.0, 0.0));
    gaps.push_back(1.0 + uniform(1.0));
    schedule.skip_until(i, gaps[i]);
  }
  for (int step = 0; step < 200; ++step)
  {
    const double largest = 0.05;
    for (std::size_t i = 0; i < num; ++i)
    {
      const double motion = uniform(largest);
      paths[i] += motion;
      gaps[i] -= motion; // straight towards the surface
      const bool skipped = schedule.skipped(i, paths[i], largest);
      CHECK((gaps[i] > 0.5 * largest || !skipped));
      CHECK((skipped || gaps[i] < largest)); // and not much earlier
      was_active[i] = was_active[i] || !skipped;
    }
  }
  CHECK(std::count(was_active.begin(), was_active.end(), true) == std::ptrdiff_t(num));
}

TEST_CASE("deformations activate nodes in time, across renewals")
{
  SkipSchedule schedule(3);
  schedule.activate_all();
  CHECK_FALSE(schedule.deformed(1e9));
  const auto skip = [&](std::size_t i, double deformation)
  {
    schedule.skip_until(i, 1e9);
    schedule.skip_until_deformed(i, deformation);
  };
  const auto skipped = [&](std::size_t i) { return schedule.skipped(i, 0.0, 0.0); };
  skip(0, 0.8);
  skip(1, 0.55);
  skip(2, 2.0);
  CHECK_FALSE(schedule.deformed(0.5));
  SECTION("without a renewal")
  {
    CHECK(schedule.deformed(0.6));
    schedule.activate_deformed(0.6, false, 0.1);
    CHECK((skipped(0) && !skipped(1) && skipped(2)));
    CHECK_FALSE(schedule.deformed(0.8));
    CHECK(schedule.deformed(0.81));
    schedule.activate_deformed(0.81, false, 0.1);
    CHECK((!skipped(0) && skipped(2)));
  }
  SECTION("what is left counts from a renewal on, and a limit within the step counts as reached")
  {
    schedule.activate_deformed(0.5, true, 0.1);
    CHECK((skipped(0) && !skipped(1) && skipped(2)));
    CHECK_FALSE(schedule.deformed(0.3));
    CHECK(schedule.deformed(0.31));
    schedule.activate_deformed(0.31, false, 0.1);
    CHECK((!skipped(0) && skipped(2)));
  }
  SECTION("a node that has been activated has no limit any more")
  {
    schedule.activate(1);
    CHECK_FALSE(skipped(1));
    schedule.activate_deformed(0.6, false, 0.1);
    CHECK_FALSE(schedule.deformed(0.7));
    schedule.activate_all();
    CHECK((!skipped(0) && !skipped(2)));
  }
}

TEST_CASE("how long a node may be skipped")
{
  const Model m;
  TrackedSurface surface;
  surface.reset(m.master);
  const double down[3] = {0.0, 0.0, -1.0}, up[3] = {0.0, 0.0, 1.0}, x[3] = {1.4, 1.6, 0.3};
  const std::int32_t middle = 4;
  double corners[12];
  surface.positions(middle, {m.u.data()}, corners);
  const FacetProjection foot = surface.project(middle, corners, x, nullptr);
  const Projection at = surface.closest_point(x, middle, up, foot, {m.u.data()}, std::vector<std::int32_t>{middle});
  CHECK(at.gap == Approx(0.3).epsilon(1e-14));
  SECTION("above a plane, for the distance")
  {
    SkipBound bound(surface, m.u.data(), x, down, 0.0, 1.0, at.clearance);
    CHECK(bound.set_nearest(at));
    for (std::int32_t f = 0; f < 9; ++f)
      if (f != middle)
        bound.add(f);
    CHECK(bound.path() == Approx(0.3).epsilon(1e-14));
    // And until the plane could have turned away.
    CHECK(bound.rotates());
    CHECK(bound.deformation(0.0) > 0.0);
    CHECK(bound.deformation(1e3) == Approx(0.5e-3).epsilon(1e-12));
  }
  SECTION("not at all if the normal is uncertain")
  {
    SkipBound bound(surface, m.u.data(), x, down, 0.95, 1.0, at.clearance);
    CHECK_FALSE(bound.set_nearest(at));
  }
  SECTION("behind a plane that faces it, until another facet could be the nearest")
  {
    const double below[3] = {1.4, 1.6, -0.3};
    SkipBound bound(surface, m.u.data(), below, down, 0.0, 0.2, 1.0);
    bound.add(middle);
    CHECK(bound.path() == Approx(0.1).epsilon(1e-13));
    CHECK_FALSE(bound.rotates());
  }
  SECTION("behind a plane that does not face it, until it could turn")
  {
    const double below[3] = {1.4, 1.6, -0.3};
    SkipBound bound(surface, m.u.data(), below, up, 0.0, 0.2, 1.0);
    bound.add(middle);
    CHECK(bound.path() == 1.0);
    CHECK(bound.rotates());
  }
}

TEST_CASE("a tracker finds what a full search finds, with few searches")
{
  Model m;
  const double reach = 1.0;
  NodeTracker tracker(Model::gdim, m.X);
  tracker.reset(m.master, m.nodes, m.slave, reach);
  Facets moved = m.master;
  int located = 0, touching = 0;
  for (int step = 0; step < 400; ++step)
  {
    m.move(0.1, 1e-3);
    // The slave sinks to the master, and leaves it.
    for (std::int32_t node = Model::num_masters; node < Model::num; ++node)
    {
      const double sinks = step < 200 ? -0.0145 * std::cos(3.1416 * step / 200) : 0.0;
      m.du[3 * node + 2] += sinks;
      m.u[3 * node + 2] += sinks;
    }
    tracker.advance(m.u.data(), m.du.data());
    dolfinx_impact::surface::move(moved, m.u.data());
    const SurfaceSearch search(moved);
    for (std::size_t i = 0; i < tracker.size(); ++i)
    {
      double x[3], normal[3] = {0.0, 0.0, -1.0};
      for (int c = 0; c < 3; ++c)
        x[c] = m.position(m.nodes[i], c);
      const Projection expected = search.project(x, normal, reach);
      if (tracker.skipped(i))
      {
        CHECK(expected.gap > 0.5 * tracker.step());
        continue;
      }
      const Projection at = tracker.locate(i, m.u.data(), m.du.data());
      ++located;
      if (at.rim == Projection::Rim::no)
      {
        CHECK(at.facet == expected.facet);
        if (at.facet >= 0)
          CHECK(at.gap == Approx(expected.gap).margin(1e-13));
      }
      if (at.gap < 0.0)
      {
        tracker.track(i, at);
        ++touching;
      }
      else
        tracker.release(i, at, m.u.data());
    }
  }
  const int all = 400 * int(tracker.size());
  CHECK(located < all);
  CHECK(touching > all / 20);
  CHECK(tracker.counters().nodes == located);
  CHECK(tracker.counters().queries < located / 4);
}
