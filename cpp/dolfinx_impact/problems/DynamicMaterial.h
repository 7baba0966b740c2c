// SPDX-License-Identifier: MIT
#pragma once
#include "../kernels/KernelTable.h"
#include "KernelBody.h"
#include <dolfinx/mesh/MeshTags.h>
#include <optional>
#include <string>
#include <vector>

namespace dolfinx_impact::problems
{
/// A material of bodies in motion, with internal variables or without.
struct DynamicMaterial
{
  /// Kernels NAME.force and NAME.tangent; damping has NAME.damping, bulk viscosity NAME.viscosity. Of a law with
  /// internal variables, "j2.small.linear", damping, viscosity and frequencies are those of its elastic part.
  KernelMaterial law;
  double density = 0.0;                  ///< of the undeformed body [M/L^3]
  std::optional<int> tag = std::nullopt; ///< of its cells; nothing: all
};

enum class Lumping
{
  automatic, ///< row sums at degree 1; else HRZ on simplices and axisymmetric bodies, nodal on other cells
  row_sum,
  hrz,  ///< Hinton, Rock and Zienkiewicz (1976)
  nodal ///< Gauss-Lobatto-Legendre rule at the nodes
};

/// Finds kernels of the table for the cells and the degree of a space.
class KernelFinder
{
public:
  explicit KernelFinder(const dolfinx::fem::FunctionSpace<double>& V);

  /// @throws std::runtime_error if there are none
  std::vector<const impact_kernel*> find(const std::string& name, const std::string& hypothesis) const;
  /// @throws std::runtime_error unless there is one
  const impact_kernel& one(const std::string& name, const std::string& hypothesis) const;
  int degree() const { return _key.degree; }
  bool simplices() const { return _key.cell == "triangle" || _key.cell == "tetrahedron"; }

private:
  kernels::Key _key;
};

/// Has the law internal variables?
bool is_plastic(const KernelMaterial& law);

/// The elastic law that bounds frequencies and damps.
std::string elastic_name(const KernelMaterial& law);

/// Modulus of uniaxial strain at rest, lambda + 2 mu, of sheets E/(1 - nu^2); nothing for laws of a user's own, whose
/// constants have no meaning here [F/L^2].
std::optional<double> uniaxial_modulus(const KernelMaterial& law);

/// Owned cells of each material.
/// @throws std::invalid_argument if a cell has no material, or two; a density is not positive; or tags are missing
std::vector<std::vector<std::int32_t>> cells_of(const std::vector<DynamicMaterial>& materials,
                                                const dolfinx::mesh::Topology& topology,
                                                const dolfinx::mesh::MeshTags<std::int32_t>* tags);

/// Lumped masses of a material's cells by local degree of freedom, [k*n + i] in the order of the cells [M].
std::vector<double> lumped_masses(const KernelFinder& kernels, const dolfinx::fem::FunctionSpace<double>& V,
                                  const DynamicMaterial& material, const std::vector<std::int32_t>& cells,
                                  Lumping lumping);
} // namespace dolfinx_impact::problems
