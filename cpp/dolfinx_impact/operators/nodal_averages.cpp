// SPDX-License-Identifier: MIT
#include "nodal_averages.h"
#include "../common/agree.h"
#include "../common/dolfinx_api.h"
#include <array>
#include <basix/finite-element.h>
#include <cmath>
#include <dolfinx/fem/CoordinateElement.h>
#include <dolfinx/fem/DofMap.h>
#include <dolfinx/fem/FiniteElement.h>
#include <dolfinx/la/Vector.h>
#include <functional>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::operators
{
namespace
{
/// Values and derivatives of a scalar element at the points of a rule.
struct Table
{
  Table(const basix::FiniteElement<double>& element, std::span<const double> points, std::size_t num_points)
      : values(element.tabulate(1, points, {num_points, points.size() / num_points}).first), num_points(num_points),
        num_nodes(std::size_t(element.dim()))
  {
  }
  /// @param[in] derivative 0: the value; 1 + d: its derivative in direction d
  double operator()(std::size_t derivative, std::size_t point, std::size_t node) const
  {
    return values[(derivative * num_points + point) * num_nodes + node];
  }
  std::vector<double> values;
  std::size_t num_points, num_nodes;
};

/// Size of the map's derivative J, (3, tdim) column by column: length, area or volume of the image of a unit cell.
double measure(const std::array<std::array<double, 3>, 3>& J, std::size_t tdim)
{
  const auto dot = [](const std::array<double, 3>& a, const std::array<double, 3>& b)
  { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  const auto cross = [](const std::array<double, 3>& a, const std::array<double, 3>& b)
  { return std::array<double, 3>{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}; };
  if (tdim == 1)
    return std::sqrt(dot(J[0], J[0]));
  const std::array<double, 3> normal = cross(J[0], J[1]);
  return tdim == 2 ? std::sqrt(dot(normal, normal)) : std::abs(dot(normal, J[2]));
}
} // namespace

std::vector<double> nodal_averages(const dolfinx::fem::FunctionSpace<double>& V, std::span<const double> points,
                                   std::span<const double> weights, std::span<const double> values)
{
  const auto& mesh = *V.mesh();
  const auto& dofmap = *V.dofmap();
  const std::size_t tdim = mesh.topology()->dim(), n = weights.size(), bs = dofmap.bs();
  const std::size_t num_cells = mesh.topology()->index_map(int(tdim))->size_local();
  common::agree(mesh.comm(),
                [&]
                {
                  if (n == 0 || points.size() != n * tdim || values.size() != num_cells * n * bs)
                    throw std::invalid_argument("averages at nodes: " + std::to_string(values.size()) + " values of " +
                                                std::to_string(num_cells) + " cells with " + std::to_string(n) +
                                                " points and " + std::to_string(bs) + " components");
                });
  const Table shape(V.element()->basix_element(), points, n);
  const auto& cmap = common::coordinate_element(mesh);
  const Table geometry(basix::create_element<double>(
                           basix::element::family::P, dolfinx::mesh::cell_type_to_basix_type(cmap.cell_shape()),
                           cmap.degree(), cmap.variant(), basix::element::dpc_variant::unset, false),
                       points, n);
  const auto nodes = common::geometry_dofmap(mesh);
  const auto x = mesh.geometry().x();
  dolfinx::la::Vector<double> sums(dofmap.index_map, int(bs)), volumes(dofmap.index_map, 1);
  common::fill(sums, 0.0);
  common::fill(volumes, 0.0);
  const std::span<double> sum = common::array(sums), volume = common::array(volumes);
  for (std::size_t c = 0; c < num_cells; ++c)
  {
    const auto dofs = dofmap.cell_dofs(std::int32_t(c));
    for (std::size_t p = 0; p < n; ++p)
    {
      std::array<std::array<double, 3>, 3> J{};
      for (std::size_t k = 0; k < geometry.num_nodes; ++k)
        for (std::size_t d = 0; d < tdim; ++d)
          for (std::size_t i = 0; i < 3; ++i)
            J[d][i] += geometry(1 + d, p, k) * x[3 * std::size_t(nodes(c, k)) + i];
      const double dx = weights[p] * measure(J, tdim);
      for (std::size_t k = 0; k < shape.num_nodes; ++k)
      {
        const double share = dx * shape(0, p, k);
        volume[dofs[k]] += share;
        for (std::size_t i = 0; i < bs; ++i)
          sum[bs * dofs[k] + i] += share * values[(c * n + p) * bs + i];
      }
    }
  }
  sums.scatter_rev(std::plus<double>());
  volumes.scatter_rev(std::plus<double>());
  const std::size_t num_owned = dofmap.index_map->size_local();
  std::vector<double> out(sum.begin(), sum.begin() + std::ptrdiff_t(bs * num_owned));
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] /= volume[k / bs];
  return out;
}
} // namespace dolfinx_impact::operators
