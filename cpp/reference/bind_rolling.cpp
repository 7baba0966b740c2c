// SPDX-License-Identifier: MIT
#include "RollingBodies.h"
#include "bindings.h"
#include "contact_solve.h"

namespace nb = nanobind;

namespace impact_reference
{
void bind_rolling(nb::module_& m)
{
  using P = const Matrix&;
  using V = const Vector&;
  m.def("flow_matrices",
        [](const Model& model, P points, V weights, const std::vector<std::int64_t>& body,
           const std::vector<std::tuple<Vector, Vector, Vector>>& flows)
        {
          std::vector<BodyFlow> list;
          list.reserve(flows.size());
          for (const auto& [spin, centre, velocity] : flows)
            list.push_back({spin, centre, velocity});
          const FlowMatrices r = flow_matrices(model, {points, weights}, body, list);
          return std::make_tuple(r.gyroscopic, r.inertia, r.load);
        });
  nb::class_<RollingBodies>(m, "RollingBodies")
      .def(
          "__init__", [](RollingBodies* self, const Model& model, P points, V weights, const Csr& inertia)
          { new (self) RollingBodies(model, {points, weights}, inertia); }, nb::keep_alive<1, 2>())
      .def("solve",
           [](const RollingBodies& s, const Model& model, V u, const std::vector<std::int64_t>& fixed, V values, V load,
              int iterations, double tolerance)
           {
             const FreeSolution r =
                 solve_free(model, s, u, {fixed, values, load, {}}, {1, iterations, tolerance, false, false, 2});
             return std::make_tuple(r.u, r.reactions, r.iterations, r.residual);
           });
}
} // namespace impact_reference
