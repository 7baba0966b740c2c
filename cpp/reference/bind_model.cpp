// SPDX-License-Identifier: MIT
#include "bindings.h"

namespace nb = nanobind;

namespace impact_reference
{
void bind_model(nb::module_& m)
{
  m.def("csr_dot", [](const Integers& indptr, const Integers& indices, const Vector& data, const Vector& x)
        { return csr(indptr, indices, data).dot(x); });
  nb::class_<Csr>(m, "Csr").def_prop_ro("arrays", &arrays, nb::rv_policy::move);

  using P = const Matrix&;
  using W = const Vector&;
  using V = const Vector&;
  nb::class_<Model>(m, "Model")
      .def("__init__",
           [](Model* self, P points, const Cells& cells, const std::string& cell,
              const std::map<int, Material>& materials, const std::vector<std::int32_t>& tags, int degree,
              int geometry_degree)
           {
             const auto nodes = std::int64_t(node_vertices(cell_type(cell), geometry_degree).size());
             if (cells.cols() != nodes)
               throw std::invalid_argument("a " + cell + " of geometry degree " + std::to_string(geometry_degree) +
                                           " has " + std::to_string(nodes) + " nodes, but cells has " +
                                           std::to_string(cells.cols()) + " columns");
             const impact_plain::Mesh mesh{cell,
                                           geometry_degree,
                                           int(points.cols()),
                                           {points.data(), points.data() + points.size()},
                                           {cells.data(), cells.data() + cells.size()},
                                           tags};
             new (self) Model(mesh, materials, degree);
           })
      .def_prop_ro(
          "field_points", [](const Model& s) { return s.field().points; }, nb::rv_policy::move)
      .def_prop_ro(
          "field_cells", [](const Model& s) { return s.field().cells; }, nb::rv_policy::move)
      .def("stiffness", [](const Model& s, P p, W w) { return s.stiffness({p, w}); })
      .def("mass", [](const Model& s, P p, W w) { return s.mass({p, w}); })
      .def("lumped_mass",
           [](const Model& s, P p, W w, const std::string& scheme) { return s.lumped_mass({p, w}, scheme); })
      .def("damping", [](const Model& s, P p, W w, P mp, W mw, double alpha, double beta)
           { return s.damping({p, w}, {mp, mw}, alpha, beta); })
      .def("energy", [](const Model& s, P p, W w, V u) { return s.energy({p, w}, u); })
      .def("internal_force", [](const Model& s, P p, W w, V u) { return s.internal_force({p, w}, u); })
      .def("tangent", [](const Model& s, P p, W w, V u) { return s.tangent({p, w}, u); })
      .def("stress", [](const Model& s, P p, W w, V u) { return s.stress({p, w}, u); })
      .def("body_force", [](const Model& s, P p, W w, V f) { return s.body_force({p, w}, f); })
      .def("traction", [](const Model& s, P p, W w, const Cells& facets, V t) { return s.traction({p, w}, facets, t); })
      .def("follower_pressure", [](const Model& s, P p, W w, const Cells& facets, V u, double pressure)
           { return s.follower_pressure({p, w}, facets, u, pressure); })
      .def("foundation",
           [](const Model& s, P p, W w, const Cells& facets, V k) { return s.foundation({p, w}, facets, k); })
      .def("average_pressure", &Model::average_pressure)
      .def("average_strain", &Model::average_strain)
      .def("add_mass", &Model::add_mass)
      .def("add_foundation", &Model::add_foundation)
      .def_prop_ro(
          "springs", [](const Model& s) { return s.springs(); }, nb::rv_policy::move)
      .def("springs_energy", [](const Model& s, V u) { return s.springs().dot(u).dot(u) / 2; })
      .def("gyroscopic", [](const Model& s, P p, W w, V spin, V centre) { return s.gyroscopic({p, w}, spin, centre); })
      .def("ale_inertia",
           [](const Model& s, P p, W w, V spin, V centre) { return s.ale_inertia({p, w}, spin, centre); })
      .def("ale_load", [](const Model& s, P p, W w, V spin, V centre) { return s.ale_load({p, w}, spin, centre); })
      .def("poisson", [](const Model& s, P p, W w, double k) { return s.poisson({p, w}, k); })
      .def(
          "frequencies",
          [](const Model& s, const std::vector<Csr*>& matrices, V lumped, int n, const std::vector<std::int64_t>& fixed)
          {
            const Csr* mass = matrices.size() > 1 ? matrices[1] : nullptr;
            const Frequencies result = frequencies(s, *matrices.at(0), mass, lumped, n, fixed);
            return std::make_pair(result.omega, result.modes);
          })
      .def("scalar_load", [](const Model& s, P p, W w, double f) { return s.scalar_load({p, w}, f); })
      .def("flux_load",
           [](const Model& s, P p, W w, const Cells& facets, double q) { return s.flux_load({p, w}, facets, q); })
      .def("rigid_modes", &Model::rigid_modes)
      .def("solve_static",
           [](const Model& s, P p, W w, const std::vector<std::int64_t>& fixed, V values, V load, int steps,
              double tolerance, int max_iterations)
           {
             const StaticSolution r = solve_static(s, {p, w}, fixed, values, load, {steps, tolerance, max_iterations});
             return std::make_tuple(r.u, r.reactions, r.iterations, r.residuals);
           });
}
} // namespace impact_reference
