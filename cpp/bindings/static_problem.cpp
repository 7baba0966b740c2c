// SPDX-License-Identifier: MIT
#include "arrays.h"
#include "dolfinx_impact/problems/static_state.h"
#include <nanobind/stl/function.h>

namespace nb = nanobind;
using namespace dolfinx_impact::problems;

namespace
{
using dolfinx_impact::bindings::take;
using dolfinx_impact::enforcement::StaticContact;
using dolfinx_impact::solve::EquilibriumProblem;
using dolfinx_impact::solve::Increment;
using dolfinx_impact::solve::LinearSolverLimits;
typedef nb::ndarray<double, nb::c_contig, nb::device::cpu> Changeable;
typedef std::function<void(const std::string&)> Line;

SolveOptions solve_options(int steps, double rtol, double atol, int max_iterations, int cut_backs)
{
  return {.steps = steps, .rtol = rtol, .atol = atol, .max_iterations = max_iterations, .cut_backs = cut_backs};
}
} // namespace

void dolfinx_impact::bindings::static_problem(nb::module_& m)
{
  nb::class_<StaticProblem>(m, "StaticProblem", "Equilibrium of bodies, in contact or not")
      .def(
          "__init__",
          [](StaticProblem* self, std::shared_ptr<dolfinx::fem::Function<double>> u,
             std::shared_ptr<dolfinx_impact::solve::Body> body, BoundaryConditions bcs,
             std::vector<std::shared_ptr<StaticContact>> contacts, std::map<std::string, std::string> petsc,
             const std::string& prefix, bool axisymmetric, const LinearSolverLimits& limits, Line warn)
          {
            new (self) StaticProblem(std::move(u), std::move(body), std::move(bcs), std::move(contacts),
                                     {std::move(petsc), prefix, axisymmetric, limits, std::move(warn)});
          },
          nb::arg("u"), nb::arg("body"), nb::arg("bcs"), nb::arg("contacts"), nb::arg("petsc"), nb::arg("prefix"),
          nb::arg("axisymmetric"), nb::arg("limits"), nb::arg("warn"), "Collective")
      .def("share_linear_solver", &StaticProblem::share_linear_solver, nb::arg("other"),
           "Solve with the linear solver of another problem, and its factors while they serve. Collective")
      .def(
          "add_load", [](StaticProblem& self, Changeable value, Changeable reached)
          { self.add_load({{value.data(), value.size()}, {reached.data(), reached.size()}}); }, nb::arg("value"),
          nb::arg("reached"), nb::keep_alive<1, 2>(), nb::keep_alive<1, 3>(),
          "A load that is applied in parts: views of its value and of that which was reached")
      .def(
          "add_rigid_body",
          [](StaticProblem& self, std::vector<std::size_t> contacts, std::array<bool, 6> fixed, Changeable force,
             Changeable torque)
          {
            self.add_rigid_body(std::move(contacts), fixed, {force.data(), force.size()},
                                {torque.data(), torque.size()});
          },
          nb::arg("contacts"), nb::arg("fixed"), nb::arg("force"), nb::arg("torque"), nb::keep_alive<1, 4>(),
          nb::keep_alive<1, 5>(), "A rigid master that loads and contacts move; views of force and torque on it")
      .def(
          "turn_obstacle", [](StaticProblem& self, std::size_t contact, Changeable angle, Changeable reached)
          { self.turn_obstacle(contact, {{angle.data(), angle.size()}, {reached.data(), reached.size()}}); },
          nb::arg("contact"), nb::arg("angle"), nb::arg("reached"), nb::keep_alive<1, 3>(), nb::keep_alive<1, 4>(),
          "Turn a contact's rigid master: views of its rotation vector, and of that which was reached")
      .def("move_obstacle", &StaticProblem::move_obstacle, nb::arg("contact"), nb::arg("displacement"),
           "Displacement of a contact's rigid master that the next solve leads to [L]")
      .def(
          "solve",
          [](StaticProblem& self, int steps, double rtol, double atol, int max_iterations, int cut_backs, Line log,
             Line progress, std::function<void(int, double, double, std::int64_t, std::int64_t)> iteration,
             std::function<void(int, double, double)> begins, std::function<void(double)> accepted)
          {
            return self.solve(
                solve_options(steps, rtol, atol, max_iterations, cut_backs),
                {{log, std::move(progress), std::move(iteration)}, {log, std::move(begins), std::move(accepted)}});
          },
          nb::arg("steps"), nb::arg("rtol"), nb::arg("atol"), nb::arg("max_iterations"), nb::arg("cut_backs"),
          nb::arg("log"), nb::arg("progress"), nb::arg("iteration"), nb::arg("begins"), nb::arg("accepted"),
          "Solve for the present values of loads, boundary conditions and obstacles. Collective")
      .def(
          "solve_by",
          [](StaticProblem& self, std::function<Increment(Typed<NumpyArray<double>>)> solver, int steps, int cut_backs,
             Line log, std::function<void(int, double, double)> begins, std::function<void(double)> accepted)
          {
            return self.solve(
                [&](std::span<const double> goal)
                {
                  return solver(
                      typed<NumpyArray<double>>(nb::cast(take(std::vector<double>(goal.begin(), goal.end())))));
                },
                {.steps = steps, .cut_backs = cut_backs}, {std::move(log), std::move(begins), std::move(accepted)});
          },
          nb::arg("solver"), nb::arg("steps"), nb::arg("cut_backs"), nb::arg("log"), nb::arg("begins"),
          nb::arg("accepted"), "The same, increments solved by a function of Python's. Collective")
      .def(
          "reactions", [](StaticProblem& self) { return take(self.reactions()); }, nb::rv_policy::move,
          "Residual of equilibrium, owned [F]. Collective")
      .def(
          "saved_state", [](StaticProblem& self) { return saved_state(self); },
          "What the next solve starts from, values of its own. Collective")
      .def(
          "resume", [](StaticProblem& self, const dolfinx_impact::state::State& saved) { resume(self, saved); },
          nb::arg("saved"), "Go on from what saved_state has returned. Collective")
      .def("forget", &StaticProblem::forget, "Forget what `state` does not have. Collective")
      .def_prop_ro("equilibrium", [](const StaticProblem& self)
                   { return std::const_pointer_cast<EquilibriumProblem>(self.equilibrium()); });
}
