// SPDX-License-Identifier: MIT
// The collaborators of the explicit integrator, each alone.
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <dolfinx_impact/integrators/ContactNodes.h>
#include <dolfinx_impact/integrators/DeformationWatch.h>
#include <dolfinx_impact/integrators/EnergyBalance.h>
#include <dolfinx_impact/integrators/History.h>
#include <dolfinx_impact/integrators/Loads.h>
#include <dolfinx_impact/integrators/NodalFields.h>
#include <dolfinx_impact/integrators/PrescribedMotion.h>
#include <dolfinx_impact/integrators/StepSchedule.h>
#include <dolfinx_impact/integrators/newmark/StepMotion.h>
#include <stdexcept>

using Catch::Approx;
using namespace dolfinx_impact::integrators;

namespace
{
const std::vector<std::int32_t> two_dofs{1, 3};

/// Three owned nodes and no ghosts.
std::shared_ptr<const dolfinx::common::IndexMap> three_nodes()
{
  return std::make_shared<const dolfinx::common::IndexMap>(MPI_COMM_SELF, 3);
}
} // namespace

TEST_CASE("a watch tells which cells have deformed since its reference")
{
  const std::vector<std::int32_t> nodes{0, 1, 2, 1, 2, 3}; // two triangles
  DeformationWatch watch(nodes, 3, 2, 2);
  CHECK_FALSE(watch.is_set());
  std::vector<double> u(8, 5.0);
  CHECK_THROWS_AS(watch.passed(u), std::invalid_argument);
  CHECK_THROWS_AS(watch.set(u, std::vector<double>{1.0}), std::invalid_argument);
  CHECK_THROWS_AS(watch.set(std::vector<double>(6), std::vector<double>{1.0, 1.0}), std::invalid_argument);
  CHECK_THROWS_AS(DeformationWatch(nodes, 4, 2, 2), std::invalid_argument);
  watch.set(u, std::vector<double>{0.5, 0.2});
  for (double& x : u)
    x += 7.0; // a translation
  CHECK(watch.deformations(u) == std::vector<double>{0.0, 0.0});
  u[2 * 3 + 1] += 0.25;
  CHECK(watch.deformations(u)[0] == 0.0);
  CHECK(watch.deformations(u)[1] == Approx(0.25));
  CHECK(watch.passed(u));
  watch.set(u, std::vector<double>{0.5, 0.2});
  u[0] -= 0.4; // a node of the other cell, which may do so
  CHECK_FALSE(watch.passed(u));
  u[0] -= 0.2;
  CHECK(watch.passed(u));
}

TEST_CASE("a watch looks at cells of any size alike")
{
  for (const auto& [width, bs] : {std::pair{3, 2}, {4, 2}, {4, 3}, {8, 3}, {6, 2}, {10, 3}, {2, 1}})
  {
    std::vector<std::int32_t> nodes(width);
    for (int i = 0; i < width; ++i)
      nodes[i] = i;
    DeformationWatch watch(nodes, width, bs, bs);
    std::vector<double> u(std::size_t(width) * bs);
    watch.set(u, std::vector<double>{0.0});
    u[std::size_t(width - 1) * bs + bs - 1] = -3.0;
    CHECK(watch.deformations(u) == std::vector<double>{3.0});
  }
}

TEST_CASE("loads are values times amplitudes")
{
  Loads loads(4);
  CHECK(loads.forces() == nullptr);
  CHECK(loads.force(1) == 0.0);
  const std::vector<double> values{2.0, -1.0}, others{10.0, 20.0};
  loads.add(two_dofs, values, 0);
  loads.add(two_dofs, others, -1); // the amplitude is one
  const double amplitudes[] = {3.0};
  loads.apply(amplitudes);
  CHECK(loads.force(0) == 0.0);
  CHECK(loads.force(1) == 16.0);
  CHECK(loads.forces()[3] == 17.0);
  SECTION("they follow their amplitudes")
  {
    const double later[] = {-1.0};
    loads.apply(later);
    CHECK(loads.force(1) == 8.0);
  }
  SECTION("other values hold at the same amplitudes")
  {
    loads.set_values(1, std::vector<double>{0.0, 5.0});
    loads.apply(amplitudes);
    CHECK(loads.force(1) == 6.0);
    CHECK(loads.force(3) == 2.0);
  }
  SECTION("wrong sizes are refused")
  {
    CHECK_THROWS_AS(loads.add(two_dofs, std::vector<double>{1.0}, -1), std::invalid_argument);
    CHECK_THROWS_AS(loads.set_values(0, std::vector<double>{1.0}), std::invalid_argument);
    CHECK_THROWS_AS(loads.set_values(2, values), std::out_of_range);
  }
}

TEST_CASE("a prescribed motion needs the force that equilibrium lacks")
{
  // One mass that is moved from rest at x = 1 to x = 1.3 in a step of 0.1, against a spring's residual of 4.
  const double dt = 0.1, mass[] = {2.0};
  double u[] = {1.0}, v[] = {0.5}, r[] = {4.0};
  PrescribedMotion motion;
  CHECK_THROWS_AS(motion.add(two_dofs, std::vector<double>{1.0}, 0), std::invalid_argument);
  motion.add(std::vector<std::int32_t>{0}, std::vector<double>{0.65}, 0);
  motion.keep(u, v, r);
  const Loads loads(1);
  const double amplitudes[] = {2.0};
  Sums sums;
  // The update has moved it on at its velocity and has taken the residual.
  u[0] += dt * v[0];
  r[0] = 0.0;
  const PrescribedMotion::Power power = motion.impose(dt, dt, 0.0, amplitudes, mass, loads, u, v, sums);
  CHECK(u[0] == 1.3);
  CHECK(v[0] == Approx(3.0).epsilon(1e-15));
  const double force = 2.0 * (3.0 - 0.5) / dt + 4.0;
  CHECK(power.before == Approx(force * 0.5).epsilon(1e-14));
  CHECK(power.after == Approx(force * 3.0).epsilon(1e-14));
  CHECK(sums.momentum == Approx(2.0 * 0.5 * 3.0).epsilon(1e-14));
  CHECK(sums.speed == Approx(2.0 * 9.0).epsilon(1e-14));
  SECTION("its acceleration leads to the next place")
  {
    const double next[] = {(1.3 + 0.4) / 0.65};
    double a[] = {0.0};
    motion.accelerations(dt, next, u, v, a);
    CHECK(a[0] == Approx((4.0 - 3.0) / dt).epsilon(1e-12));
  }
}

TEST_CASE("energies are sums of works")
{
  EnergySums sums;
  sums.kinetic = 1.0;
  sums.position = 8.0;
  sums.terms_position = 3.0;
  sums.residual_work = 20.0;
  sums.work = {0.5, 2.0, 4.0, 0.25};
  sums.damped = 0.125;
  sums.normal = -7.0;
  sums.load_work = 100.0;
  sums.support_work = 10.0;
  CHECK(sums.energies(InternalEnergy::quadratic).internal == 5.0);
  const Energies e = sums.energies(InternalEnergy::work);
  CHECK(e.internal == 20.0 - (-0.5 + 2.0 + 4.0 - 0.25));
  CHECK(e.damping == 2.125);
  CHECK(e.viscosity == 4.0);
  CHECK(e.impact == 7.0);
  CHECK(e.external == 110.25);
  CHECK(e.plastic == 0.0);
  CHECK(e.values().back() == e.external);
  sums.elastic = 6.0;
  CHECK(sums.energies(InternalEnergy::elastic).internal == 6.0);
  CHECK(sums.energies(InternalEnergy::elastic).plastic == e.internal - 6.0);
  CHECK(EnergySums::of(sums.values()).normal == -7.0);
}

TEST_CASE("energy is gained where it rises above its lowest value")
{
  EnergyGain gain;
  Energies e;
  e.kinetic = 2.0;
  gain.update(e, 0.0, 0.0);
  CHECK(gain.now == 0.0);
  e.kinetic = 1.0;
  e.friction = 1.0;
  gain.update(e, 0.0, 0.0);
  CHECK(gain.now == 0.0);
  e.kinetic = 1.5; // from nowhere
  gain.update(e, 0.0, 0.0);
  CHECK(gain.now == Approx(0.5 / 2.5).epsilon(1e-14));
  e.external = 0.5; // no: a load has done it
  gain.update(e, 0.0, 0.0);
  CHECK(gain.now == Approx(0.0).margin(1e-14));
  CHECK(gain.most == Approx(0.2).epsilon(1e-14));
  e.kinetic = 2.5; // one from nowhere, beside what rounding may bring
  gain.update(e, 0.0, 100.0);
  CHECK(gain.now == Approx(0.01).epsilon(1e-14));
}

TEST_CASE("rows of a history")
{
  CHECK(History::row_size(2) == Energies::size + 6);
  std::vector<double> rows(3 * History::row_size(1), -1.0);
  const History history(rows, 1);
  Energies e;
  e.kinetic = 4.0;
  e.external = 5.0;
  const double force[] = {1.0, 2.0, 3.0};
  history.write(1, e, force);
  const std::size_t first = History::row_size(1);
  CHECK(rows[first - 1] == -1.0);
  CHECK(rows[first] == 4.0);
  CHECK(rows[first + Energies::size - 1] == 5.0);
  CHECK(rows[first + Energies::size + 2] == 3.0);
  CHECK(rows[2 * first] == -1.0);
  History().write(0, e, force); // nothing is kept
}

TEST_CASE("nodes of contacts have numbers and values of their own")
{
  NodalFields fields(three_nodes(), 2);
  REQUIRE(fields.owned == 6);
  for (std::size_t i = 0; i < 6; ++i)
  {
    fields.u[i] = double(i);
    fields.v[i] = 10.0 * double(i);
    fields.mass[i] = 2.0;
    fields.inverse[i] = 0.5;
  }
  ContactNodes nodes;
  CHECK(nodes.forces(fields).springs == std::vector<double>(6, 0.0));
  nodes.assign_numbers(fields, {2, 0, 2}, false);
  REQUIRE(nodes.size() == 2);
  CHECK(nodes.numbers()[0] == 0);
  CHECK(nodes.numbers()[1] == -1);
  CHECK(nodes.numbers()[2] == 1);
  CHECK(nodes.mass() == std::vector<double>{2.0, 2.0});
  CHECK(nodes.gather(fields, 0.1, true) == 0.0);
  CHECK(nodes.u == std::vector<double>{0.0, 1.0, 4.0, 5.0});
  CHECK(nodes.du[3] == Approx(5.0).epsilon(1e-15));
  nodes.springs = {1.0, 0.0, 0.0, -2.0};
  const ContactNodes::Products products = nodes.add_springs(fields);
  CHECK(products.position == -10.0);
  CHECK(products.work == Approx(-10.0).epsilon(1e-15));
  CHECK(fields.owned_values(fields.r) == std::vector<double>{-1.0, 0.0, 0.0, 0.0, 0.0, 2.0});
  SECTION("forces go on when other nodes are numbered")
  {
    nodes.assign_numbers(fields, {1, 2}, true);
    CHECK(nodes.springs == std::vector<double>{0.0, 0.0, 0.0, -2.0});
    CHECK(nodes.v.size() == 4);
  }
  SECTION("the next step takes the forces' work and clears them")
  {
    CHECK(nodes.gather(fields, 0.2, true) == Approx(-20.0).epsilon(1e-15));
    CHECK(nodes.springs == std::vector<double>(4, 0.0));
  }
}

TEST_CASE("the balance of a mass on a spring")
{
  // m = 1, k = 1, central differences from u = 1 at rest: kinetic energy by v_(n-1/2) v_(n+1/2), so that the total is
  // constant to round-off.
  const double dt = 0.1;
  double u = 1.0, v = 0.0, r = 0.0;
  const double inverse = 1.0, mass = 1.0;
  EnergyBalance balance(MPI_COMM_SELF, InternalEnergy::quadratic, Scheme::half_step, 0.0);
  ContactForces none;
  const int steps = 200;
  std::vector<double> rows(steps * History::row_size(0));
  const History history(rows, 0);
  double last = 0.0;
  for (int k = 0; k < steps; ++k)
  {
    r = u;
    REQUIRE(balance.end_sum());
    const Sums sums = update(1, &r, nullptr, &inverse, &mass, {1.0, 0.5 * (last + dt), dt}, &u, &v);
    balance.add_step(sums, {}, {last, dt}, {}, none, false, false);
    balance.begin_sum(none, 1, history, k);
    last = dt;
  }
  REQUIRE(balance.end_sum());
  for (int k = 0; k < steps; ++k)
  {
    const double* row = rows.data() + k * History::row_size(0);
    // At the start v_(-1/2) = -v_(1/2) = dt/2.
    CHECK(row[0] + row[1] == Approx(0.5 - 0.125 * dt * dt).epsilon(1e-13));
  }
  CHECK(balance.gain().most < 1e-13);
  CHECK_FALSE(balance.stop_asked());
  SECTION("what is saved goes on")
  {
    EnergyBalance other(MPI_COMM_SELF, InternalEnergy::quadratic, Scheme::half_step, 0.0);
    other.restore(balance.save());
    CHECK(other.save().residual_work == balance.save().residual_work);
    CHECK(other.save().reference == balance.save().reference);
  }
}

TEST_CASE("a schedule has equal steps that end exactly where they should")
{
  const StepSchedule schedule{.begin = 0.1, .until = 0.4, .first = 7, .last = 10};
  CHECK(schedule.dt() == Approx(0.1));
  CHECK(schedule.time(7) == 0.1);
  CHECK(schedule.time(8) == Approx(0.2));
  CHECK(schedule.time(10) == 0.4); // to the last digit, whatever three thirds are
  CHECK(schedule == StepSchedule{0.1, 0.4, 7, 10, false});
  CHECK_FALSE(schedule == StepSchedule{0.1, 0.4, 7, 10, true});
}

TEST_CASE("the end of an implicit step has the formulas of Newmark, Chung and Hulbert")
{
  const double h = 0.5;
  const std::vector<std::int8_t> massless{0, 1, 0}, fixed{0, 0, 1};
  TimeValues prescribed;
  prescribed.velocity = {0.0, 0.0, 7.0};
  prescribed.acceleration = {0.0, 0.0, -3.0};
  for (const ImplicitScheme& s : {ImplicitScheme::newmark(0.25, 0.5), ImplicitScheme::newmark(0.3, 0.6),
                                  ImplicitScheme::generalised_alpha(0.2), ImplicitScheme::hht(-0.1)})
  {
    const Motion start{{1.0, 2.0, 3.0}, {0.25, 4.0, 5.0}, {-2.0, 6.0, 0.0}, {-1.5, 0.0, 0.0}};
    const StepMotion motion(s, h, start, massless, fixed, prescribed);
    const Motion end = motion.end(std::vector<double>{1.75, 2.5, 3.5});
    CHECK(end.displacement == std::vector<double>{1.75, 2.5, 3.5});
    const double mean = start.mean[0], new_mean = end.mean[0];
    CHECK(end.displacement[0] == Approx(1.0 + h * 0.25 + h * h * ((0.5 - s.beta) * mean + s.beta * new_mean)));
    CHECK(end.velocity[0] == Approx(0.25 + h * ((1.0 - s.gamma) * mean + s.gamma * new_mean)));
    CHECK((1.0 - s.alpha_f) * end.acceleration[0] + s.alpha_f * start.acceleration[0] ==
          Approx((1.0 - s.alpha_m) * new_mean + s.alpha_m * mean));
    CHECK(end.velocity[1] == Approx(0.5 / h)); // without mass: the mean of the step
    CHECK((end.acceleration[1] == 0.0 && end.mean[1] == 0.0));
    CHECK((end.velocity[2] == 7.0 && end.acceleration[2] == -3.0));

    const Motion falling{{1.0, 0.0, 0.0}, {0.25, 0.0, 0.0}, {-9.0, 0.0, 0.0}, {-9.0, 0.0, 0.0}};
    const StepMotion fall(s, h, falling, massless, fixed, prescribed);
    const Motion landed = fall.end(fall.predictor());
    CHECK(landed.displacement[0] == Approx(1.0 + 0.25 * h - 4.5 * h * h));
    CHECK(landed.velocity[0] == Approx(0.25 - 9.0 * h));
    CHECK((landed.acceleration[0] == Approx(-9.0) && landed.mean[0] == Approx(-9.0)));
  }
}

TEST_CASE("an update by the nodes' masses is that by degree of freedom, to the last bit")
{
  constexpr int num_nodes = 37;
  NodalFields one(std::make_shared<const dolfinx::common::IndexMap>(MPI_COMM_SELF, num_nodes), 3);
  REQUIRE(one.stride == 4);
  const auto number = [](std::size_t k) { return std::sin(7.0 * double(k) + 1.0); };
  for (std::size_t node = 0; node < num_nodes; ++node)
    for (std::size_t c = 0; c < 3; ++c)
    {
      const std::size_t i = 4 * node + c;
      one.mass[i] = 2.0 + number(node);
      one.inverse[i] = 1.0 / one.mass[i];
      one.u[i] = number(i);
      one.v[i] = number(i + 1000);
      one.r[i] = number(i + 2000);
    }
  one.inverse[4 * 5 + 1] = 0.0; // prescribed before
  NodeMasses masses(one);
  REQUIRE(masses.known());
  for (const std::size_t entry : {4 * 9 + 0, 4 * 9 + 2, 4 * 11 + 1})
  {
    one.inverse[entry] = 0.0;
    masses.prescribe(entry);
  }
  NodalFields other = [&]
  {
    NodalFields copy(std::make_shared<const dolfinx::common::IndexMap>(MPI_COMM_SELF, num_nodes), 3);
    copy.u = one.u;
    copy.v = one.v;
    copy.r = one.r;
    return copy;
  }();
  AlignedVector loads(one.owned_entries, 0.0);
  for (std::size_t i = 0; i < loads.size(); ++i)
    loads[i] = i % 4 == 3 ? 0.0 : number(i + 3000);
  const Coefficients c{0.9, 0.011, 0.01};
  for (const double* external : {static_cast<const double*>(nullptr), static_cast<const double*>(loads.data())})
  {
    for (std::size_t i = 0; i < one.r.size(); ++i)
      one.r[i] = other.r[i] = i % 4 == 3 ? 0.0 : number(i + 4000);
    const Sums a = update(one.owned_entries, one.r.data(), external, one.inverse.data(), one.mass.data(), c,
                          one.u.data(), one.v.data());
    const Sums b = update(num_nodes, other.r.data(), external, masses, c, other.u.data(), other.v.data());
    CHECK(a.momentum == b.momentum);
    CHECK(a.speed == b.speed);
    CHECK(a.old_speed == b.old_speed);
    CHECK(a.position == b.position);
    CHECK(a.before == b.before);
    CHECK(a.after == b.after);
    CHECK(a.load_before == b.load_before);
    CHECK(a.load_after == b.load_after);
    CHECK(one.u == other.u);
    CHECK(one.v == other.v);
    CHECK(one.r == other.r);
  }
  one.mass[4 * 3 + 1] *= 2.0; // a component's own mass
  CHECK_FALSE(NodeMasses(one).known());
}
