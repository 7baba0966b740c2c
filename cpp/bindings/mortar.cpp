// SPDX-License-Identifier: MIT
#include "dolfinx_impact/gap/mortar.h"
#include "arrays.h"
#include "dolfinx_impact/gap/FacetShape.h"
#include "dolfinx_impact/gap/HeightField.h"
#include "dolfinx_impact/gap/Rigid.h"
#include "dolfinx_impact/search/pairs.h"

using namespace dolfinx_impact::gap;
using dolfinx_impact::surface::Facets;

namespace
{
using namespace dolfinx_impact::bindings;
typedef nb::ndarray<const std::int8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu> Flags;

SegmentRule rule(const Facets& slave, const Values& points, const Values& weights)
{
  if (points.size() != weights.size() * (slave.gdim - 1) || weights.size() == 0)
    throw std::invalid_argument("a rule needs as many points as weights, and at least one");
  return {{points.data(), points.size()}, {weights.data(), weights.size()}};
}

/// Rows, columns and values.
auto as_arrays(const Entries& e)
{
  typedef std::tuple<NumpyArray<std::int32_t>, NumpyArray<std::int32_t>, NumpyArray<double>> Arrays;
  return typed<Arrays>(
      nb::make_tuple(copy(e.rows, {e.rows.size()}), copy(e.cols, {e.cols.size()}), copy(e.values, {e.values.size()})));
}

void check_nodal(const Facets& facets, std::size_t size, int block)
{
  for (std::int32_t node : facets.nodes)
    if (std::size_t(node + 1) * block > size)
      throw std::invalid_argument("the nodal values are fewer than the surface's nodes");
}
} // namespace

void dolfinx_impact::bindings::mortar(nb::module_& m)
{
  nb::class_<Shape>(m, "Shape", "Surface of a rigid obstacle of any form");
  nb::class_<HeightField, Shape>(m, "HeightField", "A cubic spline over a plane")
      .def(
          "__init__",
          [](HeightField* self, int gdim, std::array<double, 3> origin, std::array<std::array<double, 3>, 3> axes,
             std::array<double, 2> low, std::array<double, 2> spacing, std::array<int, 2> cells, Values coefficients)
          {
            std::vector<double> c(coefficients.data(), coefficients.data() + coefficients.size());
            new (self) HeightField(gdim, origin, axes, {low, spacing, cells}, std::move(c));
          },
          nb::arg("gdim"), nb::arg("origin"), nb::arg("axes"), nb::arg("low"), nb::arg("spacing"), nb::arg("cells"),
          nb::arg("coefficients"));
  nb::class_<FacetShape, Shape>(m, "FacetShape", "Segments or triangles")
      .def(
          "__init__", [](FacetShape* self, int gdim, Values points, Indices facets)
          { new (self) FacetShape(gdim, {points.data(), points.size()}, {facets.data(), facets.size()}); },
          nb::arg("gdim"), nb::arg("points"), nb::arg("facets"));
  nb::class_<Rigid>(m, "Rigid", "A rigid obstacle: plane, sphere, cylinder, surface")
      .def(
          "__init__",
          [](Rigid* self, std::shared_ptr<const Shape> shape)
          {
            new (self) Rigid{.kind = Rigid::Kind::surface, .gdim = shape->gdim()};
            self->shape = std::move(shape);
          },
          nb::arg("shape"))
      .def(
          "__init__",
          [](Rigid* self, const std::string& kind, int gdim, std::array<double, 3> point,
             std::array<double, 3> direction, double radius)
          {
            const auto k = kind == "plane"    ? Rigid::Kind::plane
                           : kind == "sphere" ? Rigid::Kind::sphere
                                              : Rigid::Kind::cylinder;
            new (self) Rigid{.kind = k, .gdim = gdim, .point = point, .direction = direction, .radius = radius};
          },
          nb::arg("kind"), nb::arg("gdim"), nb::arg("point"), nb::arg("direction"), nb::arg("radius"))
      .def_rw("displacement", &Rigid::displacement)
      .def_rw("centre", &Rigid::centre, "About which it rotates, before the displacement")
      .def_rw("rotates", &Rigid::rotates, "Without, the rotation has no effect")
      .def_rw("rotation", &Rigid::rotation, "A matrix, row by row")
      .def_rw("orientation_hint", &Rigid::orientation_hint, "What can be changed if the body is on its wrong side")
      .def(
          "evaluate",
          [](const Rigid& self, Values x)
          {
            const std::size_t gdim = self.gdim, num = x.size() / gdim;
            std::vector<double> gap(num), normal(num * gdim), hessian(num * gdim * gdim);
            for (std::size_t i = 0; i < num; ++i)
            {
              const RigidPoint p = dolfinx_impact::gap::evaluate(self, std::span(x.data() + i * gdim, gdim));
              gap[i] = p.gap;
              for (std::size_t a = 0; a < gdim; ++a)
              {
                normal[i * gdim + a] = p.normal[a];
                for (std::size_t b = 0; b < gdim; ++b)
                  hessian[(i * gdim + a) * gdim + b] = p.hessian[3 * a + b];
              }
            }
            return std::tuple(take(std::move(gap)), take(std::move(normal), {num, gdim}),
                              take(std::move(hessian), {num, gdim, gdim}));
          },
          nb::arg("x"), "Gaps, normals and their derivatives at points (flat array of coordinates)");
  nb::class_<Segments>(m, "Segments", "Quadrature points where slave facets face master facets; properties are copies")
      .def_prop_ro(
          "slave", [](const Segments& s) { return copy(s.slave, {s.slave.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "master", [](const Segments& s) { return copy(s.master, {s.master.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "weight", [](const Segments& s) { return copy(s.weight, {s.weight.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "covered", [](const Segments& s) { return copy(s.covered, {s.covered.size()}); }, nb::rv_policy::move);
  m.def(
      "segment",
      [](const Facets& slave, const Facets& master, Values points, Values weights, double reach, bool axisymmetric)
      {
        const auto near = dolfinx_impact::search::near_facets(slave, master, reach);
        return segment(slave, master, near.pairs, near.offsets, rule(slave, points, weights), reach, axisymmetric);
      },
      nb::arg("slave"), nb::arg("master"), nb::arg("points"), nb::arg("weights"), nb::arg("reach"),
      nb::arg("axisymmetric") = false, "Segments of slave facets with the master facets within reach of them");
  nb::class_<Mortar>(m, "Mortar", "Mortar integrals; properties are copies")
      .def_prop_ro("D", [](const Mortar& s) { return as_arrays(s.D); })
      .def_prop_ro("M", [](const Mortar& s) { return as_arrays(s.M); })
      .def_prop_ro(
          "gamma", [](const Mortar& s) { return copy(s.gamma, {s.gamma.size()}); }, nb::rv_policy::move)
      .def_prop_ro("psi", [](const Mortar& s) { return copy(s.psi, {s.psi.size()}); }, nb::rv_policy::move);
  nb::enum_<Multipliers>(m, "Multipliers", "Functions of the multipliers")
      .value("dual", Multipliers::dual)
      .value("standard", Multipliers::standard)
      .value("linear", Multipliers::linear);
  m.def(
      "cover", [](const Facets& slave, const Segments& segments, Multipliers basis)
      { return take(cover(slave, segments, basis), {slave.size(), std::size_t(slave.displacement.num_nodes())}); },
      nb::arg("slave"), nb::arg("segments"), nb::arg("basis"),
      "Integrals of the multiplier functions over the points of each facet, (facets, nodes)");
  m.def(
      "mortar",
      [](const Facets& slave, const Facets& master, const Segments& segments, Multipliers basis, const Flags& carries)
      {
        check_nodal(slave, carries.size(), 1);
        return mortar(slave, master, segments, basis, {carries.data(), carries.size()});
      },
      nb::arg("slave"), nb::arg("master"), nb::arg("segments"), nb::arg("basis"), nb::arg("carries"),
      "Mortar integrals; `carries` (by node, int8) marks the nodes that have a multiplier");
  m.def(
      "turning_tangent",
      [](const Facets& slave, Values sums, Values force)
      {
        check_nodal(slave, sums.size(), slave.gdim);
        check_nodal(slave, force.size(), 1);
        return as_arrays(turning_tangent(slave, {sums.data(), sums.size()}, {force.data(), force.size()}));
      },
      nb::arg("slave"), nb::arg("sums"), nb::arg("force"));
}
