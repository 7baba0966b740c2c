// SPDX-License-Identifier: MIT
#pragma once
#include "../kernels/Kernel.h"
#include <cstddef>
#include <cstdint>

/// Moves values between nodes (arrays as DOLFINx keeps them) and the lanes of a batch of cells.
namespace dolfinx_impact::operators
{
/// w[(node*bs + component)*lanes + lane] = u[stride*dofs[node*lanes + lane] + component]
typedef void (*gather_function)(const double* u, const std::int32_t* dofs, int num_nodes, double* w);

/// b[stride*dofs[node*lanes + lane] + component] += A[(node*bs + component)*lanes + lane] for lanes below `used`; A is
/// zero afterwards, as the kernel that adds to it next expects. Zeros that are written while values are added cost
/// less than a sweep of their own.
typedef void (*scatter_function)(double* A, const std::int32_t* dofs, int num_nodes, int used, double* b);

/// A kernel over whole batches of cells, which reads positions and one coefficient at the nodes that it adds to.
struct Sweep
{
  impact_tabulate tabulate = nullptr;
  std::size_t num_batches = 0;
  const std::int32_t* position_nodes = nullptr; ///< of the first batch
  int num_position_nodes = 0;
  std::size_t positions_per_batch = 0; ///< entries from one batch's position_nodes to the next one's
  const std::int32_t* nodes = nullptr; ///< of the first batch; all follow each other
  int num_nodes = 0;
  const double* constants = nullptr;
  const double* positions = nullptr; ///< four entries per node, aligned
  const double* values = nullptr;    ///< of the coefficient, with the stride of b
  double* b = nullptr;
  double* A = nullptr;   ///< element vector, zero before and after
  double* w[2] = {};     ///< coefficient of a batch, and of the next one
  double* x[2] = {};     ///< positions likewise
  double* all_w[2] = {}; ///< all coefficients likewise, for `load`
  /// Of kernels with internal variables, null for others: read those of a batch, ahead of the kernel as the nodes are,
  /// and store what the kernel has written of a batch beside the element vector.
  void (*load)(const void* owner, std::size_t batch, double* w) = nullptr;
  void (*store)(const void* owner, std::size_t batch, const double* A) = nullptr;
  const void* owner = nullptr; ///< of the internal variables
};
/// Gathers, tabulates and scatters batch by batch, in one function: calls cost as much as a node of a small cell.
typedef void (*sweep_function)(const Sweep&);

/// @param[in] lanes 1, 4 or 8
/// @param[in] bs components per node, 1 to 12
/// @param[in] stride entries per node in u: bs, or padded_stride(bs) (lanes.h) in an array that is aligned
/// @throws std::runtime_error for other numbers
gather_function gather(int lanes, int bs, int stride);

/// Arguments and errors as of `gather`; the stride is that of b.
scatter_function scatter(int lanes, int bs, int stride);

/// Null where there is none: those who ask gather, tabulate and scatter then by themselves.
sweep_function sweep(int lanes, int bs, int stride);
} // namespace dolfinx_impact::operators
