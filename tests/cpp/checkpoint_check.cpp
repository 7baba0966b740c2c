// SPDX-License-Identifier: MIT
// Problems of all kinds, plastic and in contact, that are saved half way, or restored there, perhaps on other ranks:
//   checkpoint_check write|read|other FOLDER
// prints a norm of each one's end; with `other`, what a problem on another mesh and of another material is told.
#include <basix/finite-element.h>
#include <cmath>
#include <cstdio>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/create_functionspace.h>
#include <dolfinx_impact/common/dolfinx_api.h>
#include <dolfinx_impact/enforcement/mortar/MortarContact.h>
#include <dolfinx_impact/enforcement/node_to_surface/NodePenalty.h>
#include <dolfinx_impact/enforcement/penalty/QuadraturePenalty.h>
#include <dolfinx_impact/problems/KernelBody.h>
#include <dolfinx_impact/problems/checkpoint.h>
#include <dolfinx_impact/problems/explicit_body.h>
#include <dolfinx_impact/surface/Surface.h>
#include <functional>
#include <petscsys.h>
#include <spdlog/spdlog.h>
#include <stdexcept>

using namespace dolfinx;
using namespace dolfinx_impact;

namespace
{
/// A block of plastic steel over a floor at y = 0.
struct Block
{
  explicit Block(std::size_t cells)
  {
    mesh = std::make_shared<mesh::Mesh<double>>(mesh::create_rectangle<double>(
        MPI_COMM_WORLD, {{{0.0, 0.0}, {1.0, 2.0}}}, {cells, 6}, mesh::CellType::quadrilateral));
    const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                                       basix::element::lagrange_variant::gll_warped,
                                                       basix::element::dpc_variant::unset, false);
    V = std::make_shared<fem::FunctionSpace<double>>(dolfinx_impact::common::create_functionspace(mesh, element, {2}));
    u = std::make_shared<fem::Function<double>>(V);
    v = std::make_shared<fem::Function<double>>(V);
    mesh->topology_mutable()->create_connectivity(1, 2);
  }

  static auto at(double y)
  {
    return [y](auto x)
    {
      std::vector<std::int8_t> marked(x.extent(1));
      for (std::size_t p = 0; p < marked.size(); ++p)
        marked[p] = std::abs(x(1, p) - y) < 1e-9;
      return marked;
    };
  }
  surface::Facets lower() const { return surface::make_surface(*V, mesh::locate_entities_boundary(*mesh, 1, at(0.0))); }
  /// The same velocity everywhere.
  void move(double vx, double vy)
  {
    for (std::size_t i = 0; i < v->x()->array().size(); i += 2)
    {
      dolfinx_impact::common::array(*v->x())[i] = vx;
      dolfinx_impact::common::array(*v->x())[i + 1] = vy;
    }
  }
  double norm() const
  {
    const std::size_t owned = 2 * V->dofmap()->index_map->size_local();
    double sum = 0.0;
    for (std::size_t i = 0; i < owned; ++i)
      sum += u->x()->array()[i] * u->x()->array()[i];
    MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    return std::sqrt(sum);
  }

  problems::KernelMaterial steel{
      "j2.small.linear", {{"E", {1.0}}, {"nu", {0.3}}, {"yield_stress", {0.01}}, {"modulus", {0.1}}}, "plane_strain"};
  gap::Rigid floor{.kind = gap::Rigid::Kind::plane, .gdim = 2, .direction = {0, 1, 0}};
  std::shared_ptr<mesh::Mesh<double>> mesh;
  std::shared_ptr<fem::FunctionSpace<double>> V;
  std::shared_ptr<fem::Function<double>> u, v;
};

struct Run
{
  bool read;
  std::string folder;
  std::size_t cells = 4;
  files::Attributes identity = {{"steel", 1.0}};

  /// Save after the first half, or restore in its place.
  template <typename Problem, typename Half>
  void half(const char* name, Problem& problem, Half half) const
  {
    const std::string path = folder + "/" + name + ".h5";
    if (read)
      return problems::restore(path, problem, identity);
    half();
    problems::save(path, problem, identity);
  }

  double in_statics() const
  {
    Block b(cells);
    auto top = std::make_shared<fem::Function<double>>(b.V);
    const auto press = [&](double by)
    {
      for (std::size_t i = 1; i < top->x()->array().size(); i += 2)
        dolfinx_impact::common::array(*top->x())[i] = -by;
    };
    const problems::BoundaryConditions bcs{
        std::make_shared<fem::DirichletBC<double>>(top, fem::locate_dofs_geometrical(*b.V, Block::at(2.0)))};
    auto contact = std::make_shared<enforcement::QuadraturePenalty>("floor", b.V, b.lower(), b.floor,
                                                                    enforcement::PenaltyOptions{.penalty = 10.0});
    auto body = std::make_shared<problems::KernelBody>(b.u, b.steel);
    problems::StaticProblem problem(b.u, body, bcs, {contact});
    for (std::size_t i = 0; i < body->loads().size(); i += 2)
      body->loads()[i] = 1e-5; // along x, applied in parts
    problem.add_load(body->loads());
    half("static", problem,
         [&]
         {
           press(0.05);
           problem.solve({.steps = 4});
         });
    press(0.08);
    problem.solve({.steps = 3});
    return b.norm();
  }

  double in_explicit() const
  {
    Block b(cells);
    b.move(0.02, -0.2);
    auto contact = std::make_shared<enforcement::NodePenalty>(*b.V, b.lower(), b.floor,
                                                              enforcement::NodePenaltyOptions{{.friction = 0.3}});
    problems::ExplicitProblem problem(b.u, b.v, problems::explicit_body(b.u, {{b.steel, 1.0}}), {}, {},
                                      {{contact, "floor"}});
    half("explicit", problem, [&] { problem.advance(1.0); });
    problem.advance(2.0);
    return b.norm();
  }

  /// Saved between two steps of one call: the steps that are left are those that this call had chosen.
  double within_a_call() const
  {
    Block b(cells);
    b.move(0.02, -0.2);
    auto contact = std::make_shared<enforcement::NodePenalty>(*b.V, b.lower(), b.floor,
                                                              enforcement::NodePenaltyOptions{{.friction = 0.3}});
    problems::ExplicitProblem problem(b.u, b.v, problems::explicit_body(b.u, {{b.steel, 1.0}}), {}, {},
                                      {{contact, "floor"}});
    const std::string path = folder + "/within.h5";
    if (read)
    {
      problems::restore(path, problem, identity);
      problem.advance(2.0);
      return b.norm();
    }
    bool saved = false;
    problem.advance(2.0, {},
                    [&](double t, const state::State&)
                    {
                      if (!saved && t > 1.1)
                        problems::save(path, problem, identity);
                      saved = t > 1.1;
                    });
    return b.norm();
  }

  double in_implicit() const
  {
    Block b(cells);
    b.move(0.0, -0.1);
    const std::vector<problems::PrescribedMotion> supports;
    const problems::ImplicitBody body =
        problems::implicit_body(b.u, b.v, {{b.steel, 1.0}}, problems::prescribed_dofs(*b.V, supports));
    auto contact = std::make_shared<enforcement::MortarContact>(
        b.V, b.lower(), std::make_shared<const gap::Rigid>(b.floor), enforcement::MortarOptions{},
        problems::prescribed_dofs(*b.V, supports));
    problems::NewmarkProblem problem(b.u, b.v, body, supports, {}, {{contact}});
    half("implicit", problem, [&] { problem.advance(0.5, {.dt = 0.1}); });
    problem.advance(1.0, {.dt = 0.1});
    return b.norm();
  }
};

void say(const char* name, const std::function<double()>& work)
{
  std::string text;
  try
  {
    char number[40];
    std::snprintf(number, sizeof number, "%.12e", work());
    text = number;
  }
  catch (const std::exception& e)
  {
    text = e.what();
  }
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  std::printf("%d %s: %s\n", rank, name, text.c_str());
}
} // namespace

int main(int argc, char* argv[])
{
  PetscInitialize(&argc, &argv, nullptr, nullptr);
  spdlog::set_level(spdlog::level::warn);
  const std::string mode = argv[1];
  for (const auto& [name, work] :
       std::initializer_list<std::pair<const char*, double (Run::*)() const>>{{"static", &Run::in_statics},
                                                                              {"explicit", &Run::in_explicit},
                                                                              {"within", &Run::within_a_call},
                                                                              {"implicit", &Run::in_implicit}})
  {
    Run run{mode != "write", argv[2]};
    if (mode != "other")
      say(name, [&, work = work] { return (run.*work)(); });
    else
    {
      run.cells = 5;
      say(name, [&, work = work] { return (run.*work)(); });
      run.cells = 4;
      run.identity[0].value = 2.0;
      say(name, [&, work = work] { return (run.*work)(); });
    }
  }
  PetscFinalize();
  return 0;
}
