// SPDX-License-Identifier: MIT
// A bar flies against a rigid wall: explicit steps with penalty contact, without Python. While the wave runs to the
// free end and back, the wall feels density * wave speed * velocity per area; then the bar leaves as fast as it came.
// Runs on any number of ranks.
#include "demo.h"
#include <basix/finite-element.h>
#include <cmath>
#include <cstdio>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/dolfinx_api.h>
#include <dolfinx_impact/enforcement/node_to_surface/NodePenalty.h>
#include <dolfinx_impact/problems/ExplicitProblem.h>
#include <dolfinx_impact/problems/explicit_body.h>
#include <dolfinx_impact/surface/Surface.h>

using namespace dolfinx;
using namespace dolfinx_impact;

namespace
{
// Steel without lateral contraction, so that the bar's waves are those of one dimension.
constexpr double E = 207e9, density = 7800.0;                 // [Pa], [kg/m^3]
constexpr double length = 1.0, height = 0.02, velocity = 1.0; // [m], [m], [m/s]

bool run()
{
  auto mesh = std::make_shared<mesh::Mesh<double>>(mesh::create_rectangle<double>(
      MPI_COMM_WORLD, {{{0.0, 0.0}, {length, height}}}, {200, 4}, mesh::CellType::quadrilateral));
  const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                                     basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, false);
  auto V = std::make_shared<fem::FunctionSpace<double>>(create_functionspace(mesh, element, {2}));
  auto u = std::make_shared<fem::Function<double>>(V), v = std::make_shared<fem::Function<double>>(V);
  for (std::size_t i = 0; i < v->x()->array().size(); i += 2)
    dolfinx_impact::common::array(*v->x())[i] = -velocity;

  // The end x = 0 is the slave, the wall fills x < 0.
  const auto end = mesh::locate_entities_boundary(*mesh, 1,
                                                  [](auto x)
                                                  {
                                                    std::vector<std::int8_t> marked(x.extent(1));
                                                    for (std::size_t p = 0; p < marked.size(); ++p)
                                                      marked[p] = std::abs(x(0, p)) < 1e-9;
                                                    return marked;
                                                  });
  const gap::Rigid wall{.kind = gap::Rigid::Kind::plane, .gdim = 2, .direction = {1, 0, 0}};
  auto contact = std::make_shared<enforcement::NodePenalty>(*V, surface::make_surface(*V, end), wall);

  const problems::KernelMaterial steel{"linear_elastic", {{"E", {E}}, {"nu", {0.0}}}, "plane_strain"};
  problems::ExplicitProblem bar(u, v, problems::explicit_body(u, {{steel, density}}), {}, {}, {{contact, "wall"}});
  const double before = bar.energies().kinetic, c = std::sqrt(E / density), back = 2.0 * length / c;
  bar.advance(1.5 * back);

  // Mean force while the wave is away from both ends of its way, impulse, and energies at the end.
  double plateau = 0.0, impulse = 0.0;
  const auto& history = bar.history();
  const double dt = bar.time() / double(bar.step());
  for (std::size_t k = 0; k < history.num_rows(); ++k)
  {
    const auto row = history.row(k);
    const double time = row[0], push = row[1 + integrators::Energies::size] * dt;
    impulse += push;
    plateau += time > 0.2 * back && time < 0.8 * back ? push / (0.6 * back) : 0.0;
  }
  const double expected = density * c * velocity * height, momentum = density * length * height * velocity;
  const integrators::Energies energy = bar.energies();
  const double after = energy.kinetic + energy.internal + energy.contact;
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0)
  {
    std::printf("force on the wall / (density c v A) = %.4f\n", plateau / expected);
    std::printf("impulse / (2 m v) = %.4f\n", impulse / (2.0 * momentum));
    std::printf("energy after / before = %.6f\n", after / before);
  }
  return std::abs(plateau / expected - 1.0) < 0.01 && std::abs(impulse / (2.0 * momentum) - 1.0) < 0.02 &&
         std::abs(after / before - 1.0) < 0.02;
}
} // namespace

int main(int argc, char* argv[])
{
  return run_demo(argc, argv, "explicit_impact", run);
}
