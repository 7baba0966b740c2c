// SPDX-License-Identifier: MIT
// Contact without pairs: loops of corners, closest points of them, crossings of edges, springs.
#include <algorithm>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <cstdint>
#include <dolfinx_impact/enforcement/general/PairSpring.h>
#include <dolfinx_impact/search/general/FacetLoops.h>
#include <dolfinx_impact/search/general/closest_on_loop.h>
#include <dolfinx_impact/search/general/crossed_edges.h>
#include <random>
#include <vector>

using Catch::Approx;
using dolfinx_impact::enforcement::ContactEnergy;
using dolfinx_impact::enforcement::PairSpring;
using dolfinx_impact::search::FacetLoops;
namespace loop = dolfinx_impact::search::loop;
namespace surface = dolfinx_impact::surface;

namespace
{
/// The six faces of a cube as quadrilaterals in the order of a product, some of them turned inside out.
surface::Facets cube()
{
  surface::Facets out;
  out.displacement = out.geometry = {surface::FacetShape::quadrilateral, 1};
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
    {
      for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i)
        {
          const int at[3] = {side, i, j}; // along axis, axis + 1, axis + 2
          int place[3];
          for (int c = 0; c < 3; ++c)
            place[(axis + c) % 3] = at[c];
          out.nodes.push_back(place[0] + 2 * place[1] + 4 * place[2]);
          for (const int c : place)
            out.X.push_back(c);
        }
      out.orientation.push_back(std::int8_t(side == 1 ? 1 : -1)); // i x j points along the axis
      out.id.push_back(10 * axis + side);
    }
  out.x = out.X;
  return out;
}
} // namespace

TEST_CASE("loops of a cube are closed and run counter-clockwise from outside", "[general]")
{
  const FacetLoops loops(cube(), 8);
  CHECK(loops.size() == 6);
  CHECK(loops.num_corners() == 4);
  CHECK(loops.edges().size() == 12);
  for (std::size_t f = 0; f < loops.size(); ++f)
  {
    double corners[4][3], normal[3], outward = 0.0;
    for (int k = 0; k < 4; ++k)
    {
      CHECK(loops.neighbour(f, k) >= 0);
      const std::int32_t node = loops.corners(f)[k];
      CHECK(loops.corner_of(f, node) == k);
      for (int c = 0; c < 3; ++c)
        corners[k][c] = (node >> c) & 1;
    }
    for (int k = 0; k < 4; ++k)
    {
      loop::side_normal(corners, 4, k, normal);
      outward = 0.0;
      for (int c = 0; c < 3; ++c)
        outward += normal[c] * (corners[k][c] - 0.5);
      CHECK(outward == Approx(0.5));
    }
  }
  for (std::int32_t node = 0; node < 8; ++node)
    CHECK(loops.at_node(node).size() == 3);
  for (const auto& edge : loops.edges())
  {
    CHECK(edge.id / 4 == std::min(loops.id(edge.facets[0]), loops.id(edge.facets[1])));
    CHECK(loops.corners(edge.facets[0])[edge.sides[0]] == edge.nodes[0]);
    CHECK(loops.corners(edge.facets[1])[edge.sides[1]] == edge.nodes[1]); // the other way round
  }
  surface::Facets curved = cube();
  curved.geometry.degree = 2;
  CHECK_THROWS_AS(FacetLoops(curved, 8), std::invalid_argument);
}

TEST_CASE("closest points of facets are those of a dense search", "[general]")
{
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> random(-1.0, 1.0);
  for (int num : {3, 4})
    for (int trial = 0; trial < 40; ++trial)
    {
      double corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, x[3];
      for (auto& corner : corners)
        for (double& value : corner)
          value += 0.2 * random(generator);
      for (double& value : x)
        value = 1.5 * random(generator);
      const loop::Closest<3> found = loop::closest(corners, num, x);
      double centre[3] = {}, best = 1e9;
      for (int k = 0; k < num; ++k)
        for (int c = 0; c < 3; ++c)
          centre[c] += corners[k][c] / num;
      constexpr int fine = 60;
      for (int k = 0; k < num; ++k)
        for (int i = 0; i <= fine; ++i)
          for (int j = 0; j <= fine - i; ++j)
          {
            double squared = 0.0;
            for (int c = 0; c < 3; ++c)
            {
              const double a = corners[k][c], b = corners[(k + 1) % num][c];
              const double p = centre[c] + (a - centre[c]) * i / fine + (b - centre[c]) * j / fine;
              squared += (x[c] - p) * (x[c] - p);
            }
            best = std::min(best, squared);
          }
      CHECK(found.squared <= best * (1.0 + 1e-12));
      // No point of the facet is farther from a sampled one than its spacing.
      CHECK(std::sqrt(best) - std::sqrt(found.squared) < 2.0 / fine);
      double sum = 0.0;
      for (int c = 0; c < 3; ++c)
      {
        double place = 0.0;
        for (int k = 0; k < num; ++k)
          place += found.weights[k] * corners[k][c];
        CHECK(x[c] - place == Approx(found.away[c]).margin(1e-13));
      }
      for (const double w : found.weights)
        sum += w;
      CHECK(sum == Approx(1.0));
      if (found.flat) // the other point lies along the normal
        CHECK(std::abs(loop::dot<3>(found.away, found.normal)) == Approx(std::sqrt(found.squared)));
    }
}

TEST_CASE("closest points of segments in the plane", "[general]")
{
  const double corners[4][2] = {{0.0, 0.0}, {2.0, 0.0}};
  const double inside[2] = {0.5, -0.25}, beyond[2] = {2.5, 0.5};
  const loop::Closest<2> first = loop::closest(corners, 2, inside), second = loop::closest(corners, 2, beyond);
  CHECK((first.inside() && first.flat && first.weights[1] == Approx(0.25)));
  CHECK(loop::dot<2>(first.away, first.normal) == Approx(0.25)); // the body lies to the left of the direction
  CHECK((!second.inside() && second.corner == 1 && second.squared == Approx(0.5)));
}

TEST_CASE("edges cross where their common perpendicular parts the bodies", "[general]")
{
  // A ridge along x whose body is below, and one along y whose body is above.
  const double s = std::sqrt(0.5);
  const auto below = [s](double z) { return loop::EdgeAtPresent{{{-1, 0, z}, {1, 0, z}}, {{0, s, s}, {0, -s, s}}}; };
  const auto above = [s](double z) { return loop::EdgeAtPresent{{{0, -1, z}, {0, 1, z}}, {{s, 0, -s}, {-s, 0, -s}}}; };
  for (const double gap : {0.1, -0.1})
  {
    // The first facet of an edge has it from the first end to the second, on its left.
    loop::EdgeAtPresent a = below(0.0), b = above(gap);
    const auto on_left = [](loop::EdgeAtPresent& edge)
    {
      double t[3], into[3];
      for (int c = 0; c < 3; ++c)
        t[c] = edge.ends[1][c] - edge.ends[0][c];
      loop::cross(edge.normals[0], t, into);
      if (loop::dot<3>(into, edge.normals[1]) > 0.0)
        std::swap(edge.normals[0], edge.normals[1]);
    };
    on_left(a);
    on_left(b);
    const loop::Crossing at = loop::cross_edges(a, b);
    REQUIRE(at.valid);
    CHECK(at.gap == Approx(gap));
    CHECK(at.normal[2] == Approx(-1.0)); // out of the second body
    CHECK(at.at[0] == Approx(0.5));
    CHECK(at.at[1] == Approx(0.5));
    CHECK(std::sqrt(loop::squared_distance(a, b)) == Approx(std::abs(gap)));
    std::swap(a.normals[0], a.normals[1]); // a valley
    CHECK_FALSE(loop::cross_edges(a, b).valid);
    std::swap(a.normals[0], a.normals[1]);
    loop::EdgeAtPresent aside = b;
    for (auto& end : aside.ends)
      end[0] += 1.5;
    CHECK_FALSE(loop::cross_edges(a, aside).valid); // beyond the end of the first edge
    CHECK_FALSE(loop::cross_edges(a, a).valid);     // parallel
  }
}

TEST_CASE("a pair's spring accounts for the work of its forces", "[general]")
{
  // A mass that bounces and slides on a wall, with the normal turning from step to step.
  PairSpring spring;
  ContactEnergy energy;
  const double k = 100.0, mass = 1.0, dt = 0.02;
  double x[3] = {0.0, 0.0, 0.05}, v[3] = {0.3, 0.1, -1.0}, last[3] = {}, work = 0.0;
  bool has_closed = false;
  for (int step = 0; step < 60; ++step)
  {
    double du[3];
    for (int c = 0; c < 3; ++c)
    {
      du[c] = dt * v[c];
      x[c] += du[c];
      work += 0.5 * last[c] * du[c];
    }
    const double angle = 0.1 * std::sin(0.3 * step), n[3] = {std::sin(angle), 0.0, std::cos(angle)};
    const double closing = loop::dot<3>(n, du), gap = loop::dot<3>(n, x);
    spring.begin_at_rest(gap, closing, false);
    const auto out = spring.advance<3>({n, gap + spring.spring.offset, closing, du, du, 0.0}, k, 0.3, energy);
    energy.stored = 0.0;
    for (int c = 0; c < 3; ++c)
    {
      work += 0.5 * out.force[c] * du[c];
      last[c] = out.force[c];
      v[c] += dt * out.force[c] / mass;
    }
    has_closed |= spring.closed;
    const double squared = loop::dot<3>(spring.tangential, spring.tangential);
    const double stored = spring.closed ? spring.spring.stored() + 0.5 * squared / k : 0.0;
    // energy.normal is the work that normal forces have done on the bodies, beside what springs store.
    CHECK(work + stored - energy.normal + energy.friction == Approx(0.0).margin(1e-13));
    CHECK(std::sqrt(squared) <= 0.3 * spring.spring.force * (1.0 + 1e-9) + 1e-15);
  }
  CHECK(has_closed);
  CHECK_FALSE(spring.closed);
  CHECK(v[2] > 0.5); // it came back
  CHECK(energy.friction > 0.0);
}

TEST_CASE("a pair that is given up keeps nothing", "[general]")
{
  PairSpring spring;
  ContactEnergy energy;
  const double n[3] = {0.0, 0.0, 1.0}, du[3] = {0.0, 0.0, -0.1};
  spring.begin_at_rest(-0.1, -0.1, false);
  CHECK(spring.spring.offset == 0.0);
  spring.advance<3>({n, -0.1, -0.1, du, du, 0.0}, 10.0, 0.0, energy);
  REQUIRE(spring.closed);
  const double stored = spring.spring.stored();
  energy.stored = 0.0;
  spring.drop<3>(nullptr, 0.0, energy);
  CHECK_FALSE(spring.closed);
  CHECK(spring.spring.force == 0.0);
  CHECK(stored > 0.0);
  // An open pair that was behind already begins without force.
  spring.begin_at_rest(-0.3, -0.1, false);
  CHECK(spring.spring.offset == Approx(0.2));
  spring.begin_at_rest(-0.3, -0.1, true);
  CHECK(spring.spring.offset == 0.0);
}
