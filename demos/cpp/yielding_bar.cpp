// SPDX-License-Identifier: MIT
// A steel bar is pushed at one end faster than it can bear elastically: an elastic wave runs ahead with the yield
// stress, a plastic one follows more slowly. Implicit steps with J2 plasticity, without Python. Von Karman's theory of
// one-dimensional plastic waves gives the force on the driven end. Runs on any number of ranks.
#include "demo.h"
#include <basix/finite-element.h>
#include <cmath>
#include <cstdio>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/problems/NewmarkProblem.h>

using namespace dolfinx;
using namespace dolfinx_impact;

namespace
{
constexpr double E = 207e9, nu = 0.3, density = 7800.0;        // [Pa], [1], [kg/m^3]
constexpr double yield_stress = 400e6, modulus = 20e9;         // of linear hardening [Pa]
constexpr double length = 1.0, width = 0.005, velocity = 15.0; // [m], [m], [m/s]

bool run()
{
  auto mesh = std::make_shared<mesh::Mesh<double>>(mesh::create_box<double>(
      MPI_COMM_WORLD, {{{0.0, 0.0, 0.0}, {length, width, width}}}, {100, 1, 1}, mesh::CellType::hexahedron));
  const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::hexahedron, 1,
                                                     basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, false);
  auto V = std::make_shared<fem::FunctionSpace<double>>(create_functionspace(mesh, element, {3}));
  auto u = std::make_shared<fem::Function<double>>(V), v = std::make_shared<fem::Function<double>>(V);

  // The end x = 0 moves with constant velocity; y = 0 and z = 0 are planes of symmetry, the other sides are free.
  std::vector<problems::PrescribedMotion> supports;
  for (int axis = 0; axis < 3; ++axis)
  {
    const auto face = mesh::locate_entities_boundary(*mesh, 2,
                                                     [&](auto x)
                                                     {
                                                       std::vector<std::int8_t> marked(x.extent(1));
                                                       for (std::size_t p = 0; p < marked.size(); ++p)
                                                         marked[p] = std::abs(x(axis, p)) < 1e-9;
                                                       return marked;
                                                     });
    auto W = std::make_shared<fem::FunctionSpace<double>>(V->sub({axis}));
    const auto dofs = fem::locate_dofs_topological(*mesh->topology_mutable(), *W->dofmap(), 2, face);
    supports.push_back({std::make_shared<fem::DirichletBC<double>>(axis == 0 ? velocity : 0.0, dofs, W)});
  }
  supports[0].amplitude = problems::FunctionOfTime([](double time) { return time; });

  const problems::KernelMaterial steel{
      "j2.small.linear", {{"E", {E}}, {"nu", {nu}}, {"yield_stress", {yield_stress}}, {"modulus", {modulus}}}};
  const auto body = problems::implicit_body(u, v, {{steel, density}}, problems::prescribed_dofs(*V, supports));
  problems::NewmarkOptions options;
  options.scheme = integrators::ImplicitScheme::generalised_alpha(0.5);
  problems::NewmarkProblem bar(u, v, body, supports, {}, {}, options);
  const double fast = std::sqrt(E / density), slow = std::sqrt(E * modulus / (E + modulus) / density);
  const double until = 0.7 * length / fast;
  bar.advance(until, {.dt = length / 100 / fast});

  // Speed behind the elastic wave and stress behind the plastic one, from the balance of momentum.
  const double elastic = yield_stress / (density * fast);
  const double stress = yield_stress + density * slow * (velocity - elastic), way = velocity * until;
  const integrators::Energies energy = bar.energies();
  const double force = energy.external / way, expected = stress * width * width;
  // The plastic wave leaves this plastic strain behind it, at stresses from the yield stress to the present one.
  const double strain = yield_stress / E + (velocity - elastic) / slow - stress / E;
  const double plastic = 0.5 * (yield_stress + stress) * strain * slow * until * width * width;
  const double drift = bar.history().drift(energy);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0)
  {
    std::printf("force on the end / von Karman's = %.4f\n", force / expected);
    std::printf("plastic energy / von Karman's = %.4f\n", energy.plastic / plastic);
    std::printf("steps %lld, drift of the energy %.1e\n", (long long)bar.step(), drift);
  }
  // Waves have fronts of some cells, and the bar's sides have inertia, which the theory leaves out.
  return std::abs(force / expected - 1.0) < 0.02 && std::abs(energy.plastic / plastic - 1.0) < 0.03 &&
         std::abs(drift) < 0.02;
}
} // namespace

int main(int argc, char* argv[])
{
  return run_demo(argc, argv, "yielding_bar", run);
}
