// SPDX-License-Identifier: MIT
#pragma once
#include <cstddef>
#include <cstdint>

namespace dolfinx_impact::hand_written
{
/// Cells in batches that are as wide as a vector. The file takes no templates of the standard library: it is compiled
/// for processors that the machine may not be, and the linker would be free to use those copies everywhere.
struct CellBatches
{
  const std::int32_t* nodes = nullptr; ///< of batch b, node i, lane l: nodes[(b*num_nodes + i)*width + l]
  std::size_t num_batches = 0;
};

/// Lame's constants [F/L^2].
struct Elasticity
{
  double mu = 0.0, lambda = 0.0;
};

/// Nodal arrays have four entries per node, the fourth is padding; they are aligned to 32 bytes.
struct NodalArrays
{
  const double* x = nullptr;            ///< positions before deformation [L]
  double* u = nullptr;                  ///< displacements [L]
  double* v = nullptr;                  ///< velocities half a step before [L/T]
  double* r = nullptr;                  ///< internal forces; zero between steps [F]
  const double* inverse_mass = nullptr; ///< one entry per node [1/M]
};

/// Adds the internal forces of all cells to r.
using add_forces_function = void (*)(const CellBatches&, const Elasticity&, const NodalArrays&);
/// Makes a step of the central difference method for `num_nodes` nodes, and sets r to zero.
using update_function = void (*)(std::size_t num_nodes, double step, const NodalArrays&);

/// What the loops are for: nodes and points of a cell.
struct CellKind
{
  int num_nodes = 0;
  bool one_point = false; ///< and hourglass control, docs/one_point.md: of hexahedra
};

/// The functions for cells with 8 nodes (hexahedra), 4 and 10 (tetrahedra).
struct CellLoop
{
  add_forces_function add_forces = nullptr;
  update_function update = nullptr;
};
CellLoop loop4(const CellKind& kind); ///< AVX2: four cells at a time
CellLoop loop8(const CellKind& kind); ///< AVX-512: eight cells at a time
} // namespace dolfinx_impact::hand_written
