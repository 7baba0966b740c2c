// SPDX-License-Identifier: MIT
#include "MovingBodies.h"
#include "bindings.h"
#include "contact_solve.h"

namespace nb = nanobind;

namespace impact_reference
{
void bind_newmark(nb::module_& m)
{
  using P = const Matrix&;
  using V = const Vector&;
  using Dofs = const std::vector<std::int64_t>&;

  m.def("inertia_matrix",
        [](const Model& model, P points, V weights, const std::string& lumping, const std::vector<bool>& redistributed)
        { return inertia_matrix(model, {points, weights}, lumping, redistributed); });
  nb::class_<MovingBodies>(m, "MovingBodies")
      .def(
          "__init__",
          [](MovingBodies* self, const Model& model, P points, V weights, const std::vector<PlasticBody*>& plastic,
             const Csr& mass, double alpha, double beta)
          {
            std::unique_ptr<BodyForces> internal;
            if (plastic.empty())
              internal = std::make_unique<ElasticForces>(model, Rule{points, weights});
            else
              internal = std::make_unique<PlasticForces>(*plastic[0], Rule{points, weights});
            new (self) MovingBodies(std::move(internal), mass, alpha, beta);
          },
          nb::keep_alive<1, 2>(), nb::keep_alive<1, 5>())
      .def("set_motion", [](MovingBodies& s, V start, V a_slope, V a_rest, V v_slope, V v_rest)
           { s.set_motion({start, a_slope, a_rest, v_slope, v_rest}); })
      .def("acceleration", &MovingBodies::acceleration)
      .def("velocity", &MovingBodies::velocity)
      .def("internal_force", &MovingBodies::internal_force)
      .def("inertia_force", &MovingBodies::inertia_force)
      .def("damping_force", &MovingBodies::damping_force)
      .def("solve_acceleration", [](const MovingBodies& s, V force, V a, const std::vector<bool>& unknown)
           { return solve_acceleration(s.mass(), force, a, unknown); })
      .def("step",
           [](const MovingBodies& s, const Model& model, V u, Dofs fixed, V values, V load, int iterations,
              double tolerance)
           {
             const FreeSolution r =
                 solve_free(model, s, u, {fixed, values, load, {}}, {1, iterations, tolerance, false, false, 2});
             return std::make_tuple(r.u, r.reactions, r.iterations, r.residual);
           });
}
} // namespace impact_reference
