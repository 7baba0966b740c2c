// SPDX-License-Identifier: MIT
#pragma once
#include "Kernel.h"

/// Kernels that compute element forces in single precision, with twice the lanes of double precision.
extern "C"
{
  /// Element vector of `lanes` cells at once, laid out as impact_tabulate says. What depends on constants alone is
  /// computed in double.
  /// @param A element vector, added to
  /// @param w coefficient less its value at the first node
  /// @param c constants, the same for all lanes
  /// @param x node coordinates less those of the first node, 3 per node
  typedef void (*impact_float_tabulate)(float* A, const float* w, const double* c, const float* x);

  /// Whole batches of cells, and arrays over their nodes: four entries per node, aligned to 32 bytes.
  typedef struct
  {
    unsigned long long num_batches;
    const int* nodes; ///< node i of a lane of the first batch stands at [lanes * i + lane]; batches follow each other
    const double* constants;
    const float* places;  ///< x of tabulate without the first node's entries, which are zero, batch by batch, aligned
    const double* values; ///< of the coefficient
    double* result;       ///< element vectors are added to it
    double scale;         ///< of what is gathered, a power of two
    double force_scale;   ///< of what is added, a power of two
  } impact_float_cells;

  /// Gathers, computes and scatters batch by batch: what tabulate gives between gather_differences and
  /// scatter_balanced (operators/gather_float.h), in less time.
  typedef void (*impact_float_sweep)(const impact_float_cells* cells);

  typedef struct
  {
    const impact_kernel* kernel;                          ///< the same in double
    impact_float_tabulate tabulate[IMPACT_KERNEL_WIDTHS]; ///< takes 4, 8, 16 cells where `kernel` takes 1, 4, 8
    impact_float_sweep sweep[IMPACT_KERNEL_WIDTHS];       ///< likewise; null: none
  } impact_float_kernel;
}

namespace dolfinx_impact::kernels
{
/// Cells that a kernel in float takes at once.
/// @param[in] width cells that the kernel in double takes: 1, 4 or 8
inline constexpr int float_lanes(int width)
{
  return width == 8 ? 16 : width == 4 ? 8 : 4;
}

/// The kernel in float of a kernel that was compiled with the package; null if there is none.
const impact_float_kernel* find_float(const impact_kernel& kernel);
/// For a width of the kernel in double, 1, 4 or 8.
impact_float_tabulate tabulate(const impact_float_kernel& kernel, int width);
/// Null where the kernel has none.
impact_float_sweep sweep(const impact_float_kernel& kernel, int width);
} // namespace dolfinx_impact::kernels
