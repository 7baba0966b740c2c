// SPDX-License-Identifier: MIT
#pragma once

/// Linear tetrahedra of neo-Hookean material whose strains are averaged at the nodes, in two sweeps over the cells with
/// as little work as can be: forms/averaged_strain.py says what is computed, docs/averaged_pressure.md how.
namespace dolfinx_impact::kernels
{
/// Entries of a node in the array of its means: three rows of four. Row j has the derivatives of the displacement's
/// components by x_j; the last entry of the first row belongs to ln J, the others of the fourth column are padding.
constexpr int entries_of_means = 12;

/// Shear moduli of the nodes' and of the cells' part of the stress [F/L^2].
struct AveragedModuli
{
  double lambda = 0.0;   ///< Lame's first constant
  double nodes_mu = 0.0; ///< of mu (F_a - F_a^-T) with the nodes' means F_a
  double cells_mu = 0.0; ///< of mu (F - F^-T) in each cell
};

/// Batches of cells, and arrays over their nodes. Positions, displacements and forces have four entries for each node;
/// all arrays are aligned to 32 bytes.
struct AveragedCells
{
  unsigned long long num_batches = 0;
  int used = 0; ///< lanes of the last batch that count; others repeat a cell
  /// Four times the number of a node, its first entry in the arrays: that of node i of a lane of the first batch stands
  /// at [lanes * i + lane]; batches follow.
  const unsigned* entries = nullptr;
  const double* positions = nullptr;
  const double* displacement = nullptr;
  double* means = nullptr;  ///< entries_of_means for each node
  double* forces = nullptr; ///< are added to
};

/// The functions for one width of vectors; null where there are none.
struct AveragedNeoHookeanKernels
{
  /// Adds each cell's integrals of grad u N_a and ln J N_a to the means of its nodes.
  void (*add_means)(const AveragedCells& cells) = nullptr;
  /// Replaces these sums by a quarter of the nodes' stress: mu (F_a - F_a^-T), and of the pressure: lambda times the
  /// mean of ln J.
  /// @param inverse_volumes of each node [1/L^3]
  void (*set_stress)(unsigned long long num_nodes, const double* inverse_volumes, const AveragedModuli& moduli,
                     double* means) = nullptr;
  /// Adds the nodal forces of P = mu (F - F^-T) + p F^-T + S, with the cell's own F and the sums S and p over what its
  /// nodes have instead of means.
  void (*add_forces)(const AveragedCells& cells, const AveragedModuli& moduli) = nullptr;
};

/// @param[in] width cells at a time
AveragedNeoHookeanKernels averaged_neo_hookean(int width);
} // namespace dolfinx_impact::kernels
