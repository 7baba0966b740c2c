// SPDX-License-Identifier: MIT
// A bar flies against a rigid wall: explicit steps with penalty contact, without Python. While the wave runs to the
// free end and back, the wall feels density * wave speed * velocity per area; then the bar leaves as fast as it came.
// Runs on any number of ranks.
#include <basix/finite-element.h>
#include <cmath>
#include <cstdio>
#include <dolfinx/fem/Function.h>
#include <dolfinx/fem/utils.h>
#include <dolfinx/la/Vector.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/enforcement/node_to_surface/NodePenalty.h>
#include <dolfinx_impact/integrators/CentralDifference.h>
#include <dolfinx_impact/kernels/KernelTable.h>
#include <dolfinx_impact/operators/lump.h>
#include <dolfinx_impact/surface/Surface.h>
#include <functional>
#include <numeric>
#include <petscsys.h>
#include <spdlog/spdlog.h>
#include <vector>

using namespace dolfinx;
using namespace dolfinx_impact;

namespace
{
// Steel without lateral contraction, so that the bar's waves are those of one dimension.
constexpr double E = 207e9, nu = 0.0, density = 7800.0;       // [Pa], [1], [kg/m^3]
constexpr double length = 1.0, height = 0.02, velocity = 1.0; // [m], [m], [m/s]
constexpr int cells_along = 200;

std::vector<operators::Integral> over_cells(const char* form, std::vector<std::int32_t> cells,
                                            const std::vector<double>& constants)
{
  const auto kernels = kernels::find({.name = form, .cell = "quadrilateral", .hypothesis = "plane_strain"});
  return {{kernels.at(0), std::move(cells), constants}};
}

bool run()
{
  auto mesh = std::make_shared<mesh::Mesh<double>>(mesh::create_rectangle<double>(
      MPI_COMM_WORLD, {{{0.0, 0.0}, {length, height}}}, {cells_along, 4}, mesh::CellType::quadrilateral));
  const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                                     basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, false);
  auto V = std::make_shared<fem::FunctionSpace<double>>(fem::create_functionspace(mesh, element, {2}));
  const auto map = V->dofmap()->index_map;
  const std::size_t owned = 2 * map->size_local();
  std::vector<std::int32_t> cells(mesh->topology()->index_map(2)->size_local());
  std::iota(cells.begin(), cells.end(), 0);

  // Lumped mass, complete on ghosts.
  la::Vector<double> mass(map, 2);
  mass.set(0.0);
  const auto cell_masses = operators::cell_masses_hrz(over_cells("mass", cells, {density}).front(), *V);
  for (std::size_t k = 0; k < cell_masses.size(); ++k) // 4 nodes with 2 components in a cell
    mass.mutable_array()[2 * V->dofmap()->cell_dofs(k / 8)[k % 8 / 2] + k % 2] += cell_masses[k];
  mass.scatter_rev(std::plus<double>());
  mass.scatter_fwd();

  // Internal force: one operator for all cells; the integrator gives it the displacements.
  auto u = std::make_shared<fem::Function<double>>(V);
  const auto all = over_cells("linear_elastic.force", cells, {E, nu}),
             none = over_cells("linear_elastic.force", {}, {E, nu});
  const std::map<std::string, std::shared_ptr<const fem::Function<double>>> fields{{"u", u}};
  integrators::FormForces internal{std::make_shared<operators::InternalForce>(mesh, V, none, fields),
                                   std::make_shared<operators::InternalForce>(mesh, V, all, fields), "u", ""};
  integrators::CentralDifference bar(V, internal, true, mass.array(), 0.0, integrators::Scheme::half_step);

  // The end x = 0 is the slave, the wall fills x < 0.
  const auto end = mesh::locate_entities_boundary(*mesh, 1,
                                                  [](auto x)
                                                  {
                                                    std::vector<std::int8_t> marked(x.extent(1));
                                                    for (std::size_t p = 0; p < marked.size(); ++p)
                                                      marked[p] = std::abs(x(0, p)) < 1e-9;
                                                    return marked;
                                                  });
  const gap::Rigid wall{.kind = gap::Rigid::Kind::plane, .gdim = 2, .point = {0, 0, 0}, .direction = {1, 0, 0}};
  auto contact = std::make_shared<enforcement::NodePenalty>(*V, surface::make_surface(*V, end), wall,
                                                            enforcement::NodePenaltyOptions{});
  bar.add_contact(contact, {-1, -1, -1});

  const double c = std::sqrt(E / density), back = 2.0 * length / c;
  const double dt = 0.8 * std::min(length / cells_along, height / 4) / (c * std::sqrt(2.0));
  const int steps = int(1.5 * back / dt);
  bar.set_contact_step(dt);
  std::vector<double> rest(owned, 0.0), flight(owned, 0.0);
  for (std::size_t i = 0; i < owned; i += 2)
    flight[i] = -velocity;
  bar.start(rest, flight);
  std::vector<double> history(steps * bar.row_size());
  const int done = bar.run(std::vector<double>(steps, dt), {}, 0, history);

  // Mean force while the wave is away from both ends of its way, impulse, and energies of the last step.
  double plateau = 0.0, impulse = 0.0;
  int counted = 0;
  for (int k = 0; k < done; ++k)
  {
    const double force = history[k * bar.row_size() + integrators::Energies::size], t = k * dt;
    impulse += force * dt;
    if (t > 0.2 * back && t < 0.8 * back)
    {
      plateau += force;
      ++counted;
    }
  }
  plateau /= counted;
  const double expected = density * c * velocity * height, momentum = density * length * height * velocity;
  const integrators::Energies energy = bar.energies();
  const double before = 0.5 * momentum * velocity, after = energy.kinetic + energy.internal + energy.contact;
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0)
  {
    std::printf("force on the wall / (density c v A) = %.4f\n", plateau / expected);
    std::printf("impulse / (2 m v) = %.4f\n", impulse / (2.0 * momentum));
    std::printf("energy after / before = %.6f\n", after / before);
  }
  return done == steps && std::abs(plateau / expected - 1.0) < 0.01 &&
         std::abs(impulse / (2.0 * momentum) - 1.0) < 0.02 && std::abs(after / before - 1.0) < 0.02;
}
} // namespace

int main(int argc, char* argv[])
{
  PetscInitialize(&argc, &argv, nullptr, nullptr);
  spdlog::set_level(spdlog::level::warn); // DOLFINx tells every step otherwise
  bool passed = false;
  try
  {
    passed = run();
  }
  catch (const std::exception& e)
  {
    std::fprintf(stderr, "explicit_impact: %s\n", e.what());
  }
  PetscFinalize();
  return passed ? 0 : 1;
}
