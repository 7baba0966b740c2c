// SPDX-License-Identifier: MIT
#include "arrays.h"
#include "dolfinx_impact/common/OnAllRanks.h"
#include "dolfinx_impact/integrators/assembled_step.h"
#include "dolfinx_impact/problems/ExplicitProblem.h"
#include "dolfinx_impact/problems/SpringStart.h"
#include "dolfinx_impact/problems/equilibrium_start.h"
#include "dolfinx_impact/problems/explicit_state.h"
#include "dolfinx_impact/problems/failed_run.h"
#include "dolfinx_impact/problems/release_limit.h"
#include "functions_of_time.h"
#include "masks.h"
#include "petsc_objects.h"

namespace nb = nanobind;
using namespace dolfinx_impact::problems;
using dolfinx_impact::bindings::from_table;
using dolfinx_impact::bindings::Indices;
using dolfinx_impact::bindings::MutableValues;
using dolfinx_impact::bindings::take;
using dolfinx_impact::bindings::Values;
using dolfinx_impact::bindings::view;

namespace
{
using dolfinx_impact::enforcement::StaticContact;
using dolfinx_impact::integrators::CellFrequencies;
using dolfinx_impact::integrators::CentralDifference;
using dolfinx_impact::integrators::Energies;
using dolfinx_impact::integrators::FormForces;
using dolfinx_impact::integrators::InputChanges;
using dolfinx_impact::integrators::RigidBody;
using dolfinx_impact::integrators::SafeStep;
using dolfinx_impact::integrators::Scheme;
using dolfinx_impact::integrators::StableStepWatch;
using dolfinx_impact::integrators::StepSchedule;
using dolfinx_impact::integrators::UniformDamping;
using dolfinx_impact::integrators::WorkKind;
typedef dolfinx::fem::Function<double> Function;
typedef dolfinx_impact::problems::PrescribedMotion Prescribed; // integrators have another one
typedef dolfinx::fem::FunctionSpace<double> FunctionSpace;

/// NumPy array with a copy of numbers.
auto copy_of(std::span<const double> values)
{
  return take(std::vector<double>(values.begin(), values.end()));
}

/// Passes what a run tells and asks on to an object of Python, which raises on all ranks alike. Functions of Python may
/// know the problem, and so it lives for one call only.
class PythonObserver : public RunObserver
{
public:
  explicit PythonObserver(nb::object observer) : _observer(std::move(observer)) {}

  bool asks() const override { return true; }
  /// Runs the handlers of signals that have arrived: Python does so between its own instructions only. What one raises
  /// is not thrown through a step, but handed on.
  bool asked() override
  {
    const nb::gil_scoped_acquire lock;
    nb::object error = nb::none();
    if (PyErr_CheckSignals() != 0)
    {
      nb::python_error raised;
      error = nb::borrow(raised.value());
    }
    return nb::cast<bool>(_observer.attr("asked")(error));
  }
  std::int64_t room() override
  {
    const nb::gil_scoped_acquire lock;
    return nb::cast<std::int64_t>(_observer.attr("room")());
  }
  void begins(const StepSchedule& schedule) override
  {
    const nb::gil_scoped_acquire lock;
    _observer.attr("begins")(schedule);
  }
  std::optional<std::vector<double>> table(std::span<const double> times) override
  {
    const nb::gil_scoped_acquire lock;
    const auto found = nb::cast<Values>(_observer.attr("table")(copy_of(times)));
    return std::vector<double>(found.data(), found.data() + found.size());
  }
  std::optional<std::string> unsolved() override
  {
    const nb::gil_scoped_acquire lock;
    return nb::cast<std::string>(_observer.attr("unsolved")());
  }
  void add_rows(std::span<const double> times, std::span<const double> steps) override
  {
    const nb::gil_scoped_acquire lock;
    _observer.attr("add_rows")(copy_of(times), copy_of(steps));
  }
  void after_steps() override
  {
    const nb::gil_scoped_acquire lock;
    _observer.attr("after_steps")();
  }
  void warn(const std::string& text) override
  {
    const nb::gil_scoped_acquire lock;
    _observer.attr("warn")(text);
  }
  void failed() override
  {
    const nb::gil_scoped_acquire lock;
    _observer.attr("failed")();
  }

private:
  nb::object _observer;
};

/// Does what all ranks may throw from together.
/// @returns kind and text of what was thrown, or None: Python marks it as raised on all ranks
template <typename F>
std::optional<std::pair<std::string, std::string>> all_ranks(const F& act)
{
  std::optional<std::pair<std::string, std::string>> thrown;
  {
    const nb::gil_scoped_release release;
    try
    {
      act();
    }
    catch (const dolfinx_impact::common::BadValue& e)
    {
      thrown = {"value", e.what()};
    }
    catch (const dolfinx_impact::common::Failure& e)
    {
      thrown = {"failure", e.what()};
    }
  }
  return thrown;
}

void bind_rigid_body(nb::module_& m)
{
  typedef std::array<double, 3> Vector;
  nb::class_<RigidBodyInTime>(m, "RigidBodyInTime", "A rigid body that moves by the forces of contacts and loads")
      .def(
          "__init__",
          [](RigidBodyInTime* self, double mass, std::array<double, 9> inertia, Vector centre, Vector displacement,
             Vector velocity, Vector spin, std::array<bool, 3> fixed_velocity, std::array<bool, 3> fixed_spin,
             const std::optional<Values>& force, const std::optional<Values>& torque)
          {
            new (self) RigidBodyInTime{
                RigidBody({mass, inertia, centre, displacement, velocity, spin, fixed_velocity, fixed_spin}),
                from_table(force), from_table(torque)};
          },
          nb::arg("mass"), nb::arg("inertia"), nb::arg("centre"), nb::arg("displacement"), nb::arg("velocity"),
          nb::arg("spin"), nb::arg("fixed_velocity"), nb::arg("fixed_spin"), nb::arg("force").none(),
          nb::arg("torque").none(), "Force and torque: their values at the start, or None without")
      .def_prop_ro("position", [](const RigidBodyInTime& self) { return self.body.position(); })
      .def_prop_ro("rotation", [](const RigidBodyInTime& self) { return self.body.rotation(); })
      .def(
          "velocity", [](const RigidBodyInTime& self, double dt) { return self.body.velocity(dt); }, nb::arg("dt"),
          "At the present time level; dt: the step that led to it, 0 at the start")
      .def(
          "spin", [](const RigidBodyInTime& self, double dt) { return self.body.spin(dt); }, nb::arg("dt"))
      .def(
          "momentum", [](const RigidBodyInTime& self, double dt) { return self.body.momentum(dt); }, nb::arg("dt"))
      .def(
          "angular_momentum", [](const RigidBodyInTime& self, double dt) { return self.body.angular_momentum(dt); },
          nb::arg("dt"))
      .def(
          "kinetic_energy", [](const RigidBodyInTime& self, double dt) { return self.body.kinetic_energy(dt); },
          nb::arg("dt"))
      .def(
          "meet",
          [](RigidBodyInTime& self, Values points, Values areas, double radius, dolfinx_impact::gap::Rigid master,
             double friction, std::shared_ptr<RigidBodyInTime> body)
          {
            meet(self,
                 {.points = {points.data(), points.data() + points.size()},
                  .areas = {areas.data(), areas.data() + areas.size()},
                  .radius = radius,
                  .master = std::move(master),
                  .friction = friction},
                 std::move(body));
          },
          nb::arg("points"), nb::arg("areas"), nb::arg("radius"), nb::arg("master"), nb::arg("friction"),
          nb::arg("body").none(), "Contact of its points, or of a ball around one, with another body or an obstacle")
      .def_prop_ro(
          "meeting_gaps",
          [](const RigidBodyInTime& self)
          {
            std::vector<double> out;
            for (const auto& meeting : self.meetings)
              out.push_back(meeting.contact->gap());
            return out;
          },
          "Smallest gap of each of these contacts")
      .def_prop_ro(
          "meeting_forces",
          [](const RigidBodyInTime& self)
          {
            std::vector<Vector> out;
            for (const auto& meeting : self.meetings)
              out.push_back(meeting.contact->force());
            return out;
          },
          "Force of each of these contacts on the body")
      .def_prop_ro("contact_force", [](const RigidBodyInTime& self) { return self.body.contact_force(); })
      .def_prop_ro("contact_torque", [](const RigidBodyInTime& self) { return self.body.contact_torque(); });
}

void bind_history(nb::module_& m)
{
  nb::class_<RunHistory>(m, "RunHistory", "Time, energies and contact forces of a run by step, in bounded memory")
      .def(nb::init<std::size_t>(), nb::arg("num_contacts"))
      .def(
          "add", [](RunHistory& self, Values times, Values steps) { self.add(view(times), view(steps)); },
          nb::arg("times"), nb::arg("steps"))
      .def(
          "columns",
          [](const RunHistory& self, std::size_t first, std::size_t count)
          {
            if (first + count > self.row_size())
              throw std::invalid_argument("a row has fewer columns");
            std::vector<double> out(self.num_rows() * count);
            for (std::size_t k = 0; k < self.num_rows(); ++k)
              std::ranges::copy(self.row(k).subspan(first, count), out.begin() + std::ptrdiff_t(k * count));
            return take(std::move(out), {self.num_rows(), count});
          },
          nb::arg("first"), nb::arg("count"), nb::rv_policy::move, "Some columns of the rows that are kept")
      .def_prop_ro(
          "last", [](const RunHistory& self) { return copy_of(self.last()); }, nb::rv_policy::move)
      .def("begin_anew", &RunHistory::begin_anew)
      .def(
          "drift",
          [](const RunHistory& self, Values energies)
          {
            std::array<double, Energies::size> values{};
            if (energies.size() != values.size())
              throw std::invalid_argument("there are " + std::to_string(values.size()) + " energies");
            std::copy_n(energies.data(), values.size(), values.begin());
            return self.drift(std::bit_cast<Energies>(values));
          },
          nb::arg("energies"))
      .def_prop_ro("num_rows", &RunHistory::num_rows)
      .def_prop_ro("stride", &RunHistory::stride)
      .def_prop_ro("memory", &RunHistory::memory)
      .def_prop_rw("limit", &RunHistory::limit, &RunHistory::set_limit);
}

/// A function of Python that C++ objects keep: the last one may let go of it where Python's lock is not held.
std::shared_ptr<nb::object> shared(nb::object function)
{
  return {new nb::object(std::move(function)), [](nb::object* p)
          {
            const nb::gil_scoped_acquire lock;
            delete p;
          }};
}

typedef nb::typed<nb::callable, std::shared_ptr<dolfinx_impact::operators::KernelTangent>()> AssembleTangent;

ExplicitBody::Assemble assembled(AssembleTangent function)
{
  return [kept = shared(std::move(function))]
  {
    const nb::gil_scoped_acquire lock;
    return nb::cast<std::shared_ptr<dolfinx_impact::operators::KernelTangent>>((*kept)());
  };
}

void bind_stable_step(nb::module_& m)
{
  nb::class_<StepSchedule>(m, "StepSchedule", "Equal steps between two times, numbered as the steps of the run")
      .def(nb::init<double, double, std::int64_t, std::int64_t, bool>(), nb::arg("begin"), nb::arg("until"),
           nb::arg("first"), nb::arg("last"), nb::arg("auto") = false)
      .def_ro("begin", &StepSchedule::begin)
      .def_ro("until", &StepSchedule::until)
      .def_ro("first", &StepSchedule::first)
      .def_ro("last", &StepSchedule::last)
      .def_ro("auto", &StepSchedule::automatic)
      .def_prop_ro("dt", &StepSchedule::dt)
      .def("time", &StepSchedule::time, nb::arg("step"))
      .def(
          "__eq__", [](const StepSchedule& self, const StepSchedule& other) { return self == other; },
          nb::is_operator(), nb::sig("def __eq__(self, other: object, /) -> bool"));
  nb::class_<InputChanges>(m, "InputChanges", "Changes of what the stable step depends on, since it was found")
      .def(nb::init<>())
      .def_rw("stale", &InputChanges::stale)
      .def_rw("total", &InputChanges::total)
      .def_rw("allowed", &InputChanges::allowed)
      .def("add", &InputChanges::add, nb::arg("change"))
      .def_prop_ro("due", &InputChanges::due)
      .def("done", &InputChanges::done, nb::arg("before"), nb::arg("after"))
      .def_ro_static("effect", &InputChanges::effect);
  nb::class_<UniformDamping>(m, "UniformDamping", "Damping of all cells alike")
      .def(nb::init<double, double, double>(), nb::arg("alpha"), nb::arg("beta"), nb::arg("viscosity"))
      .def_ro("alpha", &UniformDamping::alpha)
      .def_ro("beta", &UniformDamping::beta)
      .def_ro("viscosity", &UniformDamping::viscosity)
      .def("rate", &UniformDamping::rate, nb::arg("square"), "Eigenvalue of the damping over the mass [1/T]");
  nb::enum_<StableStepMethod>(m, "StableStepMethod", "How the stable step is found")
      .value("length", StableStepMethod::length)
      .value("element", StableStepMethod::element)
      .value("eigenvalue", StableStepMethod::eigenvalue);
  m.def(
      "highest_frequency", [](Mat stiffness, Values inverse_mass)
      { return dolfinx_impact::integrators::highest_frequency(stiffness, view(inverse_mass)); }, nb::arg("stiffness"),
      nb::arg("inverse_mass"), "Of a matrix, which is scaled by the lumped mass. Collective [1/T]");
  nb::class_<CellFrequencies>(m, "CellFrequencies", "Highest frequencies of the cells of bodies, and their damping")
      .def(
          "__init__",
          [](CellFrequencies* self, std::shared_ptr<const FunctionSpace> V,
             std::shared_ptr<dolfinx_impact::operators::CellBounds> stiffness,
             std::shared_ptr<dolfinx_impact::operators::CellBounds> damping,
             nb::typed<nb::callable, nb::ndarray<nb::numpy, const double>()> masses)
          {
            const auto function = shared(std::move(masses));
            new (self) CellFrequencies(std::move(V), std::move(stiffness), std::move(damping),
                                       [function]
                                       {
                                         const nb::gil_scoped_acquire lock;
                                         const auto found = nb::cast<Values>((*function)());
                                         return std::vector<double>(found.data(), found.data() + found.size());
                                       });
          },
          nb::arg("V"), nb::arg("stiffness"), nb::arg("damping").none(), nb::arg("masses"))
      .def(
          "masses", [](const CellFrequencies& self) { return take(self.masses()); }, nb::rv_policy::move)
      .def(
          "by_cell",
          [](CellFrequencies& self, const std::optional<dolfinx_impact::bindings::Mask>& only)
          {
            std::optional<std::span<const std::int8_t>> chosen;
            if (only)
              chosen = view(*only);
            auto found = self.by_cell(chosen);
            return std::pair(take(std::move(found.squares)), take(std::move(found.rates)));
          },
          nb::arg("only") = nb::none(), "Squares of frequencies, and damping over mass. Collective")
      .def("scale_mass", &CellFrequencies::scale_mass, nb::arg("dt"), "Added mass. Collective")
      .def_prop_ro("num_looks", &CellFrequencies::num_looks)
      .def_prop_ro("num_cells_looked_at", &CellFrequencies::num_cells_looked_at);
  nb::class_<StableStepWatch>(m, "StableStepWatch", "Frequencies of the cells, each at its last look")
      .def_prop_ro(
          "squares", [](const StableStepWatch& self) { return copy_of(self.seen().squares); }, nb::rv_policy::move)
      .def_prop_ro(
          "rates", [](const StableStepWatch& self) { return copy_of(self.seen().rates); }, nb::rv_policy::move)
      .def_prop_ro(
          "since", [](const StableStepWatch& self) { return copy_of(self.seen().since); }, nb::rv_policy::move)
      .def_prop_ro(
          "reference", [](const StableStepWatch& self) { return copy_of(self.seen().reference); }, nb::rv_policy::move)
      .def_prop_ro("sensitivity", [](const StableStepWatch& self) { return self.seen().sensitivity; });
  nb::class_<SafeStep>(m, "SafeStep", "The stable step of a run, found again where it may have changed")
      .def_prop_ro("value", &SafeStep::value)
      .def(
          "steps", [](const SafeStep& self, Values squares, Values rates)
          { return take(self.steps()(view(squares), view(rates))); }, nb::arg("squares"), nb::arg("rates"),
          nb::rv_policy::move, "Stable steps of cells, contact springs included [T]")
      .def_prop_ro(
          "changes", [](SafeStep& self) -> InputChanges& { return self.changes; }, nb::rv_policy::reference_internal)
      .def_prop_ro("watch", &SafeStep::watch, nb::rv_policy::reference_internal)
      .def_prop_ro("deformed", &SafeStep::deformed)
      .def_prop_ro("num_found", &SafeStep::num_found, "How often the stable step was found anew")
      .def_prop_ro("check_step", [](const SafeStep& self) { return self.saved().check_step; })
      .def_prop_ro("check_interval", [](const SafeStep& self) { return self.saved().check_interval; })
      .def_prop_rw("longest_interval", &SafeStep::longest_interval, &SafeStep::set_longest_interval)
      .def_ro_static("safety", &SafeStep::safety);
}

void bind_supports(nb::module_& m)
{
  nb::class_<Prescribed>(m, "PrescribedMotion", "Displacements of a boundary condition times an amplitude")
      .def(
          "__init__",
          [](Prescribed* self, std::shared_ptr<const dolfinx::fem::DirichletBC<double>> bc,
             const std::optional<Values>& start) { new (self) Prescribed{std::move(bc), from_table(start)}; },
          nb::arg("bc"), nb::arg("start").none(), "start: amplitude at the start; None: it is constant");
  nb::class_<Supports>(m, "Supports", "Prescribed degrees of freedom")
      .def_prop_ro(
          "parts",
          [](const Supports& self)
          {
            typedef std::tuple<nb::ndarray<nb::numpy, std::int32_t>, nb::ndarray<nb::numpy, double>, int> Part;
            nb::typed<nb::list, Part> out;
            for (const Supports::Part& part : self.parts())
              out.append(nb::make_tuple(take(std::vector<std::int32_t>(part.dofs)), copy_of(part.values), part.column));
            return out;
          })
      .def_prop_ro(
          "mask", [](const Supports& self) { return take(std::vector<std::int8_t>(self.mask())); }, nb::rv_policy::move)
      .def("check", &Supports::check, "Raises if the value of a condition has been changed");
  nb::class_<LoadInTime>(m, "LoadInTime", "Nodal forces times an amplitude")
      .def(
          "__init__",
          [](LoadInTime* self, Indices dofs, Values values, const std::optional<Values>& start)
          {
            new (self) LoadInTime{{dofs.data(), dofs.data() + dofs.size()},
                                  {values.data(), values.data() + values.size()},
                                  from_table(start)};
          },
          nb::arg("dofs"), nb::arg("values"), nb::arg("start").none());
  bind_rigid_body(m);
  nb::class_<ContactInTime>(m, "ContactInTime", "A contact, and the motion of its rigid master")
      .def(
          "__init__",
          [](ContactInTime* self, const dolfinx_impact::enforcement::NodalPair& contact, std::string name,
             const std::optional<Values>& start, std::shared_ptr<RigidBodyInTime> body,
             const std::optional<Values>& rotation)
          {
            new (self)
                ContactInTime{contact, std::move(name), from_table(start), std::move(body), from_table(rotation)};
          },
          nb::arg("contact"), nb::arg("name"), nb::arg("start").none(), nb::arg("body").none() = nb::none(),
          nb::arg("rotation").none() = nb::none());
}

void bind_explicit(nb::module_& m)
{
  nb::class_<ExplicitBody>(m, "ExplicitBody", "Bodies as explicit steps need them")
      .def(
          "__init__",
          [](ExplicitBody* self, FormForces internal, bool linear, Values mass,
             std::shared_ptr<CellFrequencies> frequencies, const UniformDamping& damping, bool watched, bool periodic,
             bool flows)
          {
            new (self) ExplicitBody{std::move(internal),
                                    linear,
                                    {},
                                    {mass.data(), mass.data() + mass.size()},
                                    std::move(frequencies),
                                    damping,
                                    {watched, periodic, flows}};
          },
          nb::arg("internal"), nb::arg("linear"), nb::arg("mass"), nb::arg("frequencies"), nb::arg("damping"),
          nb::arg("watched"), nb::arg("periodic"), nb::arg("flows"))
      .def(
          "add_term", [](ExplicitBody& self, FormForces forces, WorkKind kind)
          { self.terms.push_back({std::move(forces), kind}); }, nb::arg("forces"), nb::arg("kind"))
      .def(
          "set_matrices",
          [](ExplicitBody& self, AssembleTangent stiffness, const std::optional<AssembleTangent>& cell_damping)
          {
            self.stiffness = assembled(std::move(stiffness));
            self.cell_damping = cell_damping ? assembled(*cell_damping) : nullptr;
          },
          nb::arg("stiffness"), nb::arg("cell_damping").none(),
          "Functions that assemble new matrices; they must not know the problem")
      .def(
          "set_elasticity",
          [](ExplicitBody& self, Values moduli, Values wave_speeds)
          {
            self.elasticity = {{moduli.data(), moduli.data() + moduli.size()},
                               {wave_speeds.data(), wave_speeds.data() + wave_speeds.size()}};
          },
          nb::arg("moduli"), nb::arg("wave_speeds"), "Of each owned cell");
  nb::class_<ExplicitProblem>(m, "ExplicitProblem", "Motion of bodies with lumped mass by central differences")
      .def(
          "__init__",
          [](ExplicitProblem* self, std::shared_ptr<Function> u, std::shared_ptr<Function> velocity,
             std::shared_ptr<Function> acceleration, const ExplicitBody& body, std::vector<Prescribed> supports,
             std::vector<LoadInTime> loads, std::vector<ContactInTime> contacts, Scheme scheme)
          {
            new (self)
                ExplicitProblem(std::move(u), std::move(velocity), body, std::move(supports), std::move(loads),
                                std::move(contacts), {.scheme = scheme, .start = false}, std::move(acceleration));
          },
          nb::arg("u"), nb::arg("velocity"), nb::arg("acceleration"), nb::arg("body"), nb::arg("supports"),
          nb::arg("loads"), nb::arg("contacts"), nb::arg("scheme"), "Collective; `start` computes the first forces")
      .def_prop_ro("time", &ExplicitProblem::time)
      .def_prop_ro("lost_at_start", &ExplicitProblem::lost_at_start, "Kinetic energy that ties have taken [F L]")
      .def_prop_ro("step", &ExplicitProblem::step)
      .def_prop_ro("next_time", [](const ExplicitProblem& self) { return self.stepper().next_time(); })
      .def_prop_ro("nominal_step", [](const ExplicitProblem& self) { return self.stepper().nominal_step(); })
      .def_prop_ro("schedule", [](const ExplicitProblem& self) { return self.stepper().schedule(); })
      .def_prop_ro(
          "supports", [](ExplicitProblem& self) -> Supports& { return self.supports(); },
          nb::rv_policy::reference_internal)
      .def_prop_ro(
          "integrator", [](ExplicitProblem& self) -> CentralDifference& { return self.integrator(); },
          nb::rv_policy::reference_internal)
      .def_prop_ro(
          "safe_step", [](ExplicitProblem& self) -> SafeStep& { return self.safe_step(); },
          nb::rv_policy::reference_internal)
      .def_prop_ro(
          "history", [](ExplicitProblem& self) -> RunHistory& { return self.history(); },
          nb::rv_policy::reference_internal)
      .def("state", &ExplicitProblem::state, nb::keep_alive<0, 1>())
      .def("update_motion", &ExplicitProblem::update_motion,
           "Functions of displacement, velocity and acceleration get the present motion. Collective")
      .def("update_gaps", [](ExplicitProblem& self) { self.integrator().update_gaps(); })
      .def("unsolved", &ExplicitProblem::unsolved, "Which local equations were not solved; empty: all were. Collective")
      .def("stable_step", &ExplicitProblem::stable_step_of_function, nb::arg("method"),
           "Of the displacement that the function has. Collective")
      .def("begin_anew", &ExplicitProblem::begin_anew, "Take the present displacement for another start. Collective")
      .def(
          "start",
          [](ExplicitProblem& self, nb::object observer)
          {
            PythonObserver told(std::move(observer));
            return all_ranks([&] { self.start(told); });
          },
          nb::arg("observer"), "Forces of the start; what all ranks throw, or None. Collective")
      .def(
          "advance",
          [](ExplicitProblem& self, double until, std::optional<double> dt, bool unsafe, double gain_warning,
             double gain_limit, nb::object observer)
          {
            PythonObserver told(std::move(observer));
            return all_ranks([&] { self.advance(until, {dt, unsafe, gain_warning, gain_limit}, told); });
          },
          nb::arg("until"), nb::arg("dt").none(), nb::arg("unsafe"), nb::arg("gain_warning"), nb::arg("gain_limit"),
          nb::arg("observer"), "What all ranks throw, or None. Collective")
      .def(
          "saved_state", [](ExplicitProblem& self) { return saved_state(self); },
          "What the run goes on from, beside the schedule. Collective")
      .def(
          "empty_state", [](ExplicitProblem& self) { return empty_state(self); },
          "A state of that structure, whose values do not matter")
      .def(
          "resume",
          [](ExplicitProblem& self, const dolfinx_impact::state::State& saved,
             const std::optional<StepSchedule>& schedule, nb::object observer)
          {
            PythonObserver told(std::move(observer));
            resume(self, saved, schedule, told);
          },
          nb::arg("saved"), nb::arg("schedule").none(), nb::arg("observer"),
          "Go on from what saved_state has returned. Collective");
  nb::class_<SpringStart>(m, "SpringStart",
                          "Springs of an explicit contact that bear what a contact in equilibrium does")
      .def(nb::init<std::shared_ptr<const StaticContact>, ExplicitProblem&, std::size_t, bool>(), nb::arg("steady"),
           nb::arg("problem"), nb::arg("contact"), nb::arg("supports_move"), nb::keep_alive<1, 3>(), "Collective")
      .def("approach", &SpringStart::approach,
           "How far the slave body must be moved against the normal for the springs to bear the force. Collective [L]")
      .def(
          "move",
          [](const SpringStart& self, MutableValues u, double distance) { self.move({u.data(), u.size()}, distance); },
          nb::arg("u").noconvert(), nb::arg("distance"), "Move the slave body against the normal (a view is changed)")
      .def("hand_over", &SpringStart::hand_over, "Give the springs the nodal forces of the equilibrium. Collective");
  m.def(
      "start_from_equilibrium",
      [](ExplicitProblem& problem, const dolfinx_impact::solve::EquilibriumProblem& equilibrium, nb::object observer)
      {
        PythonObserver told(std::move(observer));
        return all_ranks([&] { start_from_equilibrium(problem, equilibrium, told); });
      },
      nb::arg("problem"), nb::arg("equilibrium"), nb::arg("observer"),
      "Begin from an equilibrium with contact; what all ranks throw, or None. Collective");
  m.def(
      "release_limit", [](const FunctionSpace& V, Values stiffness) { return release_limit(V, view(stiffness)); },
      nb::arg("V"), nb::arg("stiffness"), "Energy that a residual of one's own may give. Collective [F L]");
  m.def("released_message", &released_message, nb::arg("released"), nb::arg("limit"), nb::arg("go_on"));
}
} // namespace

void dolfinx_impact::bindings::problems(nb::module_& m)
{
  bind_history(m);
  bind_stable_step(m);
  bind_supports(m);
  bind_explicit(m);
}
