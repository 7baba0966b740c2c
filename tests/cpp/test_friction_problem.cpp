// SPDX-License-Identifier: MIT
// Contact and friction of nodes against their slip velocities: one node by hand, many nodes by the laws themselves.
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <dolfinx_impact/rolling/SteadyFriction.h>
#include <dolfinx_impact/rolling/TorqueOfCandidates.h>
#include <random>

namespace
{
namespace rolling = dolfinx_impact::rolling;

constexpr double friction = 0.3, stiffness = 50.0, drift = 0.02, overlap = 0.01; // drift: velocity by force

/// One node in space with its normal along an axis, whose answers are not coupled.
struct OneNode
{
  int normal;
  rolling::FrictionProblem problem;

  explicit OneNode(int axis) : normal(axis), problem(make(axis)) {}

  static rolling::FrictionProblem make(int axis)
  {
    rolling::CandidateNodes nodes{3, std::vector<double>(9, 0.0), {friction}, {1}, {0, 0, 0}};
    rolling::Compliance compliance{std::vector<double>(9, 0.0), std::vector<double>(9, 0.0)};
    for (int a = 0; a < 3; ++a)
    {
      nodes.frames[a * 3 + (axis + a) % 3] = 1.0;
      compliance.jump[a * 3 + a] = 1.0 / stiffness;
      compliance.velocity[a * 3 + a] = drift;
    }
    return {nodes, compliance};
  }
  /// A state without forces: closed by the overlap, sliding with a velocity along the two tangents.
  rolling::LinearState state(double first, double second) const
  {
    rolling::LinearState out{{0.0, 0.0, 0.0}, {-overlap}, {0.0, 0.0, 0.0}};
    out.slip[(normal + 1) % 3] = first;
    out.slip[(normal + 2) % 3] = second;
    return out;
  }
};
} // namespace

TEST_CASE("a node that can be stopped sticks, another one slips", "[rolling]")
{
  const int axis = GENERATE(0, 1, 2);
  const OneNode node(axis);
  const double pressed = stiffness * overlap, limit = friction * pressed;
  for (const double speed : {0.5 * drift * limit, 20.0 * drift * limit})
  {
    const rolling::FrictionProblem::Solution found = node.problem.solve(node.state(0.6 * speed, -0.8 * speed));
    CHECK(found.fault == "");
    CHECK(found.forces[axis] == Catch::Approx(pressed).epsilon(1e-12));
    const double size = std::min(limit, speed / drift); // against the slip
    CHECK(found.forces[(axis + 1) % 3] == Catch::Approx(-0.6 * size).epsilon(1e-10));
    CHECK(found.forces[(axis + 2) % 3] == Catch::Approx(0.8 * size).epsilon(1e-10));
  }
}

TEST_CASE("a node that is open, or carries nothing, has no force", "[rolling]")
{
  const OneNode node(1);
  rolling::LinearState open = node.state(1.0, 0.0);
  open.gap[0] = 1e-3;
  for (double f : node.problem.solve(open).forces)
    CHECK(f == 0.0);
}

TEST_CASE("many coupled nodes obey contact and Coulomb's law", "[rolling]")
{
  const int g = GENERATE(2, 3);
  const std::size_t n = 12, size = n * g;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  // Compliances: a diagonal, and a symmetric part that couples neighbours, smaller than it; velocities lie upstream.
  rolling::Compliance c{std::vector<double>(size * size, 0.0), std::vector<double>(size * size, 0.0)};
  for (std::size_t i = 0; i < size; ++i)
    for (std::size_t j = 0; j <= i; ++j)
    {
      c.jump[i * size + j] = c.jump[j * size + i] =
          (i == j) / stiffness + 0.2 / stiffness / double(1 + (i - j) * (i - j));
      c.velocity[i * size + j] = (i == j) * drift - (i == j + g) * 0.7 * drift;
    }
  rolling::CandidateNodes nodes{
      g, {}, std::vector<double>(n, friction), std::vector<std::int8_t>(n, 1), std::vector<std::int8_t>(size, 0)};
  rolling::LinearState state{std::vector<double>(size, 0.0), {}, std::vector<double>(size, 0.0)};
  for (std::size_t i = 0; i < n; ++i)
  {
    for (int a = 0; a < g; ++a)
      for (int b = 0; b < g; ++b)
        nodes.frames.push_back(a == b);
    state.gap.push_back(overlap * any(random));
    for (int a = 1; a < g; ++a)
      state.slip[i * g + a] = 0.3 * drift * friction * stiffness * overlap * (1.0 + any(random));
  }
  const rolling::FrictionProblem::Solution found = rolling::FrictionProblem(nodes, c).solve(state);
  REQUIRE(found.fault == "");
  int open = 0, stick = 0, slide = 0;
  for (std::size_t i = 0; i < n; ++i)
  {
    double gap = state.gap[i], slip[2] = {0.0, 0.0}, moving = 0.0, force = 0.0;
    for (std::size_t j = 0; j < size; ++j)
      gap += c.jump[i * g * size + j] * found.forces[j];
    for (int a = 1; a < g; ++a)
    {
      slip[a - 1] = state.slip[i * g + a];
      for (std::size_t j = 0; j < size; ++j)
        slip[a - 1] += c.velocity[(i * g + a) * size + j] * found.forces[j];
      moving += slip[a - 1] * slip[a - 1];
      force += found.forces[i * g + a] * found.forces[i * g + a];
    }
    moving = std::sqrt(moving);
    force = std::sqrt(force);
    const double pressed = found.forces[i * g], unit = drift * stiffness * overlap;
    CHECK(pressed >= 0.0);
    CHECK(gap > -1e-11 * overlap);
    CHECK(force <= friction * pressed * (1.0 + 1e-10));
    if (pressed == 0.0)
      ++open;
    else
    {
      CHECK(std::abs(gap) < 1e-10 * overlap);
      if (moving > 1e-9 * unit)
      {
        ++slide;
        CHECK(force == Catch::Approx(friction * pressed).epsilon(1e-9));
        for (int a = 1; a < g; ++a) // against the slip
          CHECK(found.forces[i * g + a] * moving == Catch::Approx(-force * slip[a - 1]).margin(1e-9 * force * moving));
      }
      else
        ++stick;
    }
  }
  CHECK(open > 0);
  CHECK(slide > 0);
  CHECK(stick > 0);
}

TEST_CASE("the spin at which a torque is reached, and torques beyond friction", "[rolling]")
{
  const OneNode node(1);
  const double pressed = stiffness * overlap, limit = friction * pressed, radius = 2.0, omega = 1.0;
  rolling::TorqueOfCandidates torque;
  torque.row = {0.0, 0.0, 0.0};
  torque.row[2] = -radius; // of the force along the first tangent, which acts against the slip
  torque.slope = {{0.0, 0.0, 0.0}, {0.0}, {0.0, 0.0, radius}};
  torque.speed = radius * omega;
  // Sticking: the force is -radius change/drift, the torque radius^2 change/drift.
  torque.wanted = 0.5 * limit * radius;
  const rolling::TorqueOfCandidates::Solution found = torque.solve(node.problem, node.state(0.0, 0.0));
  CHECK(found.fault == "");
  CHECK(found.change == Catch::Approx(0.5 * limit * drift / radius).epsilon(1e-10));
  CHECK(found.forces[2] == Catch::Approx(-0.5 * limit).epsilon(1e-10));
  torque.wanted = 1.01 * limit * radius;
  CHECK(torque.solve(node.problem, node.state(0.0, 0.0)).fault == rolling::out_of_reach);
  rolling::LinearState open = node.state(0.0, 0.0);
  open.gap[0] = 1e-3;
  CHECK(torque.solve(node.problem, open).fault == rolling::no_friction);
}

TEST_CASE("tangents are orthonormal and follow what they are told", "[rolling]")
{
  const double s = std::sqrt(0.5);
  const std::vector<std::int8_t> free{0, 0, 0}, held{0, 0, 1};
  const std::vector<double> normal{s, s, 0.0}, along{s, -s, 0.0};
  const auto dot = [](const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  for (const std::vector<double>& first : {along, normal, std::vector<double>{0.0, 0.0, 0.0}})
  {
    const std::vector<double> t = rolling::tangents(normal, first, free);
    CHECK(dot(&t[0], normal.data()) == Catch::Approx(0.0).margin(1e-15));
    CHECK(dot(&t[3], normal.data()) == Catch::Approx(0.0).margin(1e-15));
    CHECK(dot(&t[0], &t[3]) == Catch::Approx(0.0).margin(1e-15));
    CHECK(dot(&t[0], &t[0]) == Catch::Approx(1.0));
    CHECK(dot(&t[3], &t[3]) == Catch::Approx(1.0));
  }
  CHECK(dot(rolling::tangents(normal, along, free).data(), along.data()) == Catch::Approx(1.0));
  CHECK(std::abs(rolling::tangents(normal, along, held)[2]) == Catch::Approx(1.0)); // a plane of symmetry across z
  CHECK(rolling::tangents(std::vector<double>{0.6, 0.8}, std::vector<double>{1.0, 0.0},
                          std::vector<std::int8_t>{0, 0}) == std::vector<double>{-0.8, 0.6});
}
