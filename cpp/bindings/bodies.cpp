// SPDX-License-Identifier: MIT
#include "dolfinx_impact/problems/AssembledBody.h"
#include "dolfinx_impact/problems/FormBody.h"
#include "petsc_objects.h"

namespace nb = nanobind;
using namespace dolfinx_impact::problems;
using dolfinx_impact::operators::InternalForce;
using dolfinx_impact::operators::KernelTangent;
using dolfinx_impact::solve::Body;
using dolfinx_impact::solve::BodyProperties;

void dolfinx_impact::bindings::bodies(nb::module_& m)
{
  typedef std::shared_ptr<dolfinx::fem::Function<double>> Function;
  nb::class_<AssembledBody, Body>(m, "AssembledBody", "Bodies that kernels, forms of DOLFINx, or both assemble")
      .def(
          "__init__",
          [](AssembledBody* self, Function u, Form residual, std::shared_ptr<KernelTangent> tangent,
             const BodyProperties& properties, std::shared_ptr<InternalForce> force,
             std::vector<Constants> force_constants, std::vector<Constants> tangent_constants,
             std::vector<Function> functions)
          {
            new (self) AssembledBody(std::move(u), std::move(residual), std::move(tangent), properties,
                                     {std::move(force), nullptr, false, std::move(force_constants),
                                      std::move(tangent_constants), std::move(functions)});
          },
          nb::arg("u"), nb::arg("residual").none(), nb::arg("tangent"), nb::arg("properties"), nb::arg("force").none(),
          nb::arg("force_constants"), nb::arg("tangent_constants"), nb::arg("functions"));
}
