// SPDX-License-Identifier: MIT
#include "dolfinx_impact/surface/Surface.h"
#include "arrays.h"
#include "dolfinx_impact/surface/nodal.h"
#include "dolfinx_impact/surface/normals.h"
#include "dolfinx_impact/surface/smooth.h"
#include "dolfinx_impact/surface/turned.h"

using namespace dolfinx_impact::surface;

namespace
{
FacetShape shape(const std::string& name)
{
  if (name == "interval")
    return FacetShape::interval;
  if (name == "triangle")
    return FacetShape::triangle;
  if (name == "quadrilateral")
    return FacetShape::quadrilateral;
  throw std::invalid_argument("a facet is an interval, a triangle or a quadrilateral, not " + name);
}
} // namespace

void dolfinx_impact::bindings::surface(nb::module_& m)
{
  nb::class_<FacetElement>(m, "FacetElement", "Lagrange element of degree 1 or 2 on a reference facet")
      .def(
          "__init__",
          [](FacetElement* self, const std::string& name, int degree)
          {
            if (degree != 1 && degree != 2)
              throw std::invalid_argument("facets have degree 1 or 2, not " + std::to_string(degree));
            new (self) FacetElement{shape(name), degree};
          },
          nb::arg("shape"), nb::arg("degree"))
      .def_prop_ro("num_nodes", &FacetElement::num_nodes)
      .def_prop_ro("degree", [](const FacetElement& e) { return e.degree; })
      .def_prop_ro("shape",
                   [](const FacetElement& e)
                   {
                     return e.shape == FacetShape::interval   ? "interval"
                            : e.shape == FacetShape::triangle ? "triangle"
                                                              : "quadrilateral";
                   })
      .def("node", &FacetElement::node, nb::arg("i"))
      .def(
          "tabulate",
          [](const FacetElement& e, double x, double y)
          {
            const double xi[2] = {x, y};
            const int n = e.num_nodes(), second = e.tdim() == 1 ? 1 : 3;
            std::vector<double> out((1 + e.tdim() + second) * n);
            e.values(xi, out.data());
            e.derivatives(xi, out.data() + n);
            e.second_derivatives(xi, out.data() + (1 + e.tdim()) * n);
            return take(std::move(out), {std::size_t(1 + e.tdim() + second), std::size_t(n)});
          },
          nb::arg("x"), nb::arg("y") = 0.0, "Rows: values, first and second derivatives (11, 22, 12)");
  nb::class_<Facets>(m, "Facets", "Facets of a surface in flat arrays; properties are copies")
      .def_prop_ro("size", &Facets::size)
      .def_prop_ro("gdim", [](const Facets& f) { return f.gdim; })
      .def_prop_ro("displacement", [](const Facets& f) { return f.displacement; })
      .def_prop_ro("geometry", [](const Facets& f) { return f.geometry; })
      .def_prop_ro(
          "nodes", [](const Facets& f) { return copy(f.nodes, {f.size(), std::size_t(f.displacement.num_nodes())}); },
          nb::rv_policy::move)
      .def_prop_ro(
          "X", [](const Facets& f)
          { return copy(f.X, {f.size(), std::size_t(f.geometry.num_nodes()), std::size_t(f.gdim)}); },
          nb::rv_policy::move)
      .def_prop_ro(
          "x", [](const Facets& f)
          { return copy(f.x, {f.size(), std::size_t(f.geometry.num_nodes()), std::size_t(f.gdim)}); },
          nb::rv_policy::move)
      .def_prop_ro(
          "orientation", [](const Facets& f) { return copy(f.orientation, {f.size()}); }, nb::rv_policy::move)
      .def_prop_ro(
          "id", [](const Facets& f) { return copy(f.id, {f.size()}); }, nb::rv_policy::move)
      .def(
          "move",
          [](Facets& f, Values u)
          {
            for (std::int32_t node : f.nodes)
              if (std::size_t(node + 1) * f.gdim > u.size())
                throw std::invalid_argument("the displacements are fewer than the surface's nodes");
            move(f, u.data());
          },
          nb::arg("u"), "Current positions from displacements, numbered as `nodes`")
      .def_prop_ro("smooth", [](const Facets& f) { return f.smooth; })
      .def(
          "move_and_turn",
          [](Facets& f, Values u)
          {
            for (std::int32_t node : f.nodes)
              if (std::size_t(node + 1) * f.gdim > u.size())
                throw std::invalid_argument("the displacements are fewer than the surface's nodes");
            move_and_turn(f, offset_components(f), u.data());
          },
          nb::arg("u"), "As `move`, where smooth facets turn by any angle")
      .def(
          "evaluate",
          [](const Facets& f, std::size_t facet, double x, double y)
          {
            if (facet >= f.size())
              throw std::out_of_range("no such facet");
            const double xi[2] = {x, y};
            const FacetPoint p = evaluate(f, facet, f.x_of(facet), xi);
            std::vector<double> out(p.x, p.x + 3);
            out.insert(out.end(), p.normal, p.normal + 3);
            out.push_back(p.jacobian);
            return take(std::move(out));
          },
          nb::arg("facet"), nb::arg("x"), nb::arg("y") = 0.0, "Position (3), normal (3) and Jacobian at a point");
  m.def(
      "make_surface",
      [](const FunctionSpace& V, Indices facets) { return make_surface(V, {facets.data(), facets.size()}); },
      nb::arg("V"), nb::arg("facets"), "This rank's facets of a surface; nodes number the blocks of V's dofmap");
  m.def(
      "make_smooth", [](const FunctionSpace& V, const Facets& facets, double crease, Values normals)
      { return make_smooth(V, facets, {crease, {normals.data(), normals.size()}}); }, nb::arg("V"), nb::arg("facets"),
      nb::arg("crease"), nb::arg("normals"),
      "Curved facets of degree 2 through the corners of facets of degree 1; normals at these corners, or none. "
      "Collective");
}
