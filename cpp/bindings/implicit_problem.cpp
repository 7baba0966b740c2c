// SPDX-License-Identifier: MIT
#include "arrays.h"
#include "dolfinx_impact/problems/implicit_state.h"
#include "functions_of_time.h"
#include <nanobind/stl/function.h>

namespace nb = nanobind;
using namespace dolfinx_impact::problems;

namespace
{
using dolfinx_impact::bindings::from_table;
using dolfinx_impact::bindings::NumpyArray;
using dolfinx_impact::bindings::take;
using dolfinx_impact::bindings::Values;
using dolfinx_impact::enforcement::StaticContact;
using dolfinx_impact::integrators::ImplicitRigidBody;
using dolfinx_impact::integrators::ImplicitScheme;
using dolfinx_impact::integrators::Inertia;
using dolfinx_impact::integrators::RigidBodyOptions;
using dolfinx_impact::integrators::StepControl;
using dolfinx_impact::integrators::VelocityForce;
using dolfinx_impact::solve::LinearSolverLimits;
typedef dolfinx::fem::Function<double> Function;
typedef std::array<double, 3> Vector;

/// A function of Python's that samples functions of time.
typedef nb::typed<nb::callable, NumpyArray<const double>(NumpyArray<double>)> Table;

/// Table of the functions of time at some times, (num_times, num_columns), from Python, which raises on all ranks
/// alike.
FunctionsOfTime::Source source_of(Table table)
{
  return [table = std::move(table)](std::span<const double> times)
  {
    const auto found = nb::cast<nb::ndarray<const double, nb::c_contig, nb::device::cpu>>(
        table(take(std::vector<double>(times.begin(), times.end()))));
    return std::vector<double>(found.data(), found.data() + found.size());
  };
}

/// Lets Python sample the functions of time during one call: functions of Python may know the problem.
class Sampled
{
public:
  Sampled(NewmarkProblem& problem, Table table) : _problem(problem)
  {
    problem.functions().set_source(source_of(std::move(table)));
  }
  ~Sampled() { _problem.functions().set_source({}); }
  Sampled(const Sampled&) = delete;
  Sampled& operator=(const Sampled&) = delete;

private:
  NewmarkProblem& _problem;
};
} // namespace

void dolfinx_impact::bindings::implicit_problem(nb::module_& m)
{
  nb::class_<ImplicitBody>(m, "ImplicitBody", "Bodies as implicit steps need them: residual, tangent, mass, damping")
      .def(
          "__init__",
          [](ImplicitBody* self, std::shared_ptr<dolfinx_impact::solve::Body> body,
             std::shared_ptr<const Inertia> inertia, Values mass, double alpha, std::shared_ptr<VelocityForce> damping,
             std::shared_ptr<dolfinx::fem::Form<double>> work, std::vector<KernelForce> loads_by_kernels,
             const std::vector<std::pair<std::shared_ptr<dolfinx::fem::Constant<double>>, Values>>& scaled)
          {
            BodyLoads loads{std::move(work), std::move(loads_by_kernels), {}};
            for (const auto& [constant, start] : scaled)
              loads.scaled.push_back({constant, *from_table(start)});
            new (self) ImplicitBody{std::move(body), std::move(inertia), {mass.data(), mass.data() + mass.size()},
                                    alpha,           std::move(damping), std::move(loads)};
          },
          nb::arg("body"), nb::arg("inertia"), nb::arg("mass"), nb::arg("alpha"), nb::arg("damping").none(),
          nb::arg("work").none(), nb::arg("loads"), nb::arg("scaled"),
          "work: of loads that are forms; loads: those by kernels; scaled: constants of loads, and their amplitudes at "
          "the start");
  nb::class_<ImplicitContact>(m, "ImplicitContact", "A contact of implicit steps")
      .def(
          "__init__",
          [](ImplicitContact* self, std::shared_ptr<StaticContact> contact, std::optional<Vector> start,
             const std::optional<Values>& motion, const std::optional<Values>& rotation)
          { new (self) ImplicitContact{std::move(contact), from_table(motion), start, from_table(rotation)}; },
          nb::arg("contact"), nb::arg("start").none(), nb::arg("motion").none(), nb::arg("rotation").none(),
          "start: displacement of a rigid master; motion: that beside it, rotation: its rotation vector, at the start");
  nb::class_<ImplicitBodyInTime>(m, "ImplicitBodyInTime", "A rigid body that moves by forces in implicit steps")
      .def(
          "__init__",
          [](ImplicitBodyInTime* self, double mass, const std::array<double, 9>& inertia, const Vector& centre,
             const Vector& displacement, const Vector& velocity, const Vector& spin,
             const std::array<bool, 3>& fixed_velocity, const std::array<bool, 3>& fixed_spin, double length,
             std::vector<std::size_t> contacts, const std::optional<Values>& force, const std::optional<Values>& torque)
          {
            new (self) ImplicitBodyInTime{
                std::make_shared<ImplicitRigidBody>(
                    RigidBodyOptions{mass, inertia, centre, displacement, velocity, spin, fixed_velocity, fixed_spin},
                    length),
                std::move(contacts), from_table(force), from_table(torque)};
          },
          nb::arg("mass"), nb::arg("inertia"), nb::arg("centre"), nb::arg("displacement"), nb::arg("velocity"),
          nb::arg("spin"), nb::arg("fixed_velocity"), nb::arg("fixed_spin"), nb::arg("length"), nb::arg("contacts"),
          nb::arg("force").none(), nb::arg("torque").none(), "Force and torque: their values at the start, or None")
      .def_prop_ro("position", [](const ImplicitBodyInTime& self) { return self.body->position(); })
      .def_prop_ro("rotation", [](const ImplicitBodyInTime& self) { return self.body->rotation(); })
      .def(
          "velocity", [](const ImplicitBodyInTime& self, double) { return self.body->velocity(); }, nb::arg("dt"),
          "At the present time; dt: not used")
      .def(
          "spin", [](const ImplicitBodyInTime& self, double) { return self.body->spin(); }, nb::arg("dt"),
          "At the present time; dt: not used")
      .def(
          "momentum", [](const ImplicitBodyInTime& self, double) { return self.body->momentum(); }, nb::arg("dt"),
          "At the present time; dt: not used")
      .def(
          "angular_momentum", [](const ImplicitBodyInTime& self, double) { return self.body->angular_momentum(); },
          nb::arg("dt"), "At the present time; dt: not used")
      .def(
          "kinetic_energy", [](const ImplicitBodyInTime& self, double) { return self.body->kinetic_energy(); },
          nb::arg("dt"), "At the present time; dt: not used")
      .def_prop_ro("contact_force", [](const ImplicitBodyInTime& self) { return self.body->state().force; })
      .def_prop_ro("contact_torque", [](const ImplicitBodyInTime& self) { return self.body->state().torque; });
  nb::class_<NewmarkProblem>(m, "NewmarkProblem", "Motion of bodies by Newmark's method or generalised-alpha")
      .def(
          "__init__",
          [](NewmarkProblem* self, std::shared_ptr<Function> u, std::shared_ptr<Function> v,
             std::shared_ptr<Function> a, const ImplicitBody& body, std::vector<PrescribedMotion> supports,
             std::vector<ImplicitContact> contacts, const ImplicitScheme& scheme,
             std::map<std::string, std::string> petsc, const std::string& prefix, bool axisymmetric,
             const LinearSolverLimits& limits, std::function<void(const std::string&)> warn, Table table,
             std::vector<ImplicitBodyInTime> bodies)
          {
            const NewmarkOptions options{scheme, {std::move(petsc), prefix, axisymmetric, limits, std::move(warn)}};
            new (self) NewmarkProblem(std::move(u), std::move(v), body, std::move(supports), {}, std::move(contacts),
                                      options, std::move(a), source_of(std::move(table)), std::move(bodies));
          },
          nb::arg("u"), nb::arg("v"), nb::arg("a"), nb::arg("body"), nb::arg("supports"), nb::arg("contacts"),
          nb::arg("scheme"), nb::arg("petsc"), nb::arg("prefix"), nb::arg("axisymmetric"), nb::arg("limits"),
          nb::arg("warn"), nb::arg("table"), nb::arg("bodies"),
          "table: samples all functions of time; bodies: rigid ones. Collective")
      .def(
          "advance",
          [](NewmarkProblem& self, double until, double dt, std::optional<double> tolerance, double smallest,
             double rtol, double atol, int max_iterations, std::function<void(const std::string&)> log,
             std::function<void(const std::string&)> progress,
             std::function<void(int, double, double, std::int64_t, std::int64_t)> iteration,
             std::function<void(double)> update, std::function<void()> started, std::function<void()> begins,
             std::function<double()> goal, std::function<void()> accepted, Table table)
          {
            const Sampled sampled(self, std::move(table));
            self.advance(until,
                         {.dt = dt,
                          .tolerance = tolerance,
                          .smallest = smallest,
                          .rtol = rtol,
                          .atol = atol,
                          .max_iterations = max_iterations},
                         {},
                         {{std::move(log), std::move(progress), std::move(iteration)},
                          std::move(update),
                          std::move(started),
                          std::move(begins),
                          std::move(goal),
                          std::move(accepted)});
          },
          nb::arg("until"), nb::arg("dt"), nb::arg("tolerance").none(), nb::arg("smallest"), nb::arg("rtol"),
          nb::arg("atol"), nb::arg("max_iterations"), nb::arg("log"), nb::arg("progress"), nb::arg("iteration"),
          nb::arg("update").none(), nb::arg("started"), nb::arg("begins"), nb::arg("goal"), nb::arg("accepted"),
          nb::arg("table"), "Advance to a time. Collective")
      .def(
          "energies",
          [](NewmarkProblem& self)
          {
            const auto values = self.energies().values();
            return take(std::vector<double>(values.begin(), values.end()));
          },
          nb::rv_policy::move, "Energies in the order of run_history.ENERGIES. Collective")
      .def("stable_step", &NewmarkProblem::stable_step, "Infinite for schemes that are stable with any. Collective")
      .def(
          "saved_state", [](NewmarkProblem& self) { return saved_state(self); },
          "What the problem goes on from, values of its own. Collective")
      .def(
          "resume",
          [](NewmarkProblem& self, const dolfinx_impact::state::State& saved, Table table)
          {
            const Sampled sampled(self, std::move(table));
            resume(self, saved);
          },
          nb::arg("saved"), nb::arg("table"), "Go on from what saved_state has returned. Collective")
      .def("forget", &NewmarkProblem::forget, "Forget what a state does not have. Collective")
      .def_prop_ro("time", &NewmarkProblem::time)
      .def_prop_ro("step", &NewmarkProblem::step)
      .def_prop_ro(
          "supports", [](NewmarkProblem& self) -> Supports& { return self.supports(); },
          nb::rv_policy::reference_internal)
      .def_prop_ro("control", [](const NewmarkProblem& self) { return self.control(); })
      .def_prop_ro("history", nb::overload_cast<>(&NewmarkProblem::history), nb::rv_policy::reference_internal)
      .def_prop_ro("stepper", &NewmarkProblem::stepper, nb::rv_policy::reference_internal)
      .def_prop_ro("equilibrium", [](const NewmarkProblem& self) { return self.equilibrium(); });
}
