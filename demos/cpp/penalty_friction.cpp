// SPDX-License-Identifier: MIT
// A block is pressed on a rigid plane and dragged along it: penalty contact with Coulomb friction in two load steps,
// without Python. Pressed, the force is that of two springs in series; dragged, friction is the coefficient times the
// normal force. Runs on any number of ranks.
#include "demo.h"
#include <array>
#include <basix/finite-element.h>
#include <cmath>
#include <cstdio>
#include <dolfinx/fem/DirichletBC.h>
#include <dolfinx/fem/Function.h>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/dolfinx_api.h>
#include <dolfinx_impact/enforcement/penalty/QuadraturePenalty.h>
#include <dolfinx_impact/problems/KernelBody.h>
#include <dolfinx_impact/problems/StaticProblem.h>
#include <dolfinx_impact/surface/Surface.h>
#include <vector>

using namespace dolfinx;
using namespace dolfinx_impact;

namespace
{
constexpr double E = 1000.0, nu = 0.0, friction = 0.3, penalty = 1e5, width = 2.0, height = 1.0, pressed = 0.01;

/// Marks points at a height.
auto at_height(double y)
{
  return [y](auto x)
  {
    std::vector<std::int8_t> marked(x.extent(1));
    for (std::size_t p = 0; p < marked.size(); ++p)
      marked[p] = std::abs(x(1, p) - y) < 1e-9;
    return marked;
  };
}

bool run()
{
  auto mesh = std::make_shared<mesh::Mesh<double>>(mesh::create_rectangle<double>(
      MPI_COMM_WORLD, {{{0.0, 0.0}, {width, height}}}, {12, 6}, mesh::CellType::quadrilateral));
  const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                                     basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, false);
  auto V = std::make_shared<fem::FunctionSpace<double>>(create_functionspace(mesh, element, {2}));
  auto u = std::make_shared<fem::Function<double>>(V), top = std::make_shared<fem::Function<double>>(V);
  const problems::KernelMaterial material{"linear_elastic", {{"E", {E}}, {"nu", {nu}}}, "plane_strain"};
  problems::BoundaryConditions bcs{
      std::make_shared<fem::DirichletBC<double>>(top, fem::locate_dofs_geometrical(*V, at_height(height)))};

  const auto bottom = mesh::locate_entities_boundary(*mesh, 1, at_height(0.0));
  const gap::Rigid plane{.kind = gap::Rigid::Kind::plane, .gdim = 2, .direction = {0, 1, 0}};
  auto contact = std::make_shared<enforcement::QuadraturePenalty>(
      "block on plane", V, surface::make_surface(*V, bottom), plane,
      enforcement::PenaltyOptions{.penalty = penalty, .friction = friction});
  problems::StaticProblem problem(u, std::make_shared<problems::KernelBody>(u, material), bcs, {contact});

  std::array<double, 3> force[2]; // on the block, of both steps
  for (int step = 0; step < 2; ++step)
  {
    std::span<double> moved = dolfinx_impact::common::array(*top->x());
    for (std::size_t i = 0; i < moved.size(); ++i)
      moved[i] = i % 2 ? -pressed : step * 0.5 * height;
    problem.solve();
    force[step] = contact->totals().force;
  }
  const double normal = force[0][1] / (width * pressed / (height / E + 1.0 / penalty));
  const double slipping = -force[1][0] / (friction * force[1][1]);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0)
    std::printf("normal force / exact = %.12f\nfriction / (coefficient * normal force) = %.12f\n", normal, slipping);
  return std::abs(normal - 1.0) < 1e-9 && std::abs(slipping - 1.0) < 1e-9;
}
} // namespace

int main(int argc, char* argv[])
{
  return run_demo(argc, argv, "penalty_friction", run);
}
