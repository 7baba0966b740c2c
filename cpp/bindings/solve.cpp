// SPDX-License-Identifier: MIT
#include "PythonContact.h"
#include "casters.h"
#include "dolfinx_impact/operators/RigidBodyModes.h"
#include "dolfinx_impact/solve/FunctionBody.h"
#include "dolfinx_impact/solve/Increment.h"
#include "dolfinx_impact/solve/IncrementSolver.h"
#include "dolfinx_impact/solve/LinearSolver.h"
#include "dolfinx_impact/solve/LinearSystem.h"
#include "dolfinx_impact/solve/LoadSteps.h"
#include "dolfinx_impact/solve/Newton.h"
#include "dolfinx_impact/solve/eigenvalues.h"
#include "dolfinx_impact/solve/unconstrained_modes.h"
#include "masks.h"
#include "petsc_objects.h"
#include <algorithm>
#include <nanobind/stl/complex.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/optional.h>

using namespace dolfinx_impact::solve;
using dolfinx_impact::enforcement::Condensation;
using dolfinx_impact::enforcement::MultiplierContact;
using dolfinx_impact::enforcement::SaddlePoint;
using dolfinx_impact::enforcement::StaticContact;
using dolfinx_impact::operators::RigidBodyModes;
typedef dolfinx::fem::FunctionSpace<double> Space;

namespace
{
using namespace dolfinx_impact::bindings;
std::vector<std::int8_t> bytes(const Mask& mask)
{
  return {mask.data(), mask.data() + mask.size()};
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
      .def_prop_ro("pinned",
                   [](const LinearSystem& self)
                   {
                     const auto pinned = self.pinned();
                     return mask(std::vector<std::int8_t>(pinned.begin(), pinned.end()));
                   })
      .def_prop_ro("symmetric", &LinearSystem::symmetric);
  nb::class_<CondensedSystem, LinearSystem>(m, "CondensedSystem", "Multipliers condensed, or no multipliers")
      .def(
          "__init__",
          [](CondensedSystem* self, Mat K, const Matrices& extra, bool symmetric,
             std::shared_ptr<Condensation> condensation, Mask pinned, double diagonal)
          {
            new (self) CondensedSystem(K, matrices(extra), symmetric, std::move(condensation), bytes(pinned), diagonal);
          },
          nb::arg("K"), nb::arg("extra"), nb::arg("symmetric"), nb::arg("condensation").none(), nb::arg("pinned"),
          nb::arg("diagonal"), nb::keep_alive<1, 2>(), nb::keep_alive<1, 3>(), nb::keep_alive<1, 5>())
      .def(
          "columns",
          [](const CondensedSystem& self, Indices unknowns)
          {
            const std::vector<PetscInt> local(unknowns.data(), unknowns.data() + unknowns.size());
            return self.columns(local);
          },
          nb::rv_policy::take_ownership, nb::arg("unknowns"), "Columns of the matrix. Collective");
  nb::class_<PerturbedSystem, CondensedSystem>(m, "PerturbedSystem",
                                               "Symmetric, and unsymmetric matrices that preconditioners leave out")
      .def(
          "__init__", [](PerturbedSystem* self, Mat K, const Matrices& extra, Mask pinned, double diagonal)
          { new (self) PerturbedSystem(K, matrices(extra), bytes(pinned), diagonal); }, nb::arg("K"), nb::arg("extra"),
          nb::arg("pinned"), nb::arg("diagonal"), nb::keep_alive<1, 2>(), nb::keep_alive<1, 3>());
  nb::class_<SaddlePointSystem, LinearSystem>(m, "SaddlePointSystem", "Multipliers kept as unknowns")
      .def(
          "__init__", [](SaddlePointSystem* self, Mat K, const Matrices& extra, SaddlePoint& rows)
          { new (self) SaddlePointSystem(K, matrices(extra), rows); }, nb::arg("K"), nb::arg("extra"), nb::arg("rows"),
          nb::keep_alive<1, 2>(), nb::keep_alive<1, 3>(), nb::keep_alive<1, 4>());
}

void bind_linear_solver(nb::module_& m)
{
  nb::class_<LinearSolverLimits>(m, "LinearSolverLimits", "Which systems are factorised, by dimension of the mesh")
      .def(nb::init<>())
      .def_rw("largest_direct", &LinearSolverLimits::largest_direct)
      .def_rw("largest_last_resort", &LinearSolverLimits::largest_last_resort)
      .def_rw("keep_preconditioner", &LinearSolverLimits::keep_preconditioner)
      .def_rw("patience", &LinearSolverLimits::patience);
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
      .def_prop_ro(
          "factors",
          [](const LinearSolver& self)
          {
            Mat factors = self.factors();
            return typed<std::optional<Mat>>(factors ? nb::cast(factors, nb::rv_policy::reference) : nb::none());
          },
          "Factors of the system that was factorised last; None if there are none")
      .def("set_up", &LinearSolver::set_up, nb::arg("system"), "Make the preconditioner of a system now. Collective")
      .def_prop_ro("null_pivots", &LinearSolver::null_pivots)
      .def("reset", &LinearSolver::reset, "Forget the preconditioner. Collective")
      .def("warn_of_unused", &LinearSolver::warn_of_unused)
      .def("set_near_nullspace", &LinearSolver::set_near_nullspace, nb::arg("A"))
      .def_prop_ro("direct", &LinearSolver::direct)
      .def_prop_ro(
          "ksp", [](const LinearSolver& self) { return as_ksp(self.ksp()); },
          nb::for_getter(nb::sig("def ksp(self) -> petsc4py.PETSc.KSP")))
      .def_prop_ro("prefix", &LinearSolver::prefix)
      .def_prop_ro("num_set_ups", &LinearSolver::num_set_ups)
      .def_prop_ro("num_iterations", &LinearSolver::num_iterations);
}

void bind_increment(nb::module_& m)
{
  nb::class_<Increment>(m, "Increment", "Iterations of one attempt at an increment; lists are copies")
      .def(
          "__init__", [](Increment* self, int unsettled_in_succession)
          { new (self) Increment{.unsettled_in_succession = unsettled_in_succession}; },
          nb::arg("unsettled_in_succession") = 0)
      .def("add", &Increment::add, nb::arg("norm"), nb::arg("size"), nb::arg("changes"), "Add an iteration")
      .def("converged", &Increment::converged, nb::rv_policy::reference_internal, "Mark the increment as converged")
      .def(
          "failed",
          [](Increment& self, std::string fault, bool hopeless, std::optional<std::string> advice) -> Increment&
          {
            if (advice)
              self.advice = *advice;
            return self.failed(std::move(fault), hopeless);
          },
          nb::arg("fault"), nb::arg("hopeless") = false, nb::arg("advice") = nb::none(),
          nb::rv_policy::reference_internal, "Mark the increment as failed")
      .def("cycle", &Increment::cycle, "Period of a cycle in the last iterations; 0: no cycle")
      .def("stalled", &Increment::stalled, "Whether active sets did not converge, and the residual does not fall")
      .def_rw("fault", &Increment::fault)
      .def_rw("advice", &Increment::advice)
      .def_rw("iterations", &Increment::iterations)
      .def_rw("unsettled", &Increment::unsettled)
      .def_rw("unsettled_in_succession", &Increment::unsettled_in_succession)
      .def_ro("residual_norms", &Increment::residual_norms)
      .def_ro("active_set_sizes", &Increment::active_set_sizes)
      .def_ro("changes", &Increment::changes)
      .def_prop_rw(
          "closed", [](const Increment& self) { return std::vector<bool>(self.closed.begin(), self.closed.end()); },
          [](Increment& self, const std::vector<bool>& closed) { self.closed.assign(closed.begin(), closed.end()); });
}

std::vector<double> copy_of(const Values& values)
{
  return {values.data(), values.data() + values.size()};
}

/// Times by the names of their parts.
nb::typed<nb::dict, std::string, double> by_part(const SolveSeconds& seconds)
{
  nb::typed<nb::dict, std::string, double> out;
  out["bodies"] = seconds.bodies;
  out["contact"] = seconds.contact;
  out["linear"] = seconds.linear;
  return out;
}

/// Exchanges whom Newton's method tells what it does, as long as it lives.
class Told
{
public:
  Told(Newton& newton, NewtonEvents events) : _newton(newton) { newton.events = std::move(events); }
  ~Told() { _newton.events = {}; }
  Told(const Told&) = delete;
  Told& operator=(const Told&) = delete;

private:
  Newton& _newton;
};

std::vector<MultiplierContact*> pointers(const std::vector<std::shared_ptr<MultiplierContact>>& contacts)
{
  std::vector<MultiplierContact*> out;
  for (const auto& contact : contacts)
    out.push_back(contact.get());
  return out;
}

void bind_active_sets(nb::module_& m)
{
  typedef std::vector<std::shared_ptr<MultiplierContact>> Contacts;
  nb::class_<ActiveSetIteration>(m, "ActiveSetIteration", "Updates active sets without cycling")
      .def(nb::init<>())
      .def(
          "change", [](ActiveSetIteration& self, const Contacts& contacts) { return self.change(pointers(contacts)); },
          nb::arg("contacts"), "Update the active sets; returns how many nodes were wrong. Collective");
  nb::class_<RepeatedStates>(m, "RepeatedStates", "Recognises active sets of a linearised problem that come again")
      .def(
          "__init__", [](RepeatedStates* self, dolfinx_wrappers::MPICommWrapper comm, int later)
          { new (self) RepeatedStates(comm.get(), later); }, nb::arg("comm"), nb::arg("later") = 0)
      .def(
          "stops", [](RepeatedStates& self, const Contacts& contacts) { return self.stops(pointers(contacts)); },
          nb::arg("contacts"), "Whether further updates are useless. Collective");
}

void bind_newton(nb::module_& m)
{
  nb::class_<BodyProperties>(m, "BodyProperties", "What is known of bodies beforehand")
      .def(
          "__init__",
          [](BodyProperties* self, bool linear, bool keeps_tangent, bool symmetric, bool inelastic, bool has_inertia,
             bool has_springs, bool rounds_positions)
          {
            new (self)
                BodyProperties{linear, keeps_tangent, symmetric, inelastic, has_inertia, has_springs, rounds_positions};
          },
          nb::kw_only(), nb::arg("linear") = false, nb::arg("keeps_tangent") = false, nb::arg("symmetric") = true,
          nb::arg("inelastic") = false, nb::arg("has_inertia") = false, nb::arg("has_springs") = false,
          nb::arg("rounds_positions") = false)
      .def_ro("linear", &BodyProperties::linear, "The tangent does not change with the displacement")
      .def_ro("keeps_tangent", &BodyProperties::keeps_tangent, "It does not change with time either")
      .def_ro("symmetric", &BodyProperties::symmetric, "The tangent is symmetric")
      .def_ro("inelastic", &BodyProperties::inelastic, "There are internal variables")
      .def_ro("has_springs", &BodyProperties::has_springs, "Springs to the ground may hold the bodies")
      .def_ro("rounds_positions", &BodyProperties::rounds_positions, "Round-off of positions enters the forces");
  nb::class_<Body>(m, "Body", "Bodies of a problem: residual and tangent")
      .def("residual", &Body::residual, nb::rv_policy::reference, "Borrowed until the next call. Collective")
      .def("tangent", &Body::tangent, nb::rv_policy::reference, "Borrowed until the next call. Collective")
      .def("fault", &Body::fault, "Why the last residual could not be computed. Collective")
      .def("accept_step", &Body::accept_step, "The state of the last residual is what the next step begins from")
      .def("stored_energy", &Body::stored_energy, "None: it is not known. Collective")
      .def_prop_ro("properties", &Body::properties, nb::rv_policy::copy, "What is known of them");
  nb::class_<FunctionBody, Body>(m, "FunctionBody", "Bodies whose residual and tangent are functions")
      .def(
          "__init__",
          [](FunctionBody* self, nb::typed<nb::callable, Vec()> residual, nb::typed<nb::callable, Mat()> tangent,
             std::function<std::string()> fault, std::function<void()> accept_step,
             std::optional<nb::typed<nb::callable, NumpyArray<const double>()>> origin,
             std::function<std::optional<double>()> stored_energy, BodyProperties properties)
          {
            FunctionBody::Functions functions{[residual] { return as_petsc<Vec>(residual()); },
                                              [tangent] { return as_petsc<Mat>(tangent()); },
                                              std::move(fault),
                                              std::move(accept_step),
                                              {},
                                              std::move(stored_energy)};
            if (origin)
              functions.origin = [origin = *origin] { return copy_of(nb::cast<Values>(origin())); };
            new (self) FunctionBody(std::move(functions), properties);
          },
          nb::arg("residual"), nb::arg("tangent"), nb::arg("fault").none(), nb::arg("accept_step").none(),
          nb::arg("origin").none(), nb::arg("stored_energy").none(), nb::arg("properties"));
  nb::class_<EquilibriumProblem>(m, "EquilibriumProblem", "Bodies and contacts in equilibrium")
      .def("__repr__",
           [](const EquilibriumProblem& self)
           {
             const auto& map = *self.space().dofmap()->index_map;
             const auto size = map.size_global() * self.space().dofmap()->index_map_bs();
             return "EquilibriumProblem(" + std::to_string(size) + " unknowns, " +
                    std::to_string(self.contacts.size()) + " contacts)";
           })
      .def_prop_ro("body", [](const EquilibriumProblem& self) { return self.body; })
      .def_prop_ro("linear_solver", [](const EquilibriumProblem& self) { return self.linear_solver; });
  nb::class_<NewtonOptions>(m, "NewtonOptions", "Tolerances and limits of Newton's method")
      .def(nb::init<>())
      .def_rw("rtol", &NewtonOptions::rtol)
      .def_rw("atol", &NewtonOptions::atol)
      .def_rw("max_iterations", &NewtonOptions::max_iterations)
      .def_rw("violation", &NewtonOptions::violation)
      .def_rw("max_changes", &NewtonOptions::max_changes)
      .def_rw("responses", &NewtonOptions::responses)
      .def("with_database", &NewtonOptions::with_database, nb::arg("prefix"));
  nb::class_<Newton>(m, "Newton", "Newton's method for equilibrium and contact")
      .def(
          "__init__", [](Newton* self, std::shared_ptr<const EquilibriumProblem> problem, const NewtonOptions& options)
          { new (self) Newton(std::move(problem), options); }, nb::arg("problem"), nb::arg("options"), "Collective")
      .def(
          "run",
          [](Newton& self, Values target, std::function<void(const std::string&)> log,
             std::function<void(const std::string&)> progress,
             std::function<void(int, double, double, std::int64_t, std::int64_t)> iteration)
          {
            // Only for this run: functions of Python may know the object that has this one.
            const Told told(self, {std::move(log), std::move(progress), std::move(iteration)});
            return self.run(view(target));
          },
          nb::arg("target"), nb::arg("log"), nb::arg("progress"), nb::arg("iteration"),
          "Solve from the present displacements to prescribed values. Collective")
      .def_prop_ro("seconds", [](const Newton& self) { return by_part(self.seconds); });
  nb::class_<IncrementSolver>(m, "IncrementSolver", "Solves increments by the SNES that PETSc's options choose")
      .def(
          "__init__",
          [](IncrementSolver* self, std::shared_ptr<const EquilibriumProblem> problem, double rtol, double atol,
             int max_iterations, std::function<void(const std::string&)> log,
             std::function<void(const std::string&)> progress,
             std::function<void(int, double, double, std::int64_t, std::int64_t)> iteration)
          {
            NewtonOptions options;
            options.rtol = rtol;
            options.atol = atol;
            options.max_iterations = max_iterations;
            new (self) IncrementSolver(std::move(problem), options,
                                       {std::move(log), std::move(progress), std::move(iteration)});
          },
          nb::arg("problem"), nb::arg("rtol"), nb::arg("atol"), nb::arg("max_iterations"), nb::arg("log").none(),
          nb::arg("progress").none(), nb::arg("iteration").none(), "Collective")
      .def(
          "run", [](IncrementSolver& self, Values target) { return self.run(view(target)); }, nb::arg("target"),
          "Solve from the present displacements to prescribed values. Collective")
      .def("forget", &IncrementSolver::forget, "Forget what was kept from earlier increments. Collective")
      .def("free", &IncrementSolver::free, "Give back the memory of PETSc's objects. Collective");
}

void bind_load_steps(nb::module_& m)
{
  nb::class_<LoadStepReport>(m, "LoadStepReport", "Course of a solve; lists are copies")
      .def_ro("converged", &LoadStepReport::converged)
      .def_ro("iterations", &LoadStepReport::iterations)
      .def_ro("residual_norms", &LoadStepReport::residual_norms)
      .def_ro("active_set_sizes", &LoadStepReport::active_set_sizes)
      .def_ro("contact_changes", &LoadStepReport::contact_changes)
      .def_ro("fractions", &LoadStepReport::fractions)
      .def_ro("cut_backs", &LoadStepReport::cut_backs)
      .def_ro("rejected_iterations", &LoadStepReport::rejected_iterations)
      .def_ro("unsettled", &LoadStepReport::unsettled)
      .def_ro("brought_together", &LoadStepReport::brought_together)
      .def_ro("lost", &LoadStepReport::lost)
      .def_prop_ro("seconds", [](const LoadStepReport& self) { return by_part(self.seconds); });
}

void bind_rigid_body_modes(nb::module_& m)
{
  typedef nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu> Rows;
  nb::class_<RigidBodyModes>(m, "RigidBodyModes", "Linearised rigid motions of all bodies")
      .def(
          "__init__", [](RigidBodyModes* self, std::shared_ptr<const Space> V, Values u, bool axisymmetric)
          { new (self) RigidBodyModes(*V, view(u), axisymmetric); }, nb::arg("V"), nb::arg("u"),
          nb::arg("axisymmetric"), "Collective")
      .def_prop_ro(
          "body", [](const RigidBodyModes& self)
          { return take(std::vector<std::int32_t>(self.body().begin(), self.body().end())); }, nb::rv_policy::move)
      .def_prop_ro("num_owned", &RigidBodyModes::num_owned)
      .def_prop_ro("num_modes", &RigidBodyModes::num_modes)
      .def_prop_ro("count", &RigidBodyModes::num_bodies)
      .def_prop_ro("names", &RigidBodyModes::names)
      .def(
          "rows",
          [](const RigidBodyModes& self, nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig> body, Rows x,
             Rows vectors)
          {
            const std::size_t num = body.size(), modes = self.num_modes(), gdim = self.gdim();
            std::vector<double> out(num * modes, 0.0);
            for (std::size_t i = 0; i < num; ++i)
              self.add_work(std::int32_t(body.data()[i]), x.data() + i * gdim, vectors.data() + i * gdim, 1.0,
                            {out.data() + i * modes, modes});
            return take(std::move(out), {num, modes});
          },
          nb::arg("body"), nb::arg("x"), nb::arg("vectors"), "Work of unit forces on the modes, (n, num_modes)")
      .def(
          "everywhere",
          [](const RigidBodyModes& self, int number)
          {
            std::vector<double> mode(self.num_modes(), 0.0);
            mode.at(number) = 1.0;
            return take(self.field(mode), {std::size_t(self.num_owned()), std::size_t(self.gdim())});
          },
          nb::arg("number"), "Displacements of the owned nodes under one mode, (num_owned, gdim)");
}

void bind_eigenvalues(nb::module_& m)
{
  m.def(
      "lowest_eigenvalues", [](Mat A, Mat B, int count, double shift, double tolerance)
      { return take(lowest_eigenvalues(A, B, count, shift, {.tolerance = tolerance})); }, nb::arg("A"), nb::arg("B"),
      nb::arg("count"), nb::arg("shift"), nb::arg("tolerance"), "Eigenvalues near a shift, ascending. Collective");
  m.def(
      "quadratic_eigenpairs",
      [](Mat K, Mat G, Mat M, int count, double shift, double tolerance, int max_iterations)
      {
        nb::typed<nb::list, std::tuple<std::complex<double>, Vec, Vec>> out;
        const EigenOptions options{.tolerance = tolerance, .max_iterations = max_iterations};
        for (const QuadraticEigenpair& pair : quadratic_eigenpairs(K, G, M, count, shift, options))
          out.append(nb::make_tuple(pair.value, nb::cast(pair.real, nb::rv_policy::take_ownership),
                                    nb::cast(pair.imaginary, nb::rv_policy::take_ownership)));
        return out;
      },
      nb::arg("K"), nb::arg("G"), nb::arg("M"), nb::arg("count"), nb::arg("shift"), nb::arg("tolerance"),
      nb::arg("max_iterations"),
      "Solutions of (s^2 M + s G + K) x = 0 nearest to a shift: s, x (two parts). Collective");
  m.def("num_negative_eigenvalues", &num_negative_eigenvalues, nb::arg("A"),
        "Negative eigenvalues of a symmetric matrix, counted. Collective");
}
} // namespace

void dolfinx_impact::bindings::solve(nb::module_& m)
{
  bind_eigenvalues(m);
  bind_rigid_body_modes(m);
  nb::class_<PythonContact, MultiplierContact>(m, "PythonContact", "A contact written in Python")
      .def(nb::init<nb::object>(), nb::arg("contact"));
  bind_increment(m);
  bind_active_sets(m);
  bind_newton(m);
  bind_load_steps(m);
  bind_systems(m);
  bind_linear_solver(m);
}
