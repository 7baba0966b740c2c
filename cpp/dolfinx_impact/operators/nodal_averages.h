// SPDX-License-Identifier: MIT
#pragma once
#include <dolfinx/fem/FunctionSpace.h>
#include <span>
#include <vector>

namespace dolfinx_impact::operators
{
/// Averages at the nodes of values at the quadrature points of cells: the mean of the points of the cells around a
/// node, weighted by volume and by the node's shape function. Collective.
/// @param[in] V Lagrange space of degree 1, with as many components as a value
/// @param[in] points of the rule in the reference cell, [point*tdim + direction] [1]
/// @param[in] weights of the rule [1]
/// @param[in] values on owned cells, [(cell*num_points + point)*num_components + component]
/// @return at owned nodes, [node*num_components + component]
/// @throws std::invalid_argument on all ranks if the sizes do not fit on one
std::vector<double> nodal_averages(const dolfinx::fem::FunctionSpace<double>& V, std::span<const double> points,
                                   std::span<const double> weights, std::span<const double> values);
} // namespace dolfinx_impact::operators
