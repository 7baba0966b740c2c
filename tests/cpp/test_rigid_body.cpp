// SPDX-License-Identifier: MIT
// Rigid bodies: free motion against conservation laws and Euler's closed form of a top, motion under constant forces,
// components that are fixed, works and energies.
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <dolfinx_impact/integrators/RigidBody.h>
#include <stdexcept>

using Catch::Approx;
using namespace dolfinx_impact;
using integrators::RigidBody;
using integrators::RigidBodyOptions;

namespace
{
typedef std::array<double, 3> Triple;

RigidBodyOptions tumbling()
{
  RigidBodyOptions o;
  o.mass = 2.0;
  o.inertia = {2.0, 0.1, -0.2, 0.1, 1.3, 0.15, -0.2, 0.15, 0.9}; // three moments, axes along none of space
  o.centre = {0.5, -1.0, 2.0};
  o.velocity = {0.3, 0.0, -0.1};
  o.spin = {0.01, 1.0, 0.02}; // about the middle moment, nearly: unstable
  return o;
}

/// Largest relative change of the kinetic energy over free steps.
double tumbling_energy_error(double dt, int steps)
{
  RigidBody body(tumbling());
  const double start = body.kinetic_energy(0.0);
  double largest = 0.0;
  for (int k = 0; k < steps; ++k)
  {
    body.advance(dt, dt, k == 0);
    body.commit();
    largest = std::max(largest, std::abs(body.kinetic_energy(dt) / start - 1.0));
  }
  return largest;
}
} // namespace

TEST_CASE("a free body tumbles over 1e5 steps: momenta as they were, energy within a bound")
{
  RigidBody body(tumbling());
  const double dt = 0.05, start = body.kinetic_energy(0.0);
  const Triple before = body.angular_momentum(0.0);
  double largest = 0.0, least = 1.0;
  for (int k = 0; k < 100000; ++k)
  {
    body.advance(dt, dt, k == 0);
    body.commit();
    largest = std::max(largest, std::abs(body.kinetic_energy(dt) / start - 1.0));
    least = std::min(least, body.rotation()[4]);
  }
  CHECK(least < -0.9); // it has tumbled over
  CHECK(largest < 2e-5);
  for (int k = 0; k < 3; ++k)
  {
    CHECK(body.angular_momentum(dt)[k] == before[k]); // bit for bit: it is the variable
    CHECK(body.momentum(dt)[k] == 2.0 * tumbling().velocity[k]);
    CHECK(body.position()[k] == Approx(tumbling().centre[k] + 1e5 * dt * tumbling().velocity[k]).margin(1e-6));
  }
  // The quaternion is one of a rotation.
  const gap::Matrix3 R = body.rotation();
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
    {
      double product = 0.0;
      for (int c = 0; c < 3; ++c)
        product += R[3 * a + c] * R[3 * b + c];
      CHECK(product == Approx(double(a == b)).margin(1e-14));
    }
}

TEST_CASE("the energy error of a free body is of second order in the step")
{
  const double coarse = tumbling_energy_error(0.1, 2000), fine = tumbling_energy_error(0.05, 4000);
  CHECK(coarse / fine == Approx(4.0).epsilon(0.1));
}

TEST_CASE("a top turns as Euler's closed form says, whatever the step")
{
  RigidBodyOptions o;
  o.mass = 1.0;
  o.inertia = {1.2, 0.0, 0.0, 0.0, 1.2, 0.0, 0.0, 0.0, 2.0};
  o.spin = {0.3, 0.0, 1.5};
  RigidBody body(o);
  const double dt = 0.7;
  for (int k = 0; k < 50; ++k)
    body.advance(dt, dt, k == 0);
  // exp(t L/I1) exp(t (1/I3 - 1/I1) L3 e3); the axis of the body goes round L at the rate |L|/I1.
  const Triple L{1.2 * 0.3, 0.0, 2.0 * 1.5};
  const double size = std::hypot(L[0], L[2]), angle = 50 * dt * size / 1.2;
  const Triple n{L[0] / size, 0.0, L[2] / size};
  const Triple axis{n[2] * n[0] * (1.0 - std::cos(angle)), -n[0] * std::sin(angle),
                    std::cos(angle) + n[2] * n[2] * (1.0 - std::cos(angle))};
  for (int a = 0; a < 3; ++a)
    CHECK(body.rotation()[3 * a + 2] == Approx(axis[a]).margin(1e-12));
}

TEST_CASE("constant force and torque: exact parabola, work is what the energy gains")
{
  RigidBodyOptions o;
  o.mass = 4.0;
  o.inertia = {0.5, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.5};
  RigidBody body(o);
  body.set_loads({0.0, 0.0, -8.0}, {0.0, 1.0, 0.0});
  const double dt = 0.01;
  double last = 0.0;
  body.set_contact_forces({}, {});
  body.measure(0.5 * dt, true);
  const double start = body.energies().kinetic; // below zero by the square of half a step's velocity
  for (int k = 0; k < 100; ++k)
  {
    body.advance(dt, k == 0 ? 0.5 * dt : dt, k == 0);
    body.commit();
    body.set_contact_forces({}, {});
    last = dt;
  }
  CHECK(body.position()[2] == Approx(-1.0));
  CHECK(body.velocity(last)[2] == Approx(-2.0));
  CHECK(body.spin(last)[1] == Approx(2.0));
  body.measure(dt, false);
  CHECK(body.energies().kinetic - start == Approx(body.external_work()).epsilon(1e-12));
  CHECK(body.external_work() == Approx(0.5 * 4.0 * 4.0 + 0.5 * 0.5 * 4.0).epsilon(1e-3));
}

TEST_CASE("contact forces act on the body by their opposite, and by its torque")
{
  RigidBodyOptions o;
  o.mass = 1.0;
  o.inertia = gap::identity;
  RigidBody body(o);
  // A force f = (0, 0, 3) on a slave node at r = (2, 0, 0).
  gap::Matrix3 moment{};
  moment[3 * 2 + 0] = 3.0 * 2.0;
  body.set_contact_forces({0.0, 0.0, 3.0}, moment);
  CHECK(body.contact_force() == Triple{0.0, 0.0, -3.0});
  CHECK(body.contact_torque() == Triple{0.0, 6.0, 0.0}); // - r x f
  const double dt = 1e-3;
  body.advance(dt, 0.5 * dt, true);
  // The point that is at r now has moved by the increment and by the rotation.
  const gap::RigidMotion m = body.motion();
  const double z = m.increment[2] + m.turn[3 * 2 + 0] * 2.0;
  CHECK(z == Approx(0.5 * dt * dt * (-3.0 - 2.0 * 6.0)).epsilon(1e-6));
}

TEST_CASE("components that are fixed keep their velocity")
{
  RigidBodyOptions o = tumbling();
  o.fixed_velocity = {true, false, false};
  o.fixed_spin = {true, true, true};
  RigidBody driven(o);
  driven.set_contact_forces({1.0, 0.0, 0.0}, gap::identity);
  driven.set_loads({5.0, 1.0, 0.0}, {7.0, 0.0, 0.0});
  for (int k = 0; k < 10; ++k)
    driven.advance(0.1, 0.1, k == 0);
  CHECK(driven.velocity(0.1)[0] == 0.3);
  CHECK(driven.velocity(0.0)[1] == Approx(10 * 0.1 * 1.0 / 2.0));
  CHECK(driven.spin(0.1) == o.spin);
  CHECK_FALSE(driven.rotates());

  o.fixed_spin = {true, false, false};
  CHECK_THROWS_AS(RigidBody(o), std::invalid_argument); // it has spin about x
  o.spin[0] = 0.0;
  RigidBody hinged(o); // no spin about x: it stays so, and the energy within a bound
  const double start = hinged.kinetic_energy(0.0);
  for (int k = 0; k < 2000; ++k)
  {
    hinged.advance(0.02, 0.02, k == 0);
    CHECK(hinged.spin(0.0)[0] == 0.0);
    CHECK(hinged.kinetic_energy(0.0) == Approx(start).epsilon(1e-3));
  }
}

TEST_CASE("a body that moves needs mass and inertia")
{
  RigidBodyOptions o;
  CHECK_THROWS_AS(RigidBody(o), std::invalid_argument);
  o.mass = 1.0;
  CHECK_THROWS_AS(RigidBody(o), std::invalid_argument);
  o.fixed_spin = {true, true, true};
  CHECK_NOTHROW(RigidBody(o));
  CHECK(RigidBody(o).mobility(3.0) == 1.0);
}
