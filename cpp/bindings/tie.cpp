// SPDX-License-Identifier: MIT
#include "dolfinx_impact/enforcement/mortar/Tie.h"
#include "casters.h"
#include "dolfinx_impact/enforcement/mortar/ExplicitTie.h"
#include "dolfinx_impact/enforcement/mortar/adjust_tie.h"
#include "masks.h"
#include "petsc_objects.h"
#include <nanobind/stl/optional.h>

using namespace dolfinx_impact::enforcement;
using dolfinx_impact::gap::Multipliers;
using dolfinx_impact::surface::Facets;
using dolfinx_impact::surface::FunctionSpace;

namespace
{
using namespace dolfinx_impact::bindings;

/// Vectors by node, (n, gdim).
Typed<NumpyArray<double>> by_node(const TieConditions& c, std::vector<double> values)
{
  return vectors(std::move(values), c.num_nodes(), c.gdim());
}

std::vector<std::int8_t> owned(const Mask& mask)
{
  return {view(mask).begin(), view(mask).end()};
}

void bind_conditions(nb::module_& m)
{
  nb::class_<TieOptions>(m, "TieOptions", "What may be chosen of a tie")
      .def(
          "__init__",
          [](TieOptions* self, std::string name, bool normal_only, bool partial, Multipliers basis,
             std::optional<int> quadrature_degree, double search_distance, bool axisymmetric)
          {
            new (self) TieOptions{std::move(name),   normal_only,     partial,     basis,
                                  quadrature_degree, search_distance, axisymmetric};
          },
          nb::kw_only(), nb::arg("name") = "tie", nb::arg("normal_only") = false, nb::arg("partial") = false,
          nb::arg("basis") = Multipliers::dual, nb::arg("quadrature_degree") = nb::none(),
          nb::arg("search_distance") = 0.0, nb::arg("axisymmetric") = false)
      .def_ro("name", &TieOptions::name)
      .def_ro("normal_only", &TieOptions::normal_only)
      .def_ro("basis", &TieOptions::basis);
  nb::class_<TieConditions>(m, "TieConditions", "Conditions C u = 0 of a tie; arrays are copies")
      .def(
          "__init__",
          [](TieConditions* self, std::shared_ptr<const FunctionSpace> V, const Facets& slave, const Facets& master,
             const TieOptions& options, Mask fixed)
          { new (self) TieConditions(std::move(V), slave, master, options, owned(fixed)); },
          nb::arg("V"), nb::arg("slave"), nb::arg("master"), nb::arg("options"), nb::arg("fixed"), "Collective")
      .def_prop_ro("nodes", [](const TieConditions& c)
                   { return array(std::vector<std::int32_t>(c.nodes().begin(), c.nodes().end())); })
      .def_prop_ro("numbers", [](const TieConditions& c)
                   { return array(std::vector<std::int64_t>(c.numbers().begin(), c.numbers().end())); })
      .def_prop_ro(
          "points", [](const TieConditions& c) { return by_node(c, c.points()); }, "Reference, (n, gdim) [L]")
      .def_prop_ro(
          "normal", [](const TieConditions& c) { return by_node(c, c.normal()); }, "Reference, (n, gdim)")
      .def_prop_ro("size", &TieConditions::size, "Diagonal of the box around the bodies [L]")
      .def_prop_ro("num_free", &TieConditions::num_free, "Slave nodes of all ranks without a master")
      .def_prop_ro(
          "area", [](const TieConditions& c) { return array(c.area()); }, "(n) [L^2]")
      .def_prop_ro(
          "offset", [](const TieConditions& c) { return by_node(c, c.offset()); }, "(n, gdim) [L]")
      .def_prop_ro("rows", &TieConditions::rows, nb::rv_policy::reference_internal)
      .def_prop_ro("matrix", &TieConditions::matrix, nb::rv_policy::reference, "C, kept by this object")
      .def(
          "jump", [](const TieConditions& c, Array u) { return by_node(c, c.jump(view(u))); }, nb::arg("u"),
          "C u over the weights, (n, gdim) [L]. Collective")
      .def(
          "forces", [](const TieConditions& c, Array z) { return take(c.forces(view(z))); }, nb::arg("z"),
          "C^T z, owned [F]. Collective");
  m.def("adjust_tie", &adjust_tie, nb::arg("mesh"), nb::arg("conditions"),
        "Move the slave's nodes by what the surfaces are apart. Returns the largest motion [L]. Collective");
}
} // namespace

void dolfinx_impact::bindings::tie(nb::module_& m)
{
  bind_conditions(m);
  nb::class_<Tie, MultiplierContact>(m, "Tie", "Two surfaces tied to each other; arrays are copies")
      .def(
          "__init__",
          [](Tie* self, std::shared_ptr<const FunctionSpace> V, const Facets& slave, const Facets& master,
             const TieOptions& options, Mask fixed)
          { new (self) Tie(std::move(V), slave, master, options, owned(fixed)); },
          nb::arg("V"), nb::arg("slave"), nb::arg("master"), nb::arg("options"), nb::arg("fixed"), "Collective")
      .def_prop_ro("conditions", &Tie::conditions, nb::rv_policy::reference_internal)
      .def_prop_ro(
          "totals", [](Tie& c) -> ContactTotals& { return c.totals(); }, nb::rv_policy::reference_internal)
      .def("constraints", &Tie::constraints, "Constraints of all nodes for the linear system");
}

void dolfinx_impact::bindings::explicit_tie(nb::module_& m)
{
  nb::class_<ExplicitTie, NodalContact>(m, "ExplicitTie", "Two surfaces tied in an explicit problem")
      .def(
          "__init__",
          [](ExplicitTie* self, std::shared_ptr<const FunctionSpace> V, const Facets& slave, const Facets& master,
             const TieOptions& options, Mask fixed)
          { new (self) ExplicitTie(std::move(V), slave, master, options, owned(fixed)); },
          nb::arg("V"), nb::arg("slave"), nb::arg("master"), nb::arg("options"), nb::arg("fixed"), "Collective")
      .def_prop_ro("conditions", &ExplicitTie::conditions, nb::rv_policy::reference_internal)
      .def_prop_ro(
          "traction", [](const ExplicitTie& c) { return by_node(c.conditions(), c.traction()); },
          "Of the last step, (n, gdim) [F/L^2]")
      .def(
          "forces", [](const ExplicitTie& c) { return take(c.forces()); },
          "Nodal forces of the last step on both surfaces, owned [F]. Collective");
}
