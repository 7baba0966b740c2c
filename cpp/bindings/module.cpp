// SPDX-License-Identifier: MIT
#include "module.h"
#include <dolfinx/mesh/Mesh.h>

namespace nb = nanobind;

NB_MODULE(_cpp, m)
{
  m.doc() = "C++ side of dolfinx_impact";
  // nanobind shares classes between modules only when both were built with the same internals. A mismatch would show up
  // much later, as "incompatible function arguments" that print a C++ name.
  nb::module_::import_("dolfinx.cpp");
  if (!nb::type<dolfinx::mesh::Mesh<double>>().is_valid())
    throw nb::import_error(
        "dolfinx_impact was built with nanobind " IMPACT_NANOBIND_VERSION
        ", whose types the installed DOLFINx does not share. Build it again against the nanobind that "
        "DOLFINx was built with: pip install --no-build-isolation --force-reinstall .");
  nb::module_ state = m.def_submodule("state", "State as named arrays");
  dolfinx_impact::bindings::state(state);
  nb::module_ files = m.def_submodule("files", "Files of states that runs go on from");
  dolfinx_impact::bindings::files(files);
  nb::module_ kernels = m.def_submodule("kernels", "Kernels generated from UFL forms");
  dolfinx_impact::bindings::kernels(kernels);
  nb::module_ operators = m.def_submodule("operators", "Kernels applied over the cells of a mesh");
  dolfinx_impact::bindings::operators(operators);
  nb::module_ surface = m.def_submodule("surface", "Facets of surfaces, their shape functions and normals");
  dolfinx_impact::bindings::surface(surface);
  nb::module_ gap = m.def_submodule("gap", "Gaps between slave and master, and their integrals");
  dolfinx_impact::bindings::mortar(gap);
  dolfinx_impact::bindings::gap(gap);
  nb::module_ search = m.def_submodule("search", "Which facets can meet, and closest points");
  dolfinx_impact::bindings::search(search);
  nb::module_ enforcement = m.def_submodule("enforcement", "What contacts of all kinds have");
  dolfinx_impact::bindings::enforcement(enforcement);
  dolfinx_impact::bindings::interface_law(enforcement);
  nb::module_ penalty = m.def_submodule("penalty", "Gaps turned into forces at the slave's quadrature points");
  dolfinx_impact::bindings::penalty(penalty);
  nb::module_ multipliers = m.def_submodule("multipliers", "Mortar integrals, active set and condensation");
  dolfinx_impact::bindings::multipliers(multipliers);
  dolfinx_impact::bindings::mortar_geometry(multipliers);
  nb::module_ solve = m.def_submodule("solve", "Newton's method, linear systems and their solvers");
  dolfinx_impact::bindings::solve(solve);
  dolfinx_impact::bindings::mortar_contact(multipliers);
  dolfinx_impact::bindings::tie(multipliers);
  nb::module_ integrators = m.def_submodule("integrators", "Time stepping");
  dolfinx_impact::bindings::integrators(integrators);
  dolfinx_impact::bindings::newmark(integrators);
  nb::module_ nodal = m.def_submodule("nodal", "Contact of nodes in explicit dynamics");
  dolfinx_impact::bindings::nodal(nodal);
  dolfinx_impact::bindings::explicit_tie(nodal);
  nb::module_ rolling = m.def_submodule("rolling", "Steady rolling in the ALE frame");
  dolfinx_impact::bindings::rolling(rolling);
  nb::module_ problems = m.def_submodule("problems", "Problems composed of bodies, supports, loads and contacts");
  dolfinx_impact::bindings::amplitudes(problems);
  dolfinx_impact::bindings::bodies(problems);
  dolfinx_impact::bindings::problems(problems);
  dolfinx_impact::bindings::static_problem(problems);
  dolfinx_impact::bindings::implicit_problem(problems);
  dolfinx_impact::bindings::rolling_problem(problems);
  nb::module_ bench = m.def_submodule("bench", "Measurements of this machine and baselines");
  dolfinx_impact::bindings::bench(bench);
}
