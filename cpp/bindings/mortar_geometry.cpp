// SPDX-License-Identifier: MIT
#include "casters.h"
#include "dolfinx_impact/enforcement/mortar/DeformableGeometry.h"
#include "dolfinx_impact/enforcement/mortar/RigidGeometry.h"
#include "masks.h"
#include <nanobind/stl/optional.h>

using namespace dolfinx_impact::enforcement;
using dolfinx_impact::gap::Multipliers;

namespace
{
using namespace dolfinx_impact::bindings;
typedef MortarGeometry Geometry;

/// Copies of arrays by node of the present state.
auto by_node(std::vector<double> SlaveNodes::* member)
{
  return [member](const Geometry& g) { return array(g.now().*member); };
}

auto by_node(std::vector<std::int8_t> SlaveNodes::* member)
{
  return [member](const Geometry& g) { return mask(g.now().*member); };
}

} // namespace

void dolfinx_impact::bindings::mortar_geometry(nb::module_& m)
{
  nb::class_<MortarOptions>(m, "MortarOptions", "What may be chosen of a contact by multipliers")
      .def(
          "__init__",
          [](MortarOptions* self, std::string name, double friction, Multipliers basis,
             std::optional<int> quadrature_degree, double search_distance, bool axisymmetric,
             const dolfinx_impact::gap::GapAdjustment& adjustment, bool may_share_nodes,
             std::shared_ptr<const dolfinx_impact::enforcement::FrictionLaw> friction_law)
          {
            new (self) MortarOptions{std::move(name), friction,     basis,      quadrature_degree,
                                     search_distance, axisymmetric, adjustment, may_share_nodes};
            self->friction_law = std::move(friction_law);
          },
          nb::kw_only(), nb::arg("name") = "contact", nb::arg("friction") = 0.0, nb::arg("basis") = Multipliers::dual,
          nb::arg("quadrature_degree") = nb::none(), nb::arg("search_distance") = 0.0, nb::arg("axisymmetric") = false,
          nb::arg("adjustment") = dolfinx_impact::gap::GapAdjustment(), nb::arg("may_share_nodes") = true,
          nb::arg("friction_law").none() = nb::none())
      .def_ro("name", &MortarOptions::name)
      .def_ro("friction", &MortarOptions::friction)
      .def_ro("basis", &MortarOptions::basis);
  nb::class_<Geometry>(m, "MortarGeometry", "Nodal gaps, normals and weights of a contact by multipliers; copies")
      .def_prop_ro("slave", &Geometry::slave, nb::rv_policy::reference_internal)
      .def_prop_ro("master", &Geometry::master, nb::rv_policy::reference_internal, "None: it is rigid")
      .def_prop_ro("gdim", &Geometry::gdim)
      .def_prop_ro("basis", [](const Geometry& g) { return g.options().basis; })
      .def_prop_ro("size", &Geometry::size, "Diagonal of the box around the bodies [L]")
      .def_prop_ro("tolerance", &Geometry::tolerance, "Gaps below it are none [L]")
      .def_prop_ro("index_map", &Geometry::map, "Of the space's nodes")
      .def_prop_ro(
          "nodes", [](const Geometry& g) { return array(g.nodes()); }, "Owned blocks of the space, (n)")
      .def_prop_ro(
          "numbers", [](const Geometry& g) { return array(g.numbers()); }, "Their global numbers, (n)")
      .def_prop_ro(
          "fixed", [](const Geometry& g) { return mask(g.fixed(), {g.num_nodes(), std::size_t(g.gdim())}); },
          "Prescribed components, (n, gdim)")
      .def_prop_rw(
          "offset", [](const Geometry& g) { return array(g.offset); },
          [](Geometry& g, Array values)
          {
            if (values.size() != g.num_nodes())
              throw std::invalid_argument("an offset of every node is needed");
            g.offset.assign(values.data(), values.data() + values.size());
          },
          "Added to gaps, (n) [L]")
      .def_prop_ro(
          "points", [](const Geometry& g) { return vectors(g.now().points, g.num_nodes(), g.gdim()); },
          "Positions, (n, gdim) [L]")
      .def_prop_ro("u", [](const Geometry& g) { return array(g.now().u); })
      .def_prop_ro("displacement", [](const Geometry& g)
                   { return array(std::vector(g.increment.displacement.begin(), g.increment.displacement.end())); })
      .def_prop_ro("participates", by_node(&SlaveNodes::participates))
      .def_prop_ro("part", by_node(&SlaveNodes::part))
      .def_prop_ro("weight", by_node(&SlaveNodes::weight), "Diagonal of D, (n) [L^2]")
      .def_prop_ro("cover", by_node(&SlaveNodes::cover), "What faces a master, (n) [L^2]")
      .def_prop_ro("gap", by_node(&SlaveNodes::gap), "Infinite without master, (n) [L]")
      .def_prop_ro("normal", [](const Geometry& g) { return vectors(g.now().normal, g.num_nodes(), g.gdim()); })
      .def(
          "begin_step",
          [](Geometry& g, Array u, std::optional<std::array<double, 3>> displacement, std::optional<Array> target)
          { g.begin_step(view(u), displacement, target ? view(*target) : std::span<const double>()); }, nb::arg("u"),
          nb::arg("displacement").none() = nb::none(), nb::arg("target").none() = nb::none(), "An increment starts")
      .def(
          "update_gap", [](Geometry& g, Array u) { g.update_gap(view(u)); }, nb::arg("u"),
          "Gaps, normals, weights. Collective")
      .def(
          "jump", [](const Geometry& g, Array moved) { return vectors(g.jump(view(moved)), g.num_nodes(), g.gdim()); },
          nb::arg("moved"), "Mean displacements of slave against master, (n, gdim) [L]. Collective")
      .def(
          "slip", [](const Geometry& g) { return vectors(g.slip(), g.num_nodes(), g.gdim()); },
          "Of this increment, (n, gdim) [L]. Collective")
      .def(
          "springs", [](const Geometry& g, Indices rows, Array blocks)
          { return g.springs({rows.data(), rows.size()}, view(blocks)); }, nb::arg("rows"), nb::arg("blocks"),
          nb::rv_policy::take_ownership, "Springs between nodes and what they face [F/L]. Collective")
      .def(
          "tangent",
          [](Geometry& g, Array multiplier, Array traction, Mask active)
          {
            Mat A = g.tangent(view(multiplier), view(traction), view(active));
            return typed<std::optional<Mat>>(A ? nb::cast(A, nb::rv_policy::reference) : nb::none());
          },
          nb::arg("multiplier"), nb::arg("traction"), nb::arg("active"),
          "Derivative of minus the contact force at given multipliers, kept by this object; None: zero. Collective")
      .def(
          "forces", [](const Geometry& g, Array traction) { return take(g.forces(view(traction))); },
          nb::arg("traction"), "Nodal forces on both bodies, owned dofs [F]. Collective");
  nb::class_<DeformableGeometry, Geometry>(m, "DeformableGeometry", "Between two deformable surfaces")
      .def_prop_ro(
          "integrals", [](const DeformableGeometry& g) -> const auto& { return g.integrals(); },
          nb::rv_policy::reference_internal)
      .def_prop_ro("search", &DeformableGeometry::search, nb::rv_policy::reference_internal)
      .def_prop_ro(
          "mortar", [](const DeformableGeometry& g) -> const auto& { return g.integrals().entries(); },
          nb::rv_policy::reference_internal, "Mortar integrals by entries, numbered as the facets' nodes")
      .def_rw("symmetry", &DeformableGeometry::symmetry,
              "Largest tilt of a normal at a plane of symmetry, its sine [1]")
      .def_prop_ro("map", [](const DeformableGeometry& g) { return g.integrals().map(); })
      .def(
          "jump_matrix", [](DeformableGeometry& g) { return g.integrals().jump_matrix(); }, nb::rv_policy::reference,
          "D - M, kept by this object [L^2]. Collective");
  nb::class_<RigidGeometry, Geometry>(m, "RigidGeometry", "Against a rigid obstacle")
      .def_prop_ro(
          "hessian",
          [](const RigidGeometry& g)
          {
            const std::size_t gdim = g.gdim();
            return typed<NumpyArray<double>>(nb::cast(copy(g.now().hessian, {g.num_nodes(), gdim, gdim})));
          },
          "Derivatives of the normals, (n, gdim, gdim) [1/L]");
}
