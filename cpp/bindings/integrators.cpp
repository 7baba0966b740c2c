#include "arrays.h"
#include "dolfinx_impact/common/machine.h"
#include "dolfinx_impact/integrators/CentralDifference.h"

namespace nb = nanobind;
using namespace impact::integrators;
using impact::bindings::Indices;
using impact::bindings::MutableValues;
using impact::bindings::Values;

namespace
{
template <typename T>
std::span<T> span(const nb::ndarray<T, nb::ndim<1>, nb::c_contig, nb::device::cpu>& a)
{
  return {a.data(), a.size()};
}

Forces forces(nb::object inner, nb::object outer, std::string displacement, std::string velocity)
{
  Forces f{nullptr, nullptr, displacement, velocity};
  if (!inner.is_none())
    f.inner = nb::cast<std::shared_ptr<InternalForce>>(inner);
  if (!outer.is_none())
    f.outer = nb::cast<std::shared_ptr<InternalForce>>(outer);
  return f;
}

/// Runs the handlers of signals that have arrived: Python does so between its own instructions only. What one raises is
/// not thrown through a step, but handed to the caller.
bool interrupted(const nb::object& asked)
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

nb::object row(const Energies& e)
{
  return nb::cast(impact::bindings::take(std::vector<double>(e.values.begin(), e.values.end())));
}
} // namespace

void impact::bindings::integrators(nb::module_& m)
{
  m.def("release_memory", &common::release_memory, "Give memory that set-up no longer needs back to the system");
  nb::enum_<Scheme>(m, "Scheme").value("half_step", Scheme::half_step).value("classical", Scheme::classical);
  nb::enum_<Account>(m, "Account")
      .value("damping", Account::damping)
      .value("viscosity", Account::viscosity)
      .value("external", Account::external);
  nb::class_<Forces>(m, "Forces", "Forces of a form, and which coefficients the integrator has")
      .def(
          "__init__",
          [](Forces* self, nb::object inner, nb::object outer, std::string displacement, std::string velocity)
          { new (self) Forces(forces(inner, outer, displacement, velocity)); }, nb::arg("inner").none(),
          nb::arg("outer").none(), nb::arg("displacement") = "", nb::arg("velocity") = "");
  nb::class_<CentralDifference>(m, "CentralDifference", "Explicit integration; docs/explicit.md")
      .def(
          "__init__",
          [](CentralDifference* self, std::shared_ptr<const FunctionSpace> V, const Forces& internal, bool linear,
             Values mass, double alpha, Scheme scheme)
          { new (self) CentralDifference(V, internal, linear, span(mass), alpha, scheme); },
          nb::arg("V"), nb::arg("internal"), nb::arg("linear"), nb::arg("mass"), nb::arg("alpha"), nb::arg("scheme"))
      .def("add_term", &CentralDifference::add_term, nb::arg("forces"), nb::arg("account"))
      .def("add_load", [](CentralDifference& self, Indices dofs, Values values, int amplitude)
           { self.add_load(span(dofs), span(values), amplitude); })
      .def("set_load", [](CentralDifference& self, std::size_t i, Values values) { self.set_load(i, span(values)); })
      .def("prescribe", [](CentralDifference& self, Indices dofs, Values values, int amplitude)
           { self.prescribe(span(dofs), span(values), amplitude); })
      .def("add_contact", &CentralDifference::add_contact, nb::arg("contact"), nb::arg("columns"))
      .def("set_contact_step", &CentralDifference::set_contact_step)
      .def("start", [](CentralDifference& self, Values u, Values v) { self.start(span(u), span(v)); })
      .def(
          "run",
          [](CentralDifference& self, Values steps, Values table, int columns, MutableValues history, nb::object asked)
          {
            std::function<bool()> ask;
            if (!asked.is_none())
              ask = [&asked] { return interrupted(asked); };
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
          "displacement",
          [](const CentralDifference& self)
          {
            const auto u = self.displacement();
            return take(std::vector<double>(u.begin(), u.end()));
          },
          nb::rv_policy::move)
      .def("save",
           [](CentralDifference& self)
           {
             CentralDifference::Saved s = self.save();
             nb::dict out;
             out["u"] = nb::cast(take(std::move(s.u)));
             out["v"] = nb::cast(take(std::move(s.v)));
             out["r"] = nb::cast(take(std::move(s.r)));
             out["parts"] = nb::cast(take(std::move(s.parts)));
             out["accounts"] = nb::cast(take(std::move(s.accounts)));
             return out;
           })
      .def(
          "restore",
          [](CentralDifference& self, Values u, Values v, Values r, Values parts, Values accounts)
          {
            const auto vector = [](const Values& a) { return std::vector<double>(a.data(), a.data() + a.size()); };
            self.restore({vector(u), vector(v), vector(r), vector(parts), vector(accounts)});
          },
          nb::arg("u"), nb::arg("v"), nb::arg("r"), nb::arg("parts"), nb::arg("accounts"))
      .def_prop_ro("gain", [](const CentralDifference& self) { return self.gain().now; })
      .def_prop_ro("most_gained", [](const CentralDifference& self) { return self.gain().most; })
      .def_prop_rw("gain_limit", &CentralDifference::gain_limit, &CentralDifference::set_gain_limit)
      .def("fastest", &CentralDifference::fastest)
      .def("revise", &CentralDifference::revise, "Forces of forms anew: what they read has changed. Collective")
      .def(
          "passage",
          [](const CentralDifference& self)
          {
            const auto [contact, p] = self.passage();
            return nb::make_tuple(contact, p.node, p.facets);
          },
          "Contact (-1: none), local node, facets per step of the slave node that went through a master fastest")
      .def("look", &CentralDifference::look)
      .def_prop_ro("num_searches", &CentralDifference::num_searches)
      .def_prop_ro("traffic", [](const CentralDifference& self)
                   { return std::pair(self.traffic().messages, self.traffic().values); })
      .def_prop_ro("contact_seconds", &CentralDifference::contact_seconds)
      .def_prop_ro("num_additive", &CentralDifference::num_additive)
      .def_prop_ro("row_size", &CentralDifference::row_size)
      .def_prop_ro("num_saved_parts", &CentralDifference::num_saved_parts);
}
