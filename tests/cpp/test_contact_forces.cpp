// SPDX-License-Identifier: MIT
// ContactForces with contacts that are a few lines each: what it hands to them, and what it makes of their answers.
#include <algorithm>
#include <basix/finite-element.h>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx/mesh/utils.h>
#include <dolfinx_impact/common/create_functionspace.h>
#include <dolfinx_impact/integrators/ContactForces.h>
#include <dolfinx_impact/surface/Surface.h>
#include <limits>
#include <stdexcept>

using Catch::Approx;
using namespace dolfinx_impact;
using namespace dolfinx_impact::integrators;

namespace
{
/// Acts on node 2 of a plane space of three nodes.
class OneNode : public enforcement::NodalContact
{
public:
  void search(std::span<const double> u, std::span<const double> du) override
  {
    ++searches;
    seen_u.assign(u.begin(), u.end());
    seen_du.assign(du.begin(), du.end());
  }
  std::span<const std::int64_t> remote_nodes() const override { return {}; }
  std::span<const int> remote_owners() const override { return {}; }
  std::span<const std::int32_t> required_nodes(operators::Halo&) override { return _nodes; }
  void assign_numbers(operators::Halo& halo, std::span<const std::int32_t> numbers,
                      std::span<const double> mass) override
  {
    REQUIRE(halo.num_nodes() == 1);
    own = numbers[2];
    seen_mass = mass[own];
  }
  double largest_position() const override { return position; }
  void set_obstacle(const gap::RigidMotion& motion) override
  {
    obstacle = motion.displacement;
    obstacle_increment = motion.increment;
  }
  double increment_used(const enforcement::NodalState&) const override { return motion_used; }
  void forget_search() override { ++forgotten; }
  void update_gaps(std::span<const double> u) override { gap = u[2 * own]; }
  enforcement::ContactEnergy energy() const override { return energies; }
  enforcement::Passage passage() const override { return passed; }
  const std::array<double, 3>& force() const override { return total; }
  state::State saved_state() const override { return state::State("none"); }
  void resume(const state::State&) override {}
  void reset() override {}

  int searches = 0, forgotten = 0;
  std::int32_t own = -1;
  double seen_mass = 0.0, motion_used = 0.0, gap = 0.0, position = 0.0;
  std::vector<double> seen_u, seen_du;
  std::array<double, 3> obstacle{}, obstacle_increment{}, total{};
  enforcement::ContactEnergy energies;
  enforcement::Passage passed;

private:
  std::vector<std::int32_t> _nodes{2};
};

/// A spring of stiffness 4 that pulls the node's x to zero.
class Spring : public OneNode, public enforcement::SpringForces
{
public:
  void add_forces(const enforcement::NodalState& state, std::span<double> f) override
  {
    total[0] = -4.0 * state.u[2 * own];
    f[2 * own] += total[0];
    seen_step = state.dt;
    seen_range = state.range;
  }
  double seen_step = 0.0;
  enforcement::IncrementRange seen_range;
};

NodalFields three_nodes()
{
  NodalFields fields(std::make_shared<const dolfinx::common::IndexMap>(MPI_COMM_SELF, 3), 2);
  for (std::size_t i = 0; i < fields.u.size(); ++i)
  {
    fields.mass[i] = 2.0;
    fields.inverse[i] = 0.5;
  }
  return fields;
}
} // namespace

TEST_CASE("contacts have to act, in a step that is known")
{
  ContactForces contacts;
  CHECK(contacts.empty());
  CHECK_NOTHROW(contacts.check_step()); // nobody needs it
  CHECK_FALSE(contacts.search_due());
  CHECK_THROWS_AS(contacts.add(std::make_shared<OneNode>(), {-1, -1, -1}), std::invalid_argument);
  CHECK(contacts.empty());
  contacts.add(std::make_shared<Spring>(), {-1, -1, -1});
  CHECK(contacts.has_springs());
  CHECK_FALSE(contacts.has_corrections());
  CHECK(contacts.size() == 1);
  CHECK(contacts.search_due());
  CHECK_THROWS_AS(contacts.check_step(), std::invalid_argument);
  for (double dt : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()})
    CHECK_THROWS_AS(contacts.set_step(dt), std::invalid_argument);
  contacts.set_step(0.1);
  CHECK_NOTHROW(contacts.check_step());
  CHECK(contacts.step() == 0.1);
}

TEST_CASE("a search sees the motion of a step")
{
  NodalFields fields = three_nodes();
  fields.u[4] = 7.0;
  fields.v[4] = 3.0;
  ContactForces contacts;
  const auto spring = std::make_shared<Spring>();
  contacts.add(spring, {-1, -1, -1});
  contacts.set_step(0.1);
  contacts.search(fields, 0.0); // at the start: the step of the stiffness
  CHECK(spring->seen_u == fields.owned_values(fields.u));
  CHECK(spring->seen_du[4] == Approx(0.3).epsilon(1e-15));
  CHECK(spring->own == 0);
  CHECK(spring->seen_mass == 2.0);
  CHECK_FALSE(contacts.search_due());
  contacts.search(fields, 0.5);
  CHECK(spring->seen_du[4] == 1.5);
  CHECK(contacts.num_searches() == 2);
  SECTION("what asks for another one")
  {
    contacts.request_search();
    CHECK(contacts.search_due());
    CHECK(contacts.work_of_step(fields, 0.5));
    CHECK(spring->searches == 3);
    CHECK_FALSE(contacts.work_of_step(fields, 0.5));
    contacts.forget_searches();
    CHECK(spring->forgotten == 1);
    CHECK(contacts.search_due());
  }
  SECTION("candidates that are used up are counted")
  {
    EnergySums sums;
    contacts.predict_searches();
    contacts.add_energies(sums);
    CHECK(sums.searches_due == 0.0);
    for (double used : {1.0, std::numeric_limits<double>::quiet_NaN()})
    {
      spring->motion_used = used;
      contacts.predict_searches();
      contacts.add_energies(sums);
      CHECK(sums.searches_due == 1.0);
    }
  }
}

TEST_CASE("springs are part of the residual and do work by the trapezoidal rule")
{
  NodalFields fields = three_nodes();
  const double dt = 0.5;
  ContactForces contacts;
  const auto spring = std::make_shared<Spring>();
  contacts.add(spring, {-1, -1, -1});
  contacts.set_step(dt);
  contacts.search(fields, 0.0);
  // From x = 0 to 1 to 3: work -4 (0 + 1)/2 (1 - 0) - 4 (1 + 3)/2 (3 - 1).
  double expected = 0.0;
  for (const auto& [from, to] : {std::pair{0.0, 1.0}, std::pair{1.0, 3.0}})
  {
    fields.u[4] = to;
    fields.v[4] = (to - from) / dt;
    fields.r.assign(6, 0.0);
    CHECK_FALSE(contacts.work_of_step(fields, dt));
    contacts.evaluate(fields);
    expected -= 4.0 * 0.5 * (from + to) * (to - from);
    for (const std::array<double, 3>& bound : {spring->seen_range.least, spring->seen_range.largest}) // of one node
      CHECK((bound[0] == to - from && bound[1] == 0.0));
    CHECK(fields.owned_values(fields.r) == std::vector<double>{0.0, 0.0, 0.0, 0.0, 4.0 * to, 0.0});
    CHECK(contacts.spring_work().value() == Approx(expected).epsilon(1e-15));
    contacts.commit();
  }
  CHECK(expected == -18.0);
  CHECK(spring->seen_step == dt);
  CHECK(contacts.spring_position() == -36.0);
  EnergySums sums;
  spring->energies = {.stored = 18.0, .friction = 1.0, .normal = 2.0};
  contacts.add_energies(sums);
  CHECK(sums.work[std::size_t(WorkKind::contact)] == Approx(-18.0).epsilon(1e-15));
  CHECK(sums.terms_position == 18.0);
  CHECK(sums.stored == 18.0);
  CHECK(sums.friction == 1.0);
  CHECK(sums.normal == 2.0);
  CHECK(sums.kinematic == 0.0); // springs take nothing that they could give back
  double force[] = {0.0, 0.0, 5.0};
  contacts.resultants(2, force);
  CHECK(force[0] == -12.0);
  CHECK(force[2] == 5.0); // no third component in the plane
  contacts.update_gaps();
  CHECK(spring->gap == 3.0);
  SECTION("another run goes on from the forces")
  {
    ContactForces others;
    const auto other = std::make_shared<Spring>();
    others.add(other, {-1, -1, -1});
    others.set_step(dt);
    others.restore(contacts.forces(fields), contacts.spring_work(), contacts.spring_position(), 0.25,
                   contacts.obstacles());
    CHECK(other->forgotten == 1);
    CHECK(others.obstacle_work() == 0.25);
    others.search(fields, dt);
    fields.u[4] = 4.0;
    fields.v[4] = 2.0;
    contacts.work_of_step(fields, dt);
    others.work_of_step(fields, dt);
    CHECK(others.spring_work().value() == Approx(-18.0 - 0.5 * 12.0).epsilon(1e-15));
    CHECK(others.spring_work().value() == contacts.spring_work().value());
  }
  SECTION("a new start forgets them")
  {
    contacts.reset();
    CHECK(contacts.spring_work().value() == 0.0);
    CHECK(contacts.forces(fields).springs == std::vector<double>(6, 0.0));
    CHECK(contacts.search_due());
  }
}

TEST_CASE("rigid masters move by amplitudes, and the contact force works on them")
{
  NodalFields fields = three_nodes();
  fields.u[4] = 2.0;
  ContactForces contacts;
  const auto moved = std::make_shared<Spring>(), fixed = std::make_shared<Spring>();
  contacts.add(moved, {1, 0, 2});
  contacts.add(fixed, {-1, -1, -1});
  contacts.set_step(0.5);
  contacts.search(fields, 0.0);
  const double start[] = {5.0, 1.0, 0.0}, later[] = {5.0, 1.5, 0.0};
  contacts.move_obstacles(start, true);
  CHECK(moved->obstacle == std::array{1.0, 5.0, 0.0});
  CHECK(moved->obstacle_increment == std::array{0.0, 0.0, 0.0}); // it begins there
  contacts.work_of_step(fields, 0.0);
  contacts.evaluate(fields);
  CHECK(contacts.obstacle_work() == 0.0);
  contacts.move_obstacles(later, false);
  CHECK(moved->obstacle_increment == std::array{0.5, 0.0, 0.0});
  CHECK(fixed->obstacle == std::array{0.0, 0.0, 0.0});
  contacts.work_of_step(fields, 0.5);
  contacts.evaluate(fields);
  // The force of -8 on the slave does not change; half of the work by it before, half by it after.
  CHECK(contacts.obstacle_work() == -4.0);
  const auto obstacles = contacts.obstacles();
  REQUIRE(obstacles.size() == 2);
  CHECK(obstacles[0].displacement[0] == 1.5);
  CHECK(obstacles[0].increment[0] == 0.5);
  CHECK(obstacles[0].increment_before[0] == 0.0);
  EnergySums sums;
  contacts.add_energies(sums);
  CHECK(sums.load_work == -4.0);
}

TEST_CASE("kinematic contact corrects displacement, velocity and the sums of an update")
{
  // A square of one cell above a rigid plane.
  const auto mesh = std::make_shared<dolfinx::mesh::Mesh<double>>(dolfinx::mesh::create_rectangle<double>(
      MPI_COMM_SELF, {{{0.0, 0.0}, {1.0, 1.0}}}, {1, 1}, dolfinx::mesh::CellType::quadrilateral));
  const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                                     basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, false);
  const surface::FunctionSpace V = dolfinx_impact::common::create_functionspace(mesh, element, {2});
  const std::vector<std::int32_t> bottom =
      dolfinx::mesh::locate_entities_boundary(*mesh, 1,
                                              [](auto x)
                                              {
                                                std::vector<std::int8_t> on;
                                                for (std::size_t p = 0; p < x.extent(1); ++p)
                                                  on.push_back(std::abs(x(1, p)) < 1e-12);
                                                return on;
                                              });
  gap::Rigid plane;
  plane.kind = gap::Rigid::Kind::plane;
  plane.gdim = 2;
  plane.direction = {0.0, 1.0, 0.0};
  const auto contact = std::make_shared<enforcement::KinematicContact>(V, surface::make_surface(V, bottom), plane,
                                                                       enforcement::KinematicContactOptions{});
  NodalFields fields(V.dofmap()->index_map, 2);
  std::fill(fields.mass.begin(), fields.mass.end(), 2.0);
  std::fill(fields.inverse.begin(), fields.inverse.end(), 0.5);
  const double dt = 0.5, h = 0.25, m = 2.0;
  ContactForces contacts;
  contacts.add(contact, {-1, -1, -1});
  CHECK(contacts.has_corrections());
  CHECK_FALSE(contacts.has_springs());
  contacts.set_step(dt);
  const auto set_y = [&](double u, double v)
  {
    for (std::size_t k = 1; k < fields.u.size(); k += 2)
    {
      fields.u[k] = u;
      fields.v[k] = v;
      fields.r[k] = 3.0;
    }
  };
  set_y(0.5, -2.0);
  contacts.search(fields, 0.0);
  contacts.keep(fields);
  set_y(-0.25, -1.5); // as an update has predicted
  Loads loads(fields.u.size());
  const std::int32_t loaded = 2 * contact->candidates().nodes()[0] + 1;
  loads.add(std::vector<std::int32_t>{loaded}, std::vector<double>{10.0}, -1);
  loads.apply(nullptr);
  Sums sums;
  contacts.correct(fields, dt, 0.4, h, 1.0, loads, sums);
  const double force = 0.25 * m / (h * dt), v = -1.5 + h / m * force;
  CHECK(v == Approx((0.0 - 0.5) / dt).epsilon(1e-14)); // the foot moves to the plane in the step
  const std::vector<double> forces = contacts.forces(fields).kinematic;
  for (std::int32_t node : contact->candidates().nodes())
  {
    CHECK(fields.u[2 * node + 1] == Approx(0.0).margin(1e-15));
    CHECK(fields.v[2 * node + 1] == Approx(v).epsilon(1e-14));
    CHECK(forces[2 * node + 1] == Approx(force).epsilon(1e-14));
  }
  CHECK(std::count_if(forces.begin(), forces.end(), [](double f) { return f != 0.0; }) == 2);
  // Two nodes of the foot, whose velocity was -2 before and was predicted as -1.5.
  CHECK(sums.momentum == Approx(2.0 * m * -2.0 * (v + 1.5)).epsilon(1e-14));
  CHECK(sums.speed == Approx(2.0 * m * (v * v - 2.25)).epsilon(1e-14));
  CHECK(sums.after == Approx(2.0 * 3.0 * (v + 1.5)).epsilon(1e-14));
  CHECK(sums.load_after == Approx(10.0 * (v + 1.5)).epsilon(1e-14));
  EnergySums energies;
  contacts.add_energies(energies);
  // A force works half on the increment before it, -2 times 0.4, and half on that after it, -0.5.
  CHECK(energies.normal == Approx(2.0 * 0.5 * force * -0.8).epsilon(1e-14));
  CHECK(energies.kinematic == energies.normal);
  CHECK(energies.taken == Approx(2.0 * 0.5 * force * (0.8 + 0.5)).epsilon(1e-14));
  CHECK(energies.work[std::size_t(WorkKind::contact)] == 0.0); // it is not part of the residual
}

TEST_CASE("the largest position is that of all obstacles")
{
  ContactForces contacts;
  const auto first = std::make_shared<Spring>(), second = std::make_shared<Spring>();
  contacts.add(first, {-1, -1, -1});
  contacts.add(second, {-1, -1, -1});
  CHECK(contacts.largest_position() == 0.0);
  first->position = 3.0;
  second->position = 2.0;
  CHECK(contacts.largest_position() == 3.0);
}

TEST_CASE("both directions of a pair are searched and act, and the pair tells their sum")
{
  NodalFields fields = three_nodes();
  fields.u[4] = 3.0;
  ContactForces contacts;
  const auto first = std::make_shared<Spring>(), second = std::make_shared<Spring>(),
             alone = std::make_shared<Spring>();
  contacts.add(enforcement::NodalPair({first, second}), {-1, -1, -1});
  contacts.add(alone, {-1, -1, -1});
  CHECK(contacts.size() == 2);
  contacts.set_step(0.5);
  contacts.search(fields, 0.0);
  contacts.work_of_step(fields, 0.0);
  contacts.evaluate(fields);
  for (const auto& spring : {first, second, alone})
  {
    CHECK(spring->searches == 1);
    CHECK(spring->total[0] == -12.0);
  }
  CHECK(fields.r[4] == 36.0); // all three act
  second->total = {-5.0, 1.0, 0.0};
  double force[6] = {};
  contacts.resultants(2, force);
  CHECK(force[0] == -7.0); // the second direction's slave is the master of the pair
  CHECK(force[1] == -1.0);
  CHECK(force[3] == -12.0);
  first->energies = {1.0, 2.0, 3.0, 4.0, 5.0, 6.0};
  second->energies = {10.0, 20.0, 30.0, 40.0, 50.0, 60.0};
  const enforcement::ContactEnergy both = enforcement::NodalPair({first, second}).energy();
  CHECK(both.stored == 11.0);
  CHECK(both.friction == 22.0);
  CHECK(both.normal == 33.0);
  CHECK(both.later_friction == 44.0);
  CHECK(both.later_normal == 55.0);
  CHECK(both.recoverable == 66.0);
  first->passed = {1, 1.5};
  second->passed = {0, 2.5};
  CHECK(contacts.passage().first == 0);
  CHECK(contacts.passage().second.node == 0);
  second->motion_used = 1.0;
  contacts.predict_searches();
  EnergySums sums;
  contacts.add_energies(sums);
  CHECK(sums.stored == 11.0);
  CHECK(sums.passages == 1.0); // of one pair
  CHECK(sums.searches_due > 0.0);
  contacts.update_gaps();
  CHECK(second->gap == 3.0);
  contacts.forget_searches();
  CHECK(second->forgotten == 1);
  CHECK_THROWS_AS(enforcement::NodalPair({first, second, alone}), std::invalid_argument);
  CHECK_THROWS_AS(enforcement::NodalPair(std::vector<std::shared_ptr<enforcement::NodalContact>>()),
                  std::invalid_argument);
  CHECK_THROWS_AS(contacts.add(enforcement::NodalPair({first, std::make_shared<OneNode>()}), {-1, -1, -1}),
                  std::invalid_argument);
  CHECK(contacts.size() == 2);
}

TEST_CASE("the fastest passage of all contacts is told")
{
  ContactForces contacts;
  const auto first = std::make_shared<Spring>(), second = std::make_shared<Spring>();
  contacts.add(first, {-1, -1, -1});
  contacts.add(second, {-1, -1, -1});
  CHECK(contacts.passage().first == -1);
  first->passed = {1, 0.5};
  second->passed = {2, 3.0};
  CHECK(contacts.passage().first == 1);
  CHECK(contacts.passage().second.node == 2);
  EnergySums sums;
  contacts.add_energies(sums);
  CHECK(sums.passages == 2.0);
}
