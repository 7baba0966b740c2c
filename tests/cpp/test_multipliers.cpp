// SPDX-License-Identifier: MIT
// Contact by multipliers at single nodes: frames, active set, constraints, condensation.
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <dolfinx_impact/enforcement/mortar/Condensation.h>
#include <dolfinx_impact/enforcement/mortar/CoulombFriction.h>
#include <dolfinx_impact/enforcement/mortar/SaddlePoint.h>
#include <dolfinx_impact/enforcement/mortar/active_set.h>
#include <dolfinx_impact/enforcement/mortar/prescribed_components.h>
#include <limits>
#include <stdexcept>

using Catch::Approx;
using namespace dolfinx_impact::enforcement;

namespace
{
typedef std::vector<std::int8_t> Flags;
typedef std::vector<double> Values;

/// Arrays of two nodes in the plane, the normal along y, friction 0.5.
struct TwoNodes
{
  Flags usable{1, 1}, active{1, 0}, sliding{0, 0}, fixed = Flags(4, 0);
  Values gap{0.0, 1.0}, multiplier{2.0, 0.0}, slip = Values(4, 0.0), traction = Values(4, 0.0),
                                              direction = Values(4, 0.0), opening{0.0, 0.0}, stiffness{10.0, 10.0},
                                              normal{0.0, 1.0, 0.0, 1.0}, weight{0.5, 0.25}, cover{0.5, 0.25};
  std::vector<std::int32_t> nodes{3, 7};
  NodalFrames frames = frames_at(2, normal, fixed);

  NodalMultipliers state(double friction = 0.5) const
  {
    return {.gdim = 2,
            .friction = friction,
            .usable = usable,
            .active = active,
            .gap = gap,
            .multiplier = multiplier,
            .sliding = sliding,
            .slip = slip,
            .traction = traction,
            .direction = direction,
            .opening = opening,
            .stiffness = stiffness,
            .lock = {}};
  }
  NodalGeometry geometry() const { return {nodes, normal, gap, slip, weight, cover, fixed, {}, frames}; }
};
/// Two nodes of the plane: node 0 lies on node 1 but for a gap of 0.5, normal along y.
Constraints one_over_the_other()
{
  Constraints c;
  c.gdim = 2;
  c.rows = {0};
  c.nodes = {0};
  c.frames = c.over = {1.0, 0.0, 0.0, 1.0};
  c.constrained = {0, 1};
  c.known = {0.0, -0.5};
  c.tilt = {0.0, 0.0};
  c.normal = {1};
  c.pointers = {0, 1};
  c.columns = {1};
  c.values = {1.0};
  return c;
}

/// A vector of this process alone.
struct Vector
{
  Vec v = nullptr;
  explicit Vector(const Values& values)
  {
    VecCreateSeq(MPI_COMM_SELF, PetscInt(values.size()), &v);
    for (std::size_t i = 0; i < values.size(); ++i)
      VecSetValue(v, PetscInt(i), values[i], INSERT_VALUES);
  }
  ~Vector() { VecDestroy(&v); }
  Vector(const Vector&) = delete;
  Vector& operator=(const Vector&) = delete;
  Values values() const
  {
    PetscInt size = 0;
    const PetscScalar* array = nullptr;
    VecGetLocalSize(v, &size);
    VecGetArrayRead(v, &array);
    Values out(array, array + size);
    VecRestoreArrayRead(v, &array);
    return out;
  }
};
} // namespace

TEST_CASE("frames keep prescribed axes and contain the normal freed of them")
{
  const double s = std::sqrt(1.0 / 3.0);
  const NodalFrames f = frames_at(3, Values{s, s, s, 1.0, 0.0, 0.0}, Flags{1, 0, 0, 1, 0, 0});
  CHECK(f.length[0] == Approx(std::sqrt(2.0 / 3.0)).epsilon(1e-14));
  CHECK(f.place[0] > 0);
  CHECK(f.place[1] == -1); // the normal has no free part
  CHECK(f.frames[0] == 1.0);
  CHECK(f.frames[f.place[0]] == 0.0);
  CHECK(f.frames[3 + f.place[0]] == Approx(std::sqrt(0.5)).epsilon(1e-14));
  CHECK_THROWS_AS(frames_at(3, Values{1.0, 0.0}, Flags{0, 0}), std::invalid_argument);
}

TEST_CASE("nodes close that penetrate and open that pull")
{
  TwoNodes n;
  CHECK(update_active_set(n.state(0.0), false, 1e-12, 2.0).active == Flags{1, 0});
  n.gap[1] = -1e-3;
  CHECK(update_active_set(n.state(0.0), false, 1e-12, 2.0).active == Flags{1, 1});
  n.multiplier[0] = -1.0;
  CHECK(update_active_set(n.state(0.0), false, 1e-12, 2.0).active == Flags{0, 1});
  CHECK(update_active_set(n.state(0.0), true, 1e-12, 2.0).active == Flags{1, 1}); // there are no multipliers yet
  n.usable = {1, 0};
  CHECK(update_active_set(n.state(0.0), false, 1e-12, 2.0).active == Flags{0, 0});
  n.usable = {1};
  CHECK_THROWS_AS(update_active_set(n.state(0.0), false, 1e-12, 2.0), std::invalid_argument);
}

TEST_CASE("a node slips beyond Coulomb's bound, against its motion")
{
  TwoNodes n;
  n.traction[0] = 0.9; // the bound is 1
  CHECK(update_active_set(n.state(), false, 1e-12, 2.0).sliding == Flags{0, 0});
  n.traction[0] = 1.1;
  ActiveSet found = update_active_set(n.state(), false, 1e-12, 2.0);
  CHECK(found.sliding == Flags{1, 0});
  CHECK(found.direction[0] == 1.0);
  n.sliding = found.sliding;
  n.direction = found.direction;
  CHECK(friction_tilt(n.state())[0] == 0.5);
  SECTION("what slips on keeps slipping")
  {
    n.traction[0] = 1.0;
    n.slip[0] = -0.1;
    CHECK(update_active_set(n.state(), false, 1e-12, 2.0).sliding == Flags{1, 0});
  }
  SECTION("what would slip the other way comes to rest first")
  {
    n.traction[0] = 1.0;
    n.slip[0] = 0.3; // trial traction 1 - 10 * 0.3
    CHECK(update_active_set(n.state(), false, 1e-12, 2.0).sliding == Flags{0, 0});
  }
}

TEST_CASE("multipliers are the forces that equilibrium lacks, per area")
{
  TwoNodes n;
  Values multiplier(2), traction(4);
  evaluate_multipliers(n.state(), n.geometry(), Values{0.2, 3.0, 5.0, 5.0}, Values(4, 0.0), {}, {}, multiplier,
                       traction);
  CHECK(multiplier == Values{6.0, 0.0});
  CHECK(traction[0] == Approx(0.4).epsilon(1e-14));
  CHECK(traction[1] == Approx(0.0).margin(1e-14));
}

TEST_CASE("constraints close the gap, and hold what sticks")
{
  TwoNodes n;
  n.gap[0] = -0.25;
  n.slip[0] = 0.125;
  const Values tilt(4, 0.0);
  const dolfinx_impact::gap::MasterRows facing{{0, 1}, {9}, {1.0}};
  const Constraints c = constrain(n.state(), n.geometry(), tilt, facing);
  REQUIRE(c.size() == 1);
  CHECK(c.nodes[0] == 3);
  CHECK(c.constrained == Flags{1, 1});
  CHECK(c.known == Values{-0.125, 0.25});
  CHECK(constrain(n.state(0.0), n.geometry(), tilt, facing).constrained == Flags{0, 1});
  CHECK_THROWS_AS(constrain(n.state(), n.geometry(), tilt, {{0}, {}, {}}), std::invalid_argument);
}

TEST_CASE("condensed nodes follow their master")
{
  Constraints c = one_over_the_other();
  const Condensation condensation(MPI_COMM_SELF, 4, 0, 2, {c});
  CHECK(condensation.symmetric());
  CHECK(condensation.pinned() == Flags{0, 1, 0, 0});
  Vec y;
  VecCreateSeq(MPI_COMM_SELF, 4, &y);
  for (int i = 0; i < 4; ++i)
    VecSetValue(y, i, i == 1 ? 0.0 : 1.0 + i, INSERT_VALUES);
  CHECK(condensation.increment(y) == Values{1.0, 4.0 - 0.5, 3.0, 4.0});
  VecDestroy(&y);
  // The force on node 0 along the normal goes to node 1: its own equation is the multiplier's.
  CHECK(condensation.residual(Values{1.0, 2.0, 3.0, 4.0}) == Values{1.0, 0.0, 3.0, 6.0});
  CHECK(condensation.unknowns(Values{1.0, 2.0, 3.0, 4.0}) == Values{1.0, 0.0, 3.0, 4.0});
  CHECK_THROWS_AS(condensation.residual(Values{1.0}), std::invalid_argument);
  c.tilt = {0.5, 0.0};
  CHECK_FALSE(Condensation(MPI_COMM_SELF, 4, 0, 2, {c}).symmetric());
  CHECK_THROWS_AS(Condensation(MPI_COMM_SELF, 1, 0, 2, {c}), std::invalid_argument);
}

TEST_CASE("a saddle point has a row for the jump and a column for the force")
{
  const Constraints c = one_over_the_other();
  dolfinx_impact::operators::CooMatrix K;
  dolfinx_impact::operators::CooMatrix::Entries entries;
  for (int i = 0; i < 4; ++i)
    entries.add(i, i, 10.0 * (i + 1));
  K.assign(MPI_COMM_SELF, 4, 4, 2, entries);
  const std::vector<Mat> stiffness{K.matrix()};
  SaddlePoint system(MPI_COMM_SELF, 4, 2, {1});
  CHECK(system.num_unknowns() == 6);
  system.assign(std::vector{c}, Flags{1, 0, 0, 0}, Values{5.0, 0.25}, 2.0);
  CHECK(system.pinned() == Flags{1, 0, 0, 0, 1, 0});
  const Vector x(Values{1.0, 2.0, 3.0, 4.0, 5.0, 6.0}), y(Values(6, 0.0));
  // Rows: K u - 2 C^T f, and -2 times the jump u_1 - u_3; pinned ones are twice their unknown.
  const Values product{2.0, 40.0 - 12.0, 90.0, 160.0 + 12.0, 10.0, 4.0};
  system.mult(stiffness, x.v, y.v);
  CHECK(y.values() == product);
  SECTION("the matrix has the same product, also when it is made again")
  {
    for (int again = 0; again < 2; ++again)
    {
      Mat A = system.assemble(stiffness);
      MatMult(A, x.v, y.v);
      CHECK(y.values() == product);
      MatDestroy(&A);
    }
  }
  SECTION("the right-hand side has the start's forces and the known jump")
  {
    const Values residual{1.0, 2.0, 3.0, 4.0};
    system.load(stiffness, residual, x.v, y.v);
    // Of K times the prescribed unknown no free row sees anything here; the force at the start is 0.25.
    CHECK(y.values() == Values{2.0, -2.0 + 0.5, -3.0, -4.0 - 0.5, 0.0, 1.0});
    CHECK(system.unknowns(residual, Values{9.0, 1.0}) == Values{1.0, 2.0, 3.0, 4.0, 0.0, 0.75});
    CHECK(system.forces(x.v) == Values{5.0, 6.25});
  }
  SECTION("matrices are kept while the pattern stands")
  {
    const Mat before = system.right();
    Constraints other = c;
    other.known = {0.0, 1.0};
    system.assign(std::vector{other}, Flags(4, 0), Values(2, 0.0), 2.0);
    CHECK(system.right() == before);
  }
  SECTION("friction leans on the force's side alone")
  {
    Constraints slips = c;
    slips.tilt = {0.5, 0.0};
    system.assign(std::vector{slips}, Flags(4, 0), Values(2, 0.0), 2.0);
    system.mult(stiffness, x.v, y.v);
    CHECK(y.values() == Values{10.0 - 6.0, 28.0, 90.0 + 6.0, 172.0, 10.0, 4.0});
  }
  CHECK_THROWS_AS(system.assign({}, Flags(4, 0), Values(2, 0.0), 2.0), std::invalid_argument);
  CHECK_THROWS_AS(system.assign(std::vector{c}, Flags(3, 0), Values(2, 0.0), 2.0), std::invalid_argument);
  CHECK_THROWS_AS(SaddlePoint(MPI_COMM_SELF, 1, 2, {1}).assign(std::vector{c}, Flags(1, 0), Values(2, 0.0), 2.0),
                  std::invalid_argument);
}

TEST_CASE("prescribed components are locked where the master moves alike")
{
  // Two nodes of the plane, both prescribed along x; the first is to move by 0.1, the second stays.
  const Flags fixed{1, 0, 1, 0};
  const Values driven{0.1, 0.0, 0.0, 0.0};
  const PrescribedComponents prescribed{2, fixed, driven, 1e-12};
  const std::vector<std::int32_t> nodes{1, 0};
  CHECK(locked_components(prescribed, nodes, {0.0, 0.0, 0.0}) == Flags{1, 0, 0, 0});
  CHECK(locked_components(prescribed, nodes, {0.1, 0.0, 0.0}) == Flags{0, 0, 1, 0});
  CHECK(locked_components(prescribed, nodes, {0.1 * (1 + 1e-10), 0.0, 0.0}) == Flags{0, 0, 1, 0});
  const Values u{0.03, 0.2, 0.0, 0.2}, start(4, 0.0);
  CHECK(remaining_motion(prescribed, nodes, u, start) == Values{0.0, 0.0, 0.1 - 0.03, 0.0});
  CHECK_THROWS_AS(remaining_motion(prescribed, nodes, Values{0.0}, start), std::invalid_argument);
  CHECK_THROWS_AS(locked_components(prescribed, std::vector<std::int32_t>{2}, {0.0, 0.0, 0.0}), std::invalid_argument);
}

TEST_CASE("friction along prescribed directions is driven or kept")
{
  TwoNodes n;
  n.fixed = {1, 0, 0, 0}; // x of the first node, along the surface
  n.frames = frames_at(2, n.normal, n.fixed);
  CoulombFriction friction(2, 2);
  const Flags stuck{1, 0};
  SECTION("driven: the imposed traction starts from the one it had and is raised until nothing slips")
  {
    friction.update_directions(n.usable, n.geometry(), Flags(4, 0));
    CHECK(friction.locked() == Values(8, 0.0));
    CHECK(friction.prescribed() == Values{1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0});
    n.traction = {0.4, 0.0, 0.0, 0.0};
    CHECK(friction.update_imposed(n.state(), Flags{0, 0}, Values(4, 0.0)) == Flags{0, 0});
    CHECK(friction.imposed == Values{0.4, 0.0, 0.0, 0.0});
    n.slip[0] = 1e-3;
    CHECK_FALSE(friction.has_springs());
    const auto springs = friction.update_springs(n.state(), n.geometry(), Values{3.0, 0.0}, Values{2.0, 0.0});
    CHECK(friction.has_springs());
    CHECK(springs.rows == std::vector<std::int32_t>{0});
    // 1000 times the stiffness, over the weight; the block has the area weight^2/cover.
    CHECK(springs.blocks[0] == Approx(0.5 * 1000 * 3.0 / 0.5).epsilon(1e-14));
    CHECK(springs.traction[0] == Approx(6000.0 * 1e-3 - 0.4).epsilon(1e-14));
    friction.raise_imposed(n.state());
    CHECK(friction.imposed[0] == Approx(0.4 - 6.0).epsilon(1e-14));
    CHECK(friction.known_tractions(n.state())[0] == friction.imposed[0]);
  }
  SECTION("locked: the traction of the last converged state, as far as the bound leaves room")
  {
    friction.update_directions(n.usable, n.geometry(), Flags{1, 0, 0, 0});
    CHECK(friction.locked() == Values{1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0});
    CHECK(friction.update_imposed(n.state(), stuck, Values{0.4, 0.0, 0.0, 0.0}) == Flags{1, 0});
    CHECK(friction.imposed == Values{0.4, 0.0, 0.0, 0.0});
    CHECK(friction.update_imposed(n.state(), stuck, Values{0.4, 0.0, 0.0, 0.0}) == Flags{0, 0});
    CHECK(friction.update_imposed(n.state(), stuck, Values{3.0, 0.0, 0.0, 0.0}) == Flags{1, 0});
    CHECK(friction.imposed[0] == Approx(1.0).epsilon(1e-14)); // friction 0.5 times the multiplier 2
    n.sliding = {1, 0};
    friction.update_imposed(n.state(), stuck, Values{3.0, 0.0, 0.0, 0.0});
    CHECK(friction.imposed == Values(4, 0.0));
  }
  SECTION("imposed tractions follow the surface with their size")
  {
    friction.imposed = {0.3, 0.4, 0.0, 0.7};
    friction.update_directions(n.usable, n.geometry(), Flags{1, 0, 0, 0});
    CHECK(friction.imposed == Values{0.5, 0.0, 0.0, 0.0});
  }
  CHECK_THROWS_AS(friction.update_directions(n.usable, n.geometry(), Flags(3, 0)), std::invalid_argument);
}

TEST_CASE("a node that has closed in the step is held by pressure over gap")
{
  TwoNodes n;
  n.opening = {0.25, 0.0};
  n.slip[0] = 0.05;
  CoulombFriction friction(2, 2);
  friction.update_directions(n.usable, n.geometry(), Flags(4, 0));
  const auto springs = friction.update_springs(n.state(), n.geometry(), Values(2, 1.0), Values(2, 1.0));
  CHECK(springs.rows == std::vector<std::int32_t>{0});
  CHECK(springs.blocks == Values{0.5 * 2.0 / 0.25, 0.0, 0.0, 0.0});
  CHECK(springs.traction == Values(4, 0.0)); // slack at the present slip
  n.slip[0] = 0.15;
  CHECK(friction.known_tractions(n.state())[0] == Approx(-0.8).epsilon(1e-14));
  CHECK(friction_tilt(n.state())[0] == Approx(-0.6).epsilon(1e-14));
}

TEST_CASE("multipliers of a saddle point are its forces per area")
{
  TwoNodes n;
  n.frames = frames_at(2, n.normal, n.fixed);
  Values multiplier(2), traction(4);
  take_multipliers(n.state(), n.geometry(), Values{0.3, 2.0, 5.0, 5.0}, Values(4, 0.0), Values(4, 0.1), multiplier,
                   traction);
  CHECK(multiplier == Values{4.0, 0.0});
  CHECK(traction[0] == Approx(0.6 + 0.1).epsilon(1e-14));
  CHECK(traction[2] == 0.0);
}

TEST_CASE("linearised gaps and slips are those of the jump")
{
  TwoNodes n;
  n.gap = {-0.5, 1.0};
  n.slip = {0.25, 0.0, 0.0, 0.0};
  Values gap(2), slip(4);
  add_jump(n.geometry(), Values{1.0, 2.0, 3.0, 4.0}, gap, slip);
  CHECK(gap == Values{1.5, 5.0});
  CHECK(slip == Values{1.25, 0.0, 3.0, 0.0});
  // What the linear state lacks is added where there is a master.
  Values gap_at{0.0, 0.0}, slip_at(4, 0.0);
  const double none = std::numeric_limits<double>::infinity();
  add_linearisation_error(n.state(), n.geometry(), Values{-0.25, none}, Values{0.5, 9.0, 1.0, 1.0}, gap_at, slip_at);
  CHECK(gap_at == Values{0.25, 0.0});
  CHECK(slip_at == Values{0.25, 0.0, 0.0, 0.0});
  CHECK(normal_tractions(n.usable, n.geometry(), Values{1.0, 2.0, 3.0, 4.0}) == Values{4.0, 16.0});
  const Violations found = violations(n.state(), Values{-0.125, -1.0});
  CHECK(found.gap == Values{0.125, 0.0});
  CHECK(found.slip == Values{0.25, 0.0});
  n.traction = {3.0, 4.0, 0.0, 0.0};
  CHECK(rotate_friction_traction(n.state(), n.normal) == Values{5.0, 0.0, 0.0, 0.0});
  CHECK_THROWS_AS(add_jump(n.geometry(), Values(3), gap, slip), std::invalid_argument);
}
