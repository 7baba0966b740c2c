// SPDX-License-Identifier: MIT
#include "arrays.h"
#include "dolfinx_impact/common/machine.h"
#include "dolfinx_impact/integrators/CentralDifference.h"

namespace nb = nanobind;
using namespace dolfinx_impact::integrators;
using dolfinx_impact::bindings::Indices;
using dolfinx_impact::bindings::MutableValues;
using dolfinx_impact::bindings::NumpyArray;
using dolfinx_impact::bindings::take;
using dolfinx_impact::bindings::Typed;
using dolfinx_impact::bindings::typed;
using dolfinx_impact::bindings::Values;

namespace
{
template <typename T>
std::span<T> span(const nb::ndarray<T, nb::ndim<1>, nb::c_contig, nb::device::cpu>& a)
{
  return {a.data(), a.size()};
}

/// Is told what the handler of a signal has raised, or None, and says whether to stop.
typedef nb::typed<nb::callable, bool(nb::any)> Asked;

/// Runs the handlers of signals that have arrived: Python does so between its own instructions only. What one raises is
/// not thrown through a step, but handed to the caller.
bool interrupted(const Asked& asked)
{
  nb::gil_scoped_acquire lock;
  nb::object error = nb::none();
  if (PyErr_CheckSignals() != 0)
  {
    nb::python_error raised;
    error = nb::borrow(raised.value());
  }
  return nb::cast<bool>(asked(error));
}

Typed<NumpyArray<double>> row(const Energies& e)
{
  const auto values = e.values();
  return typed<NumpyArray<double>>(nb::cast(take(std::vector<double>(values.begin(), values.end()))));
}

} // namespace

void dolfinx_impact::bindings::integrators(nb::module_& m)
{
  m.def("release_memory", &common::release_memory, "Give memory that set-up no longer needs back to the system");
  nb::enum_<Scheme>(m, "Scheme").value("half_step", Scheme::half_step).value("classical", Scheme::classical);
  nb::enum_<WorkKind>(m, "WorkKind", "Which energy the work of a force counts to")
      .value("damping", WorkKind::damping)
      .value("viscosity", WorkKind::viscosity)
      .value("foundation", WorkKind::foundation)
      .value("external", WorkKind::external);
  m.attr("largest_growth") = EnergyBalance::largest_growth;
  nb::class_<FormForces>(m, "FormForces", "Forces of a form, and which coefficients the integrator provides")
      .def(
          "__init__",
          [](FormForces* self, std::shared_ptr<InternalForce> early, std::shared_ptr<InternalForce> outer,
             std::shared_ptr<InternalForce> late, std::string displacement, std::string velocity)
          {
            new (self) FormForces{std::move(early), std::move(outer), std::move(late), std::move(displacement),
                                  std::move(velocity)};
          },
          nb::arg("early").none(), nb::arg("outer").none(), nb::arg("late").none(), nb::arg("displacement") = "",
          nb::arg("velocity") = "");
  nb::class_<CentralDifference>(m, "CentralDifference", "Explicit integration; docs/explicit/scheme.md")
      .def(
          "__init__",
          [](CentralDifference* self, std::shared_ptr<const FunctionSpace> V, const FormForces& internal, bool linear,
             Values mass, double alpha, Scheme scheme)
          { new (self) CentralDifference(V, internal, linear, span(mass), alpha, scheme); },
          nb::arg("V"), nb::arg("internal"), nb::arg("linear"), nb::arg("mass"), nb::arg("alpha"), nb::arg("scheme"))
      .def("add_term", &CentralDifference::add_term, nb::arg("forces"), nb::arg("kind"))
      .def("add_load", [](CentralDifference& self, Indices dofs, Values values, int amplitude)
           { self.add_load(span(dofs), span(values), amplitude); })
      .def("set_load", [](CentralDifference& self, std::size_t i, Values values) { self.set_load(i, span(values)); })
      .def("prescribe", [](CentralDifference& self, Indices dofs, Values values, int amplitude)
           { self.prescribe(span(dofs), span(values), amplitude); })
      .def("add_contact", &CentralDifference::add_contact, nb::arg("pair"), nb::arg("columns"),
           nb::arg("rotation") = std::array{-1, -1, -1})
      .def("set_contact_step", &CentralDifference::set_contact_step)
      .def_prop_ro("contact_step", &CentralDifference::contact_step)
      .def_prop_ro("last_step", &CentralDifference::last_step)
      .def_prop_ro("deformed", &CentralDifference::deformed)
      .def("start", [](CentralDifference& self, Values u, Values v) { self.start(span(u), span(v)); })
      .def(
          "run",
          [](CentralDifference& self, Values steps, Values table, int columns, MutableValues history,
             std::optional<Asked> asked)
          {
            std::function<bool()> ask;
            if (asked)
              ask = [&asked] { return interrupted(*asked); };
            int done = 0;
            {
              nb::gil_scoped_release release;
              done = self.run(span(steps), span(table), columns, span(history), ask);
            }
            if (ask) // a signal since: its handler runs here, not where the caller has not noted the steps yet
              ask();
            return done;
          },
          nb::arg("steps"), nb::arg("table"), nb::arg("columns"), nb::arg("history"), nb::arg("asked") = nb::none(),
          "Steps done. asked: callable that tells whether to stop; it is given what a signal's handler raised, or None")
      .def_prop_ro("stopped", &CentralDifference::stopped)
      .def("energies", [](CentralDifference& self) { return row(self.energies()); })
      .def("motion", [](CentralDifference& self, MutableValues v, MutableValues a) { self.motion(span(v), span(a)); })
      .def(
          "support_forces", [](CentralDifference& self) { return take(self.support_forces()); }, nb::rv_policy::move,
          "Forces of the supports on the bodies, owned. Collective")
      .def(
          "displacement", [](const CentralDifference& self) { return take(self.displacement()); }, nb::rv_policy::move)
      .def("saved_state", &CentralDifference::saved_state, "What the run goes on from beside contacts and materials")
      .def("empty_state", &CentralDifference::empty_state, "A state of that structure, of zeros")
      .def("resume", &CentralDifference::resume, nb::arg("saved"), "Go on from what saved_state has returned")
      .def_prop_ro("gain", [](const CentralDifference& self) { return self.gain().now; })
      .def_prop_ro("most_gained", [](const CentralDifference& self) { return self.gain().most; })
      .def_prop_ro("released", &CentralDifference::released)
      .def_prop_rw("release_limit", &CentralDifference::release_limit, &CentralDifference::set_release_limit)
      .def("fastest", &CentralDifference::fastest)
      .def("revise", &CentralDifference::revise, "Forces of forms anew: what they read has changed. Collective")
      .def(
          "passage",
          [](const CentralDifference& self)
          {
            const auto [contact, p] = self.passage();
            return std::tuple(contact, p.node, p.facets);
          },
          "Contact (-1: none), local node, facets per step of the slave node that went through a master fastest")
      .def("update_gaps", &CentralDifference::update_gaps)
      .def_prop_ro("traffic", [](const CentralDifference& self)
                   { return std::pair(self.traffic().messages, self.traffic().values); })
      .def_prop_ro(
          "waited", [](const CentralDifference& self) { return self.traffic().waited; },
          "Time that this rank has waited for its neighbours' messages so far [s]")
      .def_prop_ro("contact_seconds", &CentralDifference::contact_seconds);
}
