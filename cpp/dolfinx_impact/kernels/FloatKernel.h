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

  enum
  {
    IMPACT_FLOAT_VARIANTS = 4
  };

  typedef struct
  {
    const impact_kernel* kernel; ///< the same in double
    /// Take 4, 8, 16 cells where `kernel` takes 1, 4, 8; the last one 8, with vectors of half the size that such a
    /// processor has.
    impact_float_tabulate tabulate[IMPACT_FLOAT_VARIANTS];
    impact_float_sweep sweep[IMPACT_FLOAT_VARIANTS]; ///< likewise; null: none
  } impact_float_kernel;
}

namespace dolfinx_impact::kernels
{
/// Functions of a kernel in float for one number of cells at once.
struct FloatFunctions
{
  int lanes = 0; ///< cells at once
  impact_float_tabulate tabulate = nullptr;
  impact_float_sweep sweep = nullptr; ///< null: none
};

/// The kernel in float of a kernel that was compiled with the package; null if there is none.
const impact_float_kernel* find_float(const impact_kernel& kernel);
/// The functions to take on this machine. Processors that compute vectors of 512 bits in two halves are not faster with
/// them, and with more cells at once wait longer for their nodes: they take vectors of 256 bits. That is measured once
/// for each kernel in a process, unless IMPACT_SIMD_WIDTH is given: then the widest are taken.
/// @param[in] width cells that the kernel in double takes: 1, 4 or 8
FloatFunctions float_functions(const impact_float_kernel& kernel, int width);
} // namespace dolfinx_impact::kernels
