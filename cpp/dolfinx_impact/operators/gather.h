// SPDX-License-Identifier: MIT
#pragma once
#include <cstddef>
#include <cstdint>

/// Moves values between nodes (arrays as DOLFINx keeps them) and the lanes of a batch of cells.
namespace dolfinx_impact::operators
{
/// w[(node*bs + component)*lanes + lane] = u[stride*dofs[node*lanes + lane] + component]
typedef void (*gather_function)(const double* u, const std::int32_t* dofs, int num_nodes, double* w);

/// b[bs*dofs[node*lanes + lane] + component] += A[(node*bs + component)*lanes + lane] for lanes below `used`
typedef void (*scatter_function)(const double* A, const std::int32_t* dofs, int num_nodes, int used, double* b);

/// A[k] = 0 for a batch; the size is a multiple of the lanes, A aligned to them. The registers are as wide as the
/// kernel's, which adds to it at once.
typedef void (*clear_function)(double* A, std::size_t size);

/// @param[in] lanes 1, 4 or 8
/// @param[in] bs components per node, 1 to 12
/// @param[in] stride entries per node in u: bs
/// @throws std::runtime_error for other numbers of components
gather_function gather(int lanes, int bs, int stride);

scatter_function scatter(int lanes, int bs);

clear_function clear(int lanes);
} // namespace dolfinx_impact::operators
