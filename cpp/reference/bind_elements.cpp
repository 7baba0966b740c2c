// SPDX-License-Identifier: MIT
#include "bindings.h"

namespace nb = nanobind;

namespace impact_reference
{
namespace
{
// Every element function begins with the same arguments.
struct Cell
{
  std::string cell;
  int degree, geometry_degree;
  bool axisymmetric;
  Rule rule;
  Sampler sampler() const { return {cell_type(cell), degree, geometry_degree, rule, axisymmetric}; }
  FacetSampler facet_sampler() const { return {cell_type(cell), degree, geometry_degree, rule, axisymmetric}; }
};

bool is_axisymmetric(const Material& material)
{
  return hypothesis(material.hypothesis) == Hypothesis::axisymmetric;
}

void need(const Vector& load, const Cell& c)
{
  if (load.size() != tdim(cell_type(c.cell)))
    throw std::invalid_argument("on a " + c.cell + " the load needs " + std::to_string(tdim(cell_type(c.cell))) +
                                " components, but " + std::to_string(load.size()) + " were given");
}
} // namespace

void bind_elements(nb::module_& m)
{
  nb::class_<Cell>(m, "Cell", "Cell type, degrees and integration rule of an element function.")
      .def("__init__", [](Cell* self, const std::string& cell, int degree, int geometry_degree, bool axisymmetric,
                          const Matrix& points, const Vector& weights)
           { new (self) Cell{cell, degree, geometry_degree, axisymmetric, Rule{points, weights}}; });

  m.def("element_stiffness",
        [](const Cell& c, const Matrix& X, const Material& a) { return stiffness(c.sampler(), X, a); });
  m.def("element_b_matrix", [](const Cell& c, const Matrix& X, const std::string& h)
        { return strain_matrix(hypothesis(h), c.sampler().at(X, 0)); });
  m.def("element_internal",
        [](const Cell& c, const Matrix& X, const Material& a, const Vector& u, bool with_tangent)
        {
          const Internal result = internal(c.sampler(), X, a, u, with_tangent);
          return std::make_tuple(result.energy, result.force, result.tangent);
        });
  m.def("element_stress", [](const Cell& c, const Matrix& X, const Material& a, const Vector& u)
        { return stress(c.sampler(), X, a, u); });
  m.def("element_mass", [](const Cell& c, const Matrix& X, const Material& a) { return mass(c.sampler(), X, a); });
  m.def(
      "element_lumped_mass", [](const Cell& c, const Matrix& X, const Material& a, const std::string& scheme)
      { return LumpedMass(cell_type(c.cell), c.degree, c.geometry_degree, c.rule, is_axisymmetric(a), scheme)(X, a); });
  m.def("element_body_force",
        [](const Cell& c, const Matrix& X, const Vector& f)
        {
          need(f, c);
          return body_force(c.sampler(), X, f);
        });
  m.def("element_traction",
        [](const Cell& c, const Matrix& X, int facet, const Vector& t)
        {
          need(t, c);
          return traction(c.facet_sampler(), X, facet, t);
        });
  m.def("element_foundation", [](const Cell& c, const Matrix& X, int facet, const Vector& k)
        { return foundation(c.facet_sampler(), X, facet, k); });
  m.def("element_follower_pressure",
        [](const Cell& c, const Matrix& X, const Vector& u, int facet, double p)
        {
          const Follower result = follower_pressure(c.facet_sampler(), X, u, facet, p);
          return std::make_tuple(result.force, result.tangent);
        });
  m.def("element_ale",
        [](const Cell& c, const Matrix& X, const Material& a, const Vector& spin, const Vector& centre)
        {
          const Ale result = ale(c.sampler(), X, a, spin, centre);
          return std::make_tuple(result.gyroscopic, result.inertia, result.load);
        });
  m.def("element_poisson", [](const Cell& c, const Matrix& X, double k) { return poisson(c.sampler(), X, k); });
  m.def("element_scalar_load",
        [](const Cell& c, const Matrix& X, double f) { return body_force(c.sampler(), X, Vector::Constant(1, f)); });
  m.def("element_flux_load", [](const Cell& c, const Matrix& X, int facet, double q)
        { return traction(c.facet_sampler(), X, facet, Vector::Constant(1, q)); });
}
} // namespace impact_reference
