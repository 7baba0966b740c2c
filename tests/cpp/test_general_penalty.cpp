// SPDX-License-Identifier: MIT
// A bar that is bent into a ring meets itself: general contact in an equilibrium, from C++ alone.
#include <basix/finite-element.h>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx/mesh/utils.h>
#include <dolfinx_impact/common/create_functionspace.h>
#include <dolfinx_impact/enforcement/penalty/QuadraturePenalty.h>
#include <numbers>
#include <span>
#include <stdexcept>
#include <vector>

using Catch::Approx;
using namespace dolfinx_impact;
using namespace dolfinx_impact::enforcement;

namespace
{
constexpr double bar_length = 2.0, ring_radius = bar_length / (2.0 * std::numbers::pi);

/// A bar along x, of eight cells, and all of its facets.
struct BentBar
{
  explicit BentBar(int dim) : gdim(dim)
  {
    if (dim == 2)
      mesh = std::make_shared<dolfinx::mesh::Mesh<double>>(dolfinx::mesh::create_rectangle<double>(
          MPI_COMM_SELF, {{{0.0, 0.0}, {bar_length, 0.2}}}, {8, 1}, dolfinx::mesh::CellType::quadrilateral));
    else
      mesh = std::make_shared<dolfinx::mesh::Mesh<double>>(
          dolfinx::mesh::create_box<double>(MPI_COMM_SELF, {{{0.0, 0.0, 0.0}, {bar_length, 0.2, 0.2}}}, {8, 1, 1},
                                            dolfinx::mesh::CellType::hexahedron));
    V = std::make_shared<surface::FunctionSpace>(dolfinx_impact::common::create_functionspace(
        mesh,
        basix::create_element<double>(basix::element::family::P,
                                      dim == 2 ? basix::cell::type::quadrilateral : basix::cell::type::hexahedron, 1,
                                      basix::element::lagrange_variant::gll_warped,
                                      basix::element::dpc_variant::unset, false),
        {std::size_t(dim)}));
    mesh->topology_mutable()->create_connectivity(dim - 1, dim);
    facets = surface::make_surface(*V, dolfinx::mesh::exterior_facet_indices(*mesh->topology()));
    x = V->tabulate_dof_coordinates(false);
  }

  /// Displacements that bend the bar around an angle, end against end.
  std::vector<double> bent(double angle) const
  {
    std::vector<double> u(x.size() / 3 * gdim);
    for (std::size_t node = 0; node < x.size() / 3; ++node)
    {
      const double turn = angle * x[3 * node] / bar_length, r = ring_radius + x[3 * node + 1];
      u[node * gdim] = r * std::sin(turn) - x[3 * node];
      u[node * gdim + 1] = r * std::cos(turn) - x[3 * node + 1];
    }
    return u;
  }

  int gdim;
  std::shared_ptr<dolfinx::mesh::Mesh<double>> mesh;
  std::shared_ptr<const surface::FunctionSpace> V;
  surface::Facets facets;
  std::vector<double> x;
};

const std::span<const search::NamedPair> no_pairs;
constexpr double whole_turn = 2.0 * std::numbers::pi;
} // namespace

TEST_CASE("a bar that is bent into a ring meets itself", "[general]")
{
  for (const int gdim : {2, 3})
  {
    const BentBar bar(gdim);
    PenaltyOptions options;
    options.penalty = 100.0;
    QuadraturePenalty contact("ring", bar.V, bar.facets, no_pairs, options);
    CHECK(contact.meets_itself());
    contact.begin_step(bar.bent(whole_turn - 0.05), {});
    contact.update_gap(bar.bent(whole_turn - 0.05));
    CHECK(contact.num_active() == 0);
    contact.update_gap(bar.bent(whole_turn + 0.02));
    contact.update_active_set(true);
    const int per_face = contact.forces().points().per_facet;
    CHECK(contact.num_active() == 2 * per_face);
    // Half of the penalty from both sides; the ends overlap by the angle times the distance from the middle.
    const std::vector<double> pressure = contact.pressure(), gap = contact.gap(), points = contact.points();
    for (std::size_t q = 0; q < gap.size(); ++q)
      if (pressure[q] > 0.0)
      {
        CHECK(pressure[q] == Approx(-50.0 * gap[q]));
        CHECK(gap[q] == Approx(-0.02 * std::hypot(points[q * gdim], points[q * gdim + 1])).epsilon(1e-3));
      }
    CHECK(contact.deepest() < 0.02 * (ring_radius + 0.2));
    std::vector<double> sum(3, 0.0);
    double largest = 0.0;
    const std::vector<double> forces = contact.contact_forces();
    for (std::size_t i = 0; i < forces.size(); ++i)
    {
      sum[i % gdim] += forces[i];
      largest = std::max(largest, std::abs(forces[i]));
    }
    CHECK(largest > 1e-4);
    for (const double component : sum)
      CHECK(std::abs(component) < 1e-14);
    CHECK(contact.tangent() != nullptr);
    contact.accept_step();
    // Accepted, the overlap is known when the next increment begins with it.
    contact.begin_step(bar.bent(whole_turn + 0.02), {});
    contact.update_gap(bar.bent(whole_turn + 0.03));
    CHECK(contact.num_active() == 2 * per_face);
    // A run that is restored knows it, too.
    QuadraturePenalty again("ring", bar.V, bar.facets, no_pairs, options);
    contact.update_gap(bar.bent(whole_turn + 0.02));
    again.resume(contact.saved_state(), bar.bent(whole_turn + 0.02));
    CHECK(again.num_active() == 2 * per_face);
    // One that does not know takes the ends for surfaces that were never in front of each other.
    QuadraturePenalty other("ring", bar.V, bar.facets, no_pairs, options);
    other.begin_step(bar.bent(whole_turn + 0.3), {});
    other.update_gap(bar.bent(whole_turn + 0.3));
    CHECK(other.num_active() == 0);
  }
}

TEST_CASE("general contact refuses what belongs to pairs", "[general]")
{
  const BentBar bar(2);
  PenaltyOptions options;
  options.penalty = 1.0;
  options.augmented = true;
  CHECK_THROWS_AS(QuadraturePenalty("ring", bar.V, bar.facets, no_pairs, options), std::invalid_argument);
  options.augmented = false;
  options.adjustment.offset = 0.01;
  CHECK_THROWS_AS(QuadraturePenalty("ring", bar.V, bar.facets, no_pairs, options), std::invalid_argument);
  const std::vector<search::NamedPair> many(30, {bar.facets, bar.facets});
  options.adjustment.offset = 0.0;
  CHECK_THROWS_AS(QuadraturePenalty("ring", bar.V, bar.facets, many, options), std::invalid_argument);
}
