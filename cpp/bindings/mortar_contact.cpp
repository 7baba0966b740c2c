// SPDX-License-Identifier: MIT
#include "casters.h"
#include "dolfinx_impact/enforcement/mortar/MortarContact.h"
#include "masks.h"
#include <nanobind/stl/optional.h>

using namespace dolfinx_impact::enforcement;
using dolfinx_impact::gap::Rigid;
using dolfinx_impact::surface::Facets;
using dolfinx_impact::surface::FunctionSpace;

namespace
{
using namespace dolfinx_impact::bindings;
typedef MortarContact Contact;

/// Vectors by node of a contact, (n, gdim).
Typed<NumpyArray<double>> by_node(const Contact& c, std::vector<double> values)
{
  return vectors(std::move(values), c.geometry().num_nodes(), c.geometry().gdim());
}

template <typename T, typename A>
void assign(std::vector<T>& to, const A& values)
{
  const auto from = view(values);
  if (from.size() != to.size())
    throw std::invalid_argument("a value of every node of the contact is needed");
  std::copy(from.begin(), from.end(), to.begin());
}

/// Functions that read and write an array of the state: numbers, vectors or masks by node; copies.
auto get(std::vector<double> MortarState::* member)
{
  return [member](const Contact& c) { return array(c.nodal_state().*member); };
}

auto get_vectors(std::vector<double> MortarState::* member)
{
  return [member](const Contact& c) { return by_node(c, c.nodal_state().*member); };
}

auto get(std::vector<std::int8_t> MortarState::* member)
{
  return [member](const Contact& c) { return mask(c.nodal_state().*member); };
}

auto set(std::vector<double> MortarState::* member)
{
  return [member](Contact& c, Array values) { assign(c.nodal_state().*member, values); };
}

auto set(std::vector<std::int8_t> MortarState::* member)
{
  return [member](Contact& c, Mask values) { assign(c.nodal_state().*member, values); };
}

void bind_state(nb::class_<Contact, MultiplierContact>& c)
{
  c.def("state", &Contact::state, nb::keep_alive<0, 1>(), "What an increment starts from, views")
      .def_prop_rw("active", get(&MortarState::active), set(&MortarState::active), "In contact, (n)")
      .def_prop_rw("sliding", get(&MortarState::sliding), set(&MortarState::sliding), "Of those, slipping, (n)")
      .def_prop_rw("direction", get_vectors(&MortarState::direction), set(&MortarState::direction))
      .def_prop_rw("multiplier", get(&MortarState::multiplier), set(&MortarState::multiplier), "(n) [F/L^2]")
      .def_prop_rw("friction_traction", get_vectors(&MortarState::friction_traction),
                   set(&MortarState::friction_traction))
      .def_prop_rw("traction_n", get_vectors(&MortarState::traction_n), set(&MortarState::traction_n))
      .def_prop_rw("total_slip", get_vectors(&MortarState::total_slip), set(&MortarState::total_slip))
      .def_prop_rw(
          "opening",
          [](const Contact& c)
          {
            return typed<std::optional<NumpyArray<double>>>(c.nodal_state().begun ? array(c.nodal_state().opening)
                                                                                  : nb::none());
          },
          [](Contact& c, Array values)
          {
            assign(c.nodal_state().opening, values);
            c.nodal_state().begun = 1;
          },
          "Gap at the start of the increment where a node is open, else zero; None before the first, (n) [L]")
      .def_prop_rw(
          "linearised_gap",
          [](const Contact& c)
          {
            const auto gap = c.linearised_gap();
            return array(std::vector<double>(gap.begin(), gap.end()));
          },
          [](Contact& c, Array gap) { c.set_linearised(c.active(), view(gap), c.multiplier()); },
          "Gaps of the linearised problem, (n) [L]");
}

void bind_linear_problems(nb::class_<Contact, MultiplierContact>& c)
{
  c.def(
       "update_multipliers", [](Contact& c, Array residual) { c.update_multipliers(view(residual)); },
       nb::arg("residual"), "Multipliers from equilibrium of the slave's nodes")
      .def(
          "set_multipliers", [](Contact& c, Array forces) { c.set_multipliers(view(forces)); }, nb::arg("forces"),
          "Multipliers from a saddle point's forces")
      .def("rotate_friction_traction", &Contact::rotate_friction_traction)
      .def("constraints", &Contact::constraints, "Constraints of the active nodes for the linear system")
      .def(
          "friction_springs",
          [](Contact& c)
          {
            auto found = c.friction_springs();
            nb::object springs = nb::none();
            if (found)
              springs =
                  nb::make_tuple(nb::cast(found->first, nb::rv_policy::take_ownership), take(std::move(found->second)));
            return typed<std::optional<std::pair<Mat, NumpyArray<double>>>>(springs);
          },
          "Matrix of the caller's own and forces, or None. Collective")
      .def("imposed_friction_forces", [](const Contact& c) { return array(c.imposed_friction_forces()); })
      .def(
          "update_linearised_gap", [](Contact& c, Array increments) { c.update_linearised_gap(view(increments)); },
          nb::arg("increments"), "Gaps and slips after a linear solution. Collective")
      .def(
          "linearised_response",
          [](const Contact& c, Array increments, Array forces)
          {
            auto found = c.linearised_response(view(increments), view(forces));
            return std::pair(take(std::move(found.first)), take(std::move(found.second)));
          },
          nb::arg("increments"), nb::arg("forces"), "What gaps and multipliers gain, without friction. Collective")
      .def(
          "correct_linearisation", [](Contact& c, Array u) { c.correct_linearisation(view(u)); }, nb::arg("u"),
          "Second-order correction. Collective")
      .def("num_turning", &Contact::num_turning)
      .def(
          "set_redundant", [](Contact& c, Indices nodes) { c.set_redundant({nodes.data(), nodes.size()}); },
          nb::arg("nodes"))
      .def("over_constrained", [](const Contact& c) { return array(c.over_constrained()); })
      .def("gap_round_off", &Contact::gap_round_off)
      .def(
          "unit_gap", [](const Contact& c, std::int64_t number) { return array(c.unit_gap(number)); },
          nb::arg("number"))
      .def(
          "unit_force", [](const Contact& c, std::int64_t number) { return array(c.unit_force(number)); },
          nb::arg("number"), "Collective")
      .def_prop_ro("last_change", &Contact::last_change);
}

std::vector<std::int8_t> owned(const Mask& mask)
{
  return {view(mask).begin(), view(mask).end()};
}
} // namespace

void dolfinx_impact::bindings::mortar_contact(nb::module_& m)
{
  nb::class_<Contact, MultiplierContact> c(m, "MortarContact", "Contact of a pair by multipliers; arrays are copies");
  c.def(
       "__init__",
       [](Contact* self, std::shared_ptr<const FunctionSpace> V, const Facets& slave, const Facets& master,
          const MortarOptions& options, Mask fixed)
       { new (self) Contact(std::move(V), slave, master, options, owned(fixed)); },
       nb::arg("V"), nb::arg("slave"), nb::arg("master"), nb::arg("options"), nb::arg("fixed"), "Collective")
      .def(
          "__init__",
          [](Contact* self, std::shared_ptr<const FunctionSpace> V, const Facets& slave,
             std::shared_ptr<const Rigid> master, const MortarOptions& options, Mask fixed)
          { new (self) Contact(std::move(V), slave, std::move(master), options, owned(fixed)); },
          nb::arg("V"), nb::arg("slave"), nb::arg("master"), nb::arg("options"), nb::arg("fixed"), "Collective")
      .def("update_totals", &Contact::update_totals, "Force, moment, area and work of friction. Collective")
      .def_prop_ro(
          "geometry", [](Contact& c) -> MortarGeometry& { return c.geometry(); }, nb::rv_policy::reference_internal)
      .def_prop_ro("initial", &Contact::initial_penetration, nb::rv_policy::reference_internal)
      .def_prop_ro(
          "totals", [](Contact& c) -> ContactTotals& { return c.totals(); }, nb::rv_policy::reference_internal)
      .def_prop_ro("friction", &Contact::friction, "The largest coefficient that acts at a node [1]")
      .def_prop_ro(
          "friction_coefficients", [](const Contact& c) { return array(c.friction_coefficients()); },
          "At the nodes, (n) [1]. Collective")
      .def_prop_ro(
          "usable", [](const Contact& c) { return mask(c.usable()); },
          "Nodes that carry a multiplier and may be moved along the normal, (n)")
      .def_prop_ro("nodal_stiffness", [](const Contact& c) { return array(c.nodal_stiffness()); }, "(n) [F/L]");
  bind_state(c);
  bind_linear_problems(c);
}
