// SPDX-License-Identifier: MIT
#pragma once
// The one header for nanobind and DOLFINx's casters (their names changed after 0.9).
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

namespace dolfinx_impact::bindings
{
void state(nanobind::module_& m);
void files(nanobind::module_& m);
void kernels(nanobind::module_& m);
void operators(nanobind::module_& m);
void surface(nanobind::module_& m);
void nodal(nanobind::module_& m);
void mortar(nanobind::module_& m);
void gap(nanobind::module_& m);
void enforcement(nanobind::module_& m);
void interface_law(nanobind::module_& m);
void mortar_contact(nanobind::module_& m);
void tie(nanobind::module_& m);
void explicit_tie(nanobind::module_& m);
void mortar_geometry(nanobind::module_& m);
void multipliers(nanobind::module_& m);
void solve(nanobind::module_& m);
void amplitudes(nanobind::module_& m);
void bodies(nanobind::module_& m);
void search(nanobind::module_& m);
void penalty(nanobind::module_& m);
void integrators(nanobind::module_& m);
void newmark(nanobind::module_& m);
void rolling(nanobind::module_& m);
void rolling_problem(nanobind::module_& m);
void problems(nanobind::module_& m);
void static_problem(nanobind::module_& m);
void implicit_problem(nanobind::module_& m);
void bench(nanobind::module_& m);
} // namespace dolfinx_impact::bindings
