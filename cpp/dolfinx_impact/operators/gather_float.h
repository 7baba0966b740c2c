// SPDX-License-Identifier: MIT
#pragma once
#include "../kernels/FloatKernel.h"
#include <cstddef>
#include <cstdint>

/// Moves values between nodes in double and the lanes of cells in float, for vectors of three components.
namespace dolfinx_impact::operators
{
/// A kernel in float over whole batches of cells. Positions and values have four entries per node, aligned.
struct FloatSweep
{
  impact_float_tabulate tabulate = nullptr;
  std::size_t num_batches = 0;
  const std::int32_t* position_nodes = nullptr; ///< of the first batch; node i of a lane stands at [lanes * i + lane]
  int num_position_nodes = 0;
  std::size_t positions_per_batch = 0; ///< entries from one batch's position_nodes to the next one's
  const std::int32_t* nodes = nullptr; ///< of the first batch; all follow each other
  int num_nodes = 0;
  const double* constants = nullptr;
  const double* positions = nullptr;
  const double* values = nullptr;
  double* b = nullptr;
  double scale = 1.0;       ///< of what is gathered, a power of two
  double force_scale = 1.0; ///< of what is added to b, a power of two
  float* A = nullptr;       ///< element vector, zero before and after
  float* w[2] = {};         ///< coefficient of a batch, and of the next one
  float* x[2] = {};         ///< positions likewise
};

/// Gathers, tabulates and scatters batch by batch.
typedef void (*float_sweep_function)(const FloatSweep&);
/// For 8 or 16 lanes; null where the processor has none.
float_sweep_function float_sweep(int lanes);

/// w[(3*node + component)*lanes + lane] = scale (u[stride*dofs[node*lanes + lane] + component] - the same of node 0):
/// the difference is taken in double and then rounded, so that round-off is relative to what a cell deforms, wherever
/// it is.
/// @param[in] scale power of two: it changes no digit, and keeps products of lengths within the range of float
void gather_differences(int lanes, const double* u, int stride, const std::int32_t* dofs, int num_nodes, double scale,
                        float* w);

/// Adds scale A to b for lanes below `used`, in double; A is zero afterwards. The first node takes what is opposite to
/// the sum of the others: forces of a cell are in equilibrium to the round-off of double, and so the momentum is kept.
void scatter_balanced(int lanes, float* A, const std::int32_t* dofs, int num_nodes, int used, double scale, double* b,
                      int stride);
} // namespace dolfinx_impact::operators
