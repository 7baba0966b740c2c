// SPDX-License-Identifier: MIT
// Forces that give back the moment which a contact force and its reaction leave, on facets of every kind.
#include <array>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <dolfinx_impact/enforcement/node_to_surface/MomentCorrection.h>
#include <random>
#include <vector>

using Catch::Approx;
using dolfinx_impact::enforcement::MomentCorrection;

namespace
{
/// A facet of D dimensions with random nodes, a slave node beside it, a contact force: the corrections must have no
/// resultant, and together with the force and its reaction no moment.
template <int D>
void check_balance(int num, std::mt19937& generator)
{
  std::uniform_real_distribution<double> random(-1.0, 1.0);
  std::vector<double> nodes(num * D), phi(num), r(num * D), slave(D), f(D);
  for (auto* values : {&nodes, &slave, &f})
    for (double& value : *values)
      value = random(generator);
  double sum = 0.0;
  for (double& value : phi)
    sum += value = 0.1 + std::abs(random(generator));
  for (double& value : phi)
    value /= sum;
  MomentCorrection correction;
  correction.set<D>(num, [&](int j, int c) { return nodes[j * D + c]; }, phi.data(), slave.data(), r.data());
  std::vector<double> forces(num * D, 0.0);
  correction.forces<D>(num, r.data(), f.data(), [&](int j, int c, double value) { forces[j * D + c] += value; });

  std::array<double, 3> resultant{}, moment{};
  const auto act = [&](const double* x, const double* force)
  {
    const double X[3] = {x[0], x[1], D == 3 ? x[2] : 0.0}, F[3] = {force[0], force[1], D == 3 ? force[2] : 0.0};
    for (int c = 0; c < 3; ++c)
    {
      resultant[c] += F[c];
      moment[c] += X[(c + 1) % 3] * F[(c + 2) % 3] - X[(c + 2) % 3] * F[(c + 1) % 3];
    }
  };
  act(slave.data(), f.data());
  double largest = 0.0;
  for (int j = 0; j < num; ++j)
  {
    std::vector<double> force(D);
    for (int c = 0; c < D; ++c)
    {
      force[c] = forces[j * D + c] - phi[j] * f[c]; // the reaction goes to the master's nodes by their functions
      largest = std::max(largest, std::abs(force[c]));
    }
    act(&nodes[j * D], force.data());
  }
  for (int c = 0; c < 3; ++c)
  {
    CHECK(resultant[c] == Approx(0.0).margin(1e-12 * largest));
    CHECK(moment[c] == Approx(0.0).margin(1e-11 * largest));
  }
}
} // namespace

TEST_CASE("contact forces with their correction have neither resultant nor moment")
{
  std::mt19937 generator(7);
  for (int k = 0; k < 20; ++k)
  {
    for (const int num : {2, 3}) // edges of degree 1 and 2
      check_balance<2>(num, generator);
    for (const int num : {3, 4, 6, 9}) // triangles and quadrilaterals of degree 1 and 2
      check_balance<3>(num, generator);
  }
}

TEST_CASE("a node over the middle of a symmetric edge needs no correction for a normal force")
{
  const double nodes[4] = {-1.0, 0.0, 1.0, 0.0}, phi[2] = {0.5, 0.5}, slave[2] = {0.0, 0.25}, normal[2] = {0.0, 3.0};
  double r[4], total = 0.0;
  MomentCorrection correction;
  correction.set<2>(2, [&](int j, int c) { return nodes[2 * j + c]; }, phi, slave, r);
  correction.forces<2>(2, r, normal, [&](int, int, double value) { total += std::abs(value); });
  CHECK(total == 0.0);
  // A force along the edge, 3 at the lever 1/4: a couple of 3/8 at the lever 2.
  const double along[2] = {3.0, 0.0};
  std::array<double, 4> couple{};
  correction.forces<2>(2, r, along, [&](int j, int c, double value) { couple[2 * j + c] += value; });
  CHECK(couple[0] == 0.0);
  CHECK(std::abs(couple[3]) == Approx(0.375));
  CHECK(couple[1] == -couple[3]);
}
