// SPDX-License-Identifier: MIT
#include "arrays.h"
#include "dolfinx_impact/common/machine.h"
#include "dolfinx_impact/integrators/CentralDifference.h"

namespace nb = nanobind;
using namespace dolfinx_impact::integrators;
using dolfinx_impact::bindings::Indices;
using dolfinx_impact::bindings::MutableValues;
using dolfinx_impact::bindings::Values;

namespace
{
template <typename T>
std::span<T> span(const nb::ndarray<T, nb::ndim<1>, nb::c_contig, nb::device::cpu>& a)
{
  return {a.data(), a.size()};
}

FormForces forces(nb::object inner, nb::object outer, std::string displacement, std::string velocity)
{
  FormForces f{nullptr, nullptr, displacement, velocity};
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
  const auto values = e.values();
  return nb::cast(dolfinx_impact::bindings::take(std::vector<double>(values.begin(), values.end())));
}

using Saved = CentralDifference::Saved;

/// Calls f(name, value) for what adds up over ranks.
void each_work(Saved& s, const auto& f)
{
  f("residual", s.energies.residual_work);
  f("loads", s.energies.load_work);
  f("supports", s.energies.support_work);
  f("mass_damping", s.energies.damped);
  f("elastic", s.energies.elastic);
  f("obstacles", s.obstacle_work);
  const auto term = [&f](const std::string& name, Saved::Term& t)
  {
    f(name + "_done", t.work.done);
    f(name + "_before", t.work.before);
    f(name + "_position", t.position);
  };
  term("springs", s.springs);
  for (std::size_t k = 0; k < s.terms.size(); ++k)
    term("term" + std::to_string(k), s.terms[k]);
}

/// Calls f(name, value) for what is the same on all ranks.
void each_common(Saved& s, const auto& f)
{
  f("reference", s.energies.reference);
  f("lowest", s.energies.lowest);
  f("largest", s.energies.largest);
  f("release_share", s.energies.release_share);
  f("release_limit", s.energies.release_limit);
  f("last_step", s.last_step);
  f("contact_step", s.contact_step);
  f("unwatched", s.unwatched);
  for (std::size_t k = 0; k < s.obstacles.size(); ++k)
    for (int c = 0; c < 3; ++c)
    {
      const std::string end = std::to_string(k) + "_" + "xyz"[c];
      f("obstacle" + end, s.obstacles[k].displacement[c]);
      f("obstacle_increment" + end, s.obstacles[k].increment[c]);
      f("obstacle_increment_before" + end, s.obstacles[k].increment_before[c]);
    }
}

nb::dict to_dict(Saved s)
{
  nb::dict arrays, works, common, out;
  each_work(s, [&works](const std::string& name, double value) { works[name.c_str()] = value; });
  each_common(s, [&common](const std::string& name, double value) { common[name.c_str()] = value; });
  const auto add = [&arrays](const std::string& name, std::vector<double>& values)
  { arrays[name.c_str()] = nb::cast(dolfinx_impact::bindings::take(std::move(values))); };
  add("u", s.u);
  add("v", s.v);
  add("r", s.r);
  add("springs", s.springs.force);
  add("kinematic", s.kinematic);
  for (std::size_t k = 0; k < s.terms.size(); ++k)
    add("term" + std::to_string(k), s.terms[k].force);
  out["arrays"] = arrays;
  out["works"] = works;
  out["common"] = common;
  return out;
}

Saved from_dict(const CentralDifference& run, const nb::dict& arrays, const nb::dict& works, const nb::dict& common)
{
  Saved s;
  s.terms.resize(run.num_terms());
  s.obstacles.resize(run.num_contacts());
  each_work(s, [&works](const std::string& name, double& value) { value = nb::cast<double>(works[name.c_str()]); });
  each_common(s, [&common](const std::string& name, double& value) { value = nb::cast<double>(common[name.c_str()]); });
  const auto get = [&arrays](const std::string& name)
  {
    const auto a = nb::cast<Values>(arrays[name.c_str()]);
    return std::vector<double>(a.data(), a.data() + a.size());
  };
  s.u = get("u");
  s.v = get("v");
  s.r = get("r");
  s.springs.force = get("springs");
  s.kinematic = get("kinematic");
  for (std::size_t k = 0; k < s.terms.size(); ++k)
    s.terms[k].force = get("term" + std::to_string(k));
  return s;
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
          [](FormForces* self, nb::object inner, nb::object outer, std::string displacement, std::string velocity)
          { new (self) FormForces(forces(inner, outer, displacement, velocity)); }, nb::arg("inner").none(),
          nb::arg("outer").none(), nb::arg("displacement") = "", nb::arg("velocity") = "");
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
      .def("add_contact", &CentralDifference::add_contact, nb::arg("pair"), nb::arg("columns"))
      .def("set_contact_step", &CentralDifference::set_contact_step)
      .def_prop_ro("contact_step", &CentralDifference::contact_step)
      .def(
          "add_watch", [](CentralDifference& self, Indices nodes, int nodes_per_cell)
          { self.add_watch(span(nodes), nodes_per_cell); }, nb::arg("nodes"), nb::arg("nodes_per_cell"))
      .def(
          "set_watch", [](CentralDifference& self, Values u, Values allowed)
          { self.set_watch(span(u), span(allowed)); }, nb::arg("u"), nb::arg("allowed"))
      .def("deformations", [](CentralDifference& self, Values u) { return take(self.deformations(span(u))); })
      .def_prop_ro("deformed", &CentralDifference::deformed)
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
      .def(
          "save", [](CentralDifference& self) { return to_dict(self.save()); },
          "Dict of dicts: arrays (owned entries), works (add up over ranks), common (the same on all ranks)")
      .def(
          "restore", [](CentralDifference& self, const nb::dict& arrays, const nb::dict& works, const nb::dict& common)
          { self.restore(from_dict(self, arrays, works, common)); }, nb::arg("arrays"), nb::arg("works"),
          nb::arg("common"))
      .def(
          "saved_names",
          [](const CentralDifference& self)
          {
            Saved s;
            s.terms.resize(self.num_terms());
            s.obstacles.resize(self.num_contacts());
            return to_dict(std::move(s));
          },
          "Such a dict without values: which names there are")
      .def_prop_ro("gain", [](const CentralDifference& self) { return self.gain().now; })
      .def_prop_ro("most_gained", [](const CentralDifference& self) { return self.gain().most; })
      .def_prop_rw("gain_limit", &CentralDifference::gain_limit, &CentralDifference::set_gain_limit)
      .def_prop_ro("released", &CentralDifference::released)
      .def_prop_rw("release_limit", &CentralDifference::release_limit, &CentralDifference::set_release_limit)
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
      .def("update_gaps", &CentralDifference::update_gaps)
      .def_prop_ro("num_searches", &CentralDifference::num_searches)
      .def_prop_ro("traffic", [](const CentralDifference& self)
                   { return std::pair(self.traffic().messages, self.traffic().values); })
      .def_prop_ro("contact_seconds", &CentralDifference::contact_seconds)
      .def_prop_ro("row_size", &CentralDifference::row_size);
}
