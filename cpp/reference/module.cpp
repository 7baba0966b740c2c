// SPDX-License-Identifier: MIT
#include "bindings.h"
#include <cstdio>

namespace nb = nanobind;
using namespace impact_reference;

NB_MODULE(_reference, m)
{
  m.doc() = "Hand-written finite elements; use them through the package impact_reference.";

  nb::class_<Material>(
      m, "Material",
      "Isotropic solid: E [F/L^2], nu [1], density [M/L^3] (0 will do for statics), hypothesis '3d', 'plane_strain', "
      "'plane_stress' or 'axisymmetric' (x is the radius), law 'linear_elastic', 'st_venant_kirchhoff' or "
      "'neo_hookean'. ValueError for anything out of range or unknown.")
      .def(
          "__init__",
          [](Material* self, double E, double nu, double density, const std::string& hypothesis, const std::string& law)
          {
            const Material material{law, hypothesis, E, nu, density};
            check(material);
            new (self) Material(material);
          },
          nb::arg("E"), nb::arg("nu"), nb::arg("density") = 0.0, nb::arg("hypothesis") = "3d",
          nb::arg("law") = "linear_elastic")
      .def_ro("E", &Material::E, "Young's modulus [F/L^2]")
      .def_ro("nu", &Material::nu, "Poisson's ratio [1]")
      .def_ro("density", &Material::density, "[M/L^3]")
      .def_ro("hypothesis", &Material::hypothesis)
      .def_ro("law", &Material::law)
      .def_prop_ro(
          "lame", [](const Material& s) { return nb::make_tuple(lame(s)[0], lame(s)[1]); }, "(lambda, mu) [F/L^2]")
      .def_prop_ro("elasticity_matrix", &elasticity_matrix, nb::rv_policy::move,
                   "D of sigma = D eps, seed (3.19) [F/L^2]")
      .def("__repr__",
           [](const Material& s)
           {
             char numbers[160];
             std::snprintf(numbers, sizeof(numbers), "Material(E=%.16g, nu=%.16g, density=%.16g, ", s.E, s.nu,
                           s.density);
             return std::string(numbers) + "hypothesis='" + s.hypothesis + "', law='" + s.law + "')";
           });

  m.def("reference_nodes",
        [](const std::string& cell, int degree) { return reference_nodes(cell_type(cell), degree); });
  m.def("shape_functions",
        [](const std::string& cell, int degree, const Matrix& points)
        {
          const Shapes s = shape_functions(cell_type(cell), degree, points);
          return std::make_pair(s.N, s.dN);
        });
  m.def("quadrature",
        [](const std::string& cell, const std::string& rule)
        {
          const Rule r = quadrature(cell_type(cell), rule);
          return std::make_pair(r.points, r.weights);
        });
  m.def("default_rule",
        [](const std::string& name, const std::string& cell, int degree, int geometry_degree, bool axisymmetric)
        { return default_rule(purpose(name), cell_type(cell), degree, geometry_degree, axisymmetric); });
  m.def("facet_type", [](const std::string& cell) { return std::string(to_string(facet_type(cell_type(cell)))); });
  m.def("facets", [](const std::string& cell) { return facets(cell_type(cell)); });
  m.def("facet_nodes",
        [](const std::string& cell, int degree, int facet) { return facet_nodes(cell_type(cell), degree, facet); });
  m.def("find_facet",
        [](const std::string& cell, const std::vector<int>& nodes) { return find_facet(cell_type(cell), nodes); });
  m.def("lumping_scheme", [](const std::string& scheme, const std::string& cell, int degree, bool axisymmetric)
        { return lumping_scheme(scheme, cell_type(cell), degree, axisymmetric); });
  m.def("second_piola",
        [](const Material& material, const Matrix& F)
        {
          if (F.rows() != 3 or F.cols() != 3)
            throw std::invalid_argument("F must be a 3 x 3 matrix");
          const Stress s = material.law == "linear_elastic" ? small_strain(material, F) : second_piola(material, F);
          return nb::make_tuple(s.S, s.C, s.energy);
        });
  bind_elements(m);
  bind_model(m);
  bind_plasticity(m);
  bind_newmark(m);
  bind_rolling(m);
  bind_contact(m);
  bind_explicit(m);
}
