// SPDX-License-Identifier: MIT
#include "arrays.h"
#include "dolfinx_impact/operators/RigidBodyModes.h"
#include "dolfinx_impact/solve/Increment.h"
#include "dolfinx_impact/solve/LinearSolver.h"
#include "dolfinx_impact/solve/LinearSystem.h"
#include <algorithm>
#include <caster_petsc.h>
#include <nanobind/stl/function.h>

using namespace dolfinx_impact::solve;
using dolfinx_impact::enforcement::Condensation;
using dolfinx_impact::enforcement::SaddlePoint;
using dolfinx_impact::operators::RigidBodyModes;
typedef dolfinx::fem::FunctionSpace<double> Space;

namespace
{
using namespace dolfinx_impact::bindings;
typedef nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu> Mask;

std::vector<std::int8_t> bytes(const Mask& mask)
{
  return {mask.data(), mask.data() + mask.size()};
}

std::span<const double> view(const Values& values)
{
  return {values.data(), values.size()};
}

std::vector<Mat> matrices(const nb::list& values)
{
  std::vector<Mat> out;
  for (nb::handle value : values)
  {
    nb::detail::make_caster<Mat> caster;
    if (!caster.from_python(value, 0, nullptr))
      throw nb::type_error("a list of PETSc matrices is needed");
    out.push_back(static_cast<Mat&>(caster));
  }
  return out;
}

nb::object as_ksp(KSP ksp)
{
  if (!PyPetscKSP_New && import_petsc4py() != 0)
    throw std::runtime_error("petsc4py cannot be imported");
  return nb::steal(PyPetscKSP_New(ksp));
}

void bind_systems(nb::module_& m)
{
  nb::class_<LinearSystem>(m, "LinearSystem", "A linear system whose unknowns stand for increments of displacement")
      .def("mult", &LinearSystem::mult, nb::arg("x"), nb::arg("y"), "y = A x. Collective")
      .def("assemble", &LinearSystem::assemble, nb::rv_policy::take_ownership, "A as a matrix of its own. Collective")
      .def(
          "load", [](LinearSystem& self, Values residual, Vec values, Vec b) { self.load(view(residual), values, b); },
          nb::arg("residual"), nb::arg("values"), nb::arg("b"), "Right-hand side. Collective")
      .def(
          "displacements", [](LinearSystem& self, Vec y) { return take(self.displacements(y)); }, nb::arg("y"),
          "Increments of displacement that unknowns stand for. Collective")
      .def("create_vector", &LinearSystem::create_vector, nb::rv_policy::take_ownership, "A vector of the unknowns")
      .def_prop_ro(
          "pinned",
          [](const LinearSystem& self)
          {
            const auto pinned = self.pinned();
            return take(std::vector<std::int8_t>(pinned.begin(), pinned.end()));
          },
          nb::rv_policy::move)
      .def_prop_ro("symmetric", &LinearSystem::symmetric);
  nb::class_<CondensedSystem, LinearSystem>(m, "CondensedSystem", "Multipliers condensed, or no multipliers")
      .def(
          "__init__",
          [](CondensedSystem* self, Mat K, nb::list extra, bool symmetric, Condensation* condensation, Mask pinned,
             double diagonal)
          { new (self) CondensedSystem(K, matrices(extra), symmetric, condensation, bytes(pinned), diagonal); },
          nb::arg("K"), nb::arg("extra"), nb::arg("symmetric"), nb::arg("condensation").none(), nb::arg("pinned"),
          nb::arg("diagonal"), nb::keep_alive<1, 2>(), nb::keep_alive<1, 3>(), nb::keep_alive<1, 5>());
  nb::class_<SaddlePointSystem, LinearSystem>(m, "SaddlePointSystem", "Multipliers kept as unknowns")
      .def(
          "__init__", [](SaddlePointSystem* self, Mat K, nb::list extra, SaddlePoint& rows)
          { new (self) SaddlePointSystem(K, matrices(extra), rows); }, nb::arg("K"), nb::arg("extra"), nb::arg("rows"),
          nb::keep_alive<1, 2>(), nb::keep_alive<1, 3>(), nb::keep_alive<1, 4>());
}

void bind_linear_solver(nb::module_& m)
{
  nb::class_<LinearSolverLimits>(m, "LinearSolverLimits", "Which systems are factorised, by dimension of the mesh")
      .def(nb::init<>())
      .def_rw("largest_direct", &LinearSolverLimits::largest_direct)
      .def_rw("largest_last_resort", &LinearSolverLimits::largest_last_resort)
      .def_rw("keep_preconditioner", &LinearSolverLimits::keep_preconditioner);
  nb::class_<LinearSolver>(m, "LinearSolver", "A KSP with options of its own; every solution is checked")
      .def(
          "__init__",
          [](LinearSolver* self, std::shared_ptr<const Space> V, std::map<std::string, std::string> options,
             const std::string& prefix, bool indefinite, const LinearSolverLimits& limits,
             std::function<void(const std::string&)> warn)
          { new (self) LinearSolver(*V, options, prefix, indefinite, limits, std::move(warn)); },
          nb::arg("V"), nb::arg("options"), nb::arg("prefix"), nb::arg("indefinite"), nb::arg("limits"),
          nb::arg("warn"), "Collective")
      .def("solve", &LinearSolver::solve, nb::arg("system"), nb::arg("b"), nb::arg("x"), nb::arg("rtol") = 1e-10,
           "Solve; returns what is wrong, or an empty text. Collective")
      .def(
          "factors",
          [](const LinearSolver& self, const LinearSystem& system) -> nb::object
          {
            Mat factors = self.factors(system);
            return factors ? nb::cast(factors, nb::rv_policy::reference) : nb::none();
          },
          nb::arg("system"), "Factors of the system, if it is the one that was factorised last")
      .def("reset", &LinearSolver::reset, "Forget the preconditioner. Collective")
      .def("warn_of_unused", &LinearSolver::warn_of_unused)
      .def("set_near_nullspace", &LinearSolver::set_near_nullspace, nb::arg("A"))
      .def_prop_ro("direct", &LinearSolver::direct)
      .def_prop_ro("ksp", [](const LinearSolver& self) { return as_ksp(self.ksp()); })
      .def_prop_ro("num_set_ups", &LinearSolver::num_set_ups)
      .def_prop_ro("num_iterations", &LinearSolver::num_iterations);
}
} // namespace

void dolfinx_impact::bindings::solve(nb::module_& m)
{
  bind_systems(m);
  bind_linear_solver(m);
}
