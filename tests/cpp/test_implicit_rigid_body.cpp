// SPDX-License-Identifier: MIT
// Rigid bodies in implicit steps and in statics: rotations as vectors, quaternions and matrices, free motion, motion
// under constant loads, balances.
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <dolfinx_impact/integrators/newmark/ImplicitRigidBody.h>
#include <dolfinx_impact/problems/StaticRigidBody.h>
#include <stdexcept>

using Catch::Approx;
using namespace dolfinx_impact;
using integrators::ImplicitRigidBody;
using integrators::ImplicitScheme;
using integrators::RigidBodyOptions;

namespace
{
typedef gap::Vector3 Triple;

RigidBodyOptions top()
{
  RigidBodyOptions o;
  o.mass = 2.0;
  o.inertia = {2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0};
  o.velocity = {0.3, 0.0, -0.1};
  o.spin = {0.4, 3.0, 0.0};
  return o;
}

/// A step without contact: the first guess is the solution if the loads stay.
void free_step(ImplicitRigidBody& body, double dt, const Triple& force, const Triple& torque)
{
  body.begin_step(ImplicitScheme(), dt, force, torque);
  const solve::RigidBalance balance = body.balance(body.first_guess(), {}, {});
  for (double missing : balance.missing)
    CHECK(std::abs(missing) <= std::max(1e-13 * balance.size, balance.round_off));
  body.accept(body.first_guess(), {}, {});
}
} // namespace

TEST_CASE("rotation vectors, quaternions and matrices are the same rotations")
{
  const Triple angle{0.3, -1.2, 0.7};
  const gap::Quaternion q = gap::quaternion_of(angle);
  const Triple back = gap::angle_of(q);
  const gap::Matrix3 R = gap::matrix_of(q), less = gap::matrix_less_identity(q);
  const Triple along = gap::times(R, angle);
  for (int k = 0; k < 3; ++k)
  {
    CHECK(back[k] == Approx(angle[k]));
    CHECK(along[k] == Approx(angle[k])); // the axis stays
    CHECK(less[4 * k] == Approx(R[4 * k] - 1.0));
  }
  const gap::Quaternion other = gap::quaternion_of({0.0, 0.0, 0.5});
  const gap::Quaternion both = gap::product(other, q);
  const gap::Matrix3 turn = gap::turn_of(other), between = gap::turn_between(R, gap::matrix_of(both));
  for (int k = 0; k < 9; ++k)
    CHECK(between[k] == Approx(turn[k]).margin(1e-15));
  CHECK(gap::product(q, gap::inverse(q))[0] == Approx(1.0));
  CHECK(gap::normalised({2.0, 0.0, 0.0, 0.0})[0] == 1.0);
}

TEST_CASE("a free top in implicit steps keeps its momenta and turns exactly")
{
  ImplicitRigidBody body(top(), 1.0);
  body.start({}, {}, {}, {});
  const Triple L = body.angular_momentum();
  const double energy = body.kinetic_energy();
  for (int k = 0; k < 40; ++k)
    free_step(body, 0.1, {}, {});
  for (int k = 0; k < 3; ++k)
  {
    CHECK(body.angular_momentum()[k] == Approx(L[k]).epsilon(1e-13).margin(1e-14));
    CHECK(body.momentum()[k] == Approx(2.0 * top().velocity[k]).margin(1e-14));
    CHECK(body.position()[k] == Approx(4.0 * top().velocity[k]).margin(1e-13));
  }
  CHECK(body.kinetic_energy() == Approx(energy).epsilon(1e-13));
  // Precession of the axis about L by |L| t/I_1.
  const double size = std::hypot(L[0], L[1]), angle = 4.0 * size / 2.0;
  const gap::Matrix3 R = body.rotation(),
                     P = gap::matrix_of(gap::quaternion_of({angle * L[0] / size, angle * L[1] / size, 0.0}));
  for (int k = 0; k < 3; ++k)
    CHECK(R[3 * k + 1] == Approx(P[3 * k + 1]).margin(1e-12));
}

TEST_CASE("a ball under constant loads in implicit steps")
{
  RigidBodyOptions o;
  o.mass = 2.0;
  o.inertia = {0.5, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.5};
  ImplicitRigidBody body(o, 1.0);
  const Triple force{0.0, 4.0, 0.0}, torque{0.0, 0.0, 0.25};
  body.start(force, torque, {}, {});
  for (int k = 0; k < 10; ++k)
    free_step(body, 0.1, force, torque);
  CHECK(body.position()[1] == Approx(1.0));
  CHECK(body.velocity()[1] == Approx(2.0));
  CHECK(body.spin()[2] == Approx(0.5));
  CHECK(gap::angle_of(body.state().rotation)[2] == Approx(0.25));
  CHECK(body.state().work == Approx(4.0 + 0.25 * 0.25));
  CHECK(body.kinetic_energy() == Approx(4.0 + 0.0625));
  CHECK(body.component(5) == "rz");
  CHECK(body.derivatives()[1] == Approx(-2.0 * 4.0 / 0.01));
  // What lacks is what is not there: contact forces count as loads do.
  body.begin_step(ImplicitScheme(), 0.1, force, torque);
  CHECK(body.balance(body.first_guess(), {1.0, 0.0, 0.0}, {}).missing[0] == Approx(1.0));
}

TEST_CASE("driven components of a body in implicit steps keep their velocity, and their work is counted")
{
  RigidBodyOptions o;
  o.velocity = {0.5, 0.0, 0.0};
  o.spin = {0.0, 0.0, 2.0};
  o.fixed_velocity = {true, true, true};
  o.fixed_spin = {true, true, true};
  ImplicitRigidBody body(o, 1.0);
  CHECK(body.size() == 0);
  CHECK(body.turns());
  body.start({}, {}, {-3.0, 0.0, 0.0}, {0.0, 0.0, -1.0});
  body.begin_step(ImplicitScheme(), 0.1, {}, {});
  body.accept({}, {-3.0, 0.0, 0.0}, {0.0, 0.0, -1.0});
  CHECK(body.position()[0] == Approx(0.05));
  CHECK(gap::angle_of(body.state().rotation)[2] == Approx(0.2));
  CHECK(body.state().work == Approx(3.0 * 0.05 + 0.2));
  o.fixed_velocity = {false, true, true};
  CHECK_THROWS_AS(ImplicitRigidBody(o, 1.0), std::invalid_argument);
}

TEST_CASE("a rigid body of a static problem: its place and what it lacks")
{
  const Triple force{1.0, 2.0, 0.0}, torque{0.0, 0.0, 3.0};
  problems::StaticRigidBody body({true, false, true, true, true, false}, force, torque, {1.0, 0.0, 0.0}, 2.0);
  CHECK(body.size() == 2);
  CHECK(body.turns());
  CHECK(body.needs_contact());
  CHECK(body.component(1) == "rz");
  body.begin({{0.0, 0.5, 0.0}, gap::matrix_of(gap::quaternion_of({0.0, 0.0, 0.1}))});
  const solve::RigidPlace place = body.place(std::array{0.25, 0.4});
  CHECK(place.displacement[1] == 0.75);
  CHECK(place.rotation[3] == Approx(std::sin(0.3)));
  const solve::RigidBalance balance = body.balance(std::array{0.0, 0.0}, {0.0, -2.0, 0.0}, {0.0, 0.0, 1.0});
  CHECK(balance.missing[0] == 0.0);
  CHECK(balance.missing[1] == 2.0); // torques over the length
  CHECK(balance.size == 2.0);
  CHECK_THROWS_AS(problems::StaticRigidBody({}, std::array{1.0}, torque, {}, 1.0), std::invalid_argument);
}
