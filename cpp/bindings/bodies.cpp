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
  nb::class_<KernelForce>(m, "KernelForce", "An operator, and the constants of each of its integrals")
      .def(
          "__init__", [](KernelForce* self, std::shared_ptr<InternalForce> force, std::vector<Constants> constants)
          { new (self) KernelForce{std::move(force), std::move(constants)}; }, nb::arg("force"), nb::arg("constants"));
  nb::class_<AssembledBody, Body>(m, "AssembledBody", "Bodies that kernels, forms of DOLFINx, or both assemble")
      .def(
          "__init__",
          [](AssembledBody* self, Function u, Form residual, std::shared_ptr<KernelTangent> tangent,
             std::vector<KernelForce> forces, std::vector<KernelForce> loads, std::vector<Constants> tangent_constants,
             std::vector<Function> functions, BodyProperties properties)
          {
            new (self) AssembledBody(std::move(u), std::move(residual), std::move(tangent), properties,
                                     {.forces = std::move(forces),
                                      .loads = std::move(loads),
                                      .tangent_constants = std::move(tangent_constants),
                                      .functions = std::move(functions)});
          },
          nb::arg("u"), nb::arg("residual").none(), nb::arg("tangent"), nb::arg("forces"), nb::arg("loads"),
          nb::arg("tangent_constants"), nb::arg("functions"), nb::arg("properties"))
      .def("set_energies", &AssembledBody::set_energies, nb::arg("energies"), nb::arg("functions"),
           "What stores energy beside laws with internal variables: all energy is known then");
}
