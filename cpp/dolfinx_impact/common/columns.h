// SPDX-License-Identifier: MIT
#pragma once
#include "clones.h"
#include <cmath>

/// Rows of four numbers in memory, as columns of four lanes, and back: in registers, where compilers would put a column
/// together number by number. Inlined, so that a function with IMPACT_CLONES has them for its instruction set.
namespace dolfinx_impact::common
{
/// A number in each of four lanes, or the four numbers of a row. The compiler's own vectors (GCC, Clang).
typedef double Column __attribute__((vector_size(32)));
/// The same anywhere in memory.
typedef double LooseColumn __attribute__((vector_size(32), aligned(8)));

IMPACT_INLINED const LooseColumn& column(const double* values)
{
  return *reinterpret_cast<const LooseColumn*>(values);
}
IMPACT_INLINED LooseColumn& column(double* values)
{
  return *reinterpret_cast<LooseColumn*>(values);
}

/// A number, or the numbers of a column, become their square roots.
IMPACT_INLINED void take_root(double& x)
{
  x = std::sqrt(x);
}
IMPACT_INLINED void take_root(Column& x)
{
#pragma GCC unroll 4
  for (int k = 0; k < 4; ++k)
    x[k] = std::sqrt(x[k]);
}

/// Rows become columns, or columns rows.
IMPACT_INLINED void transpose(Column (&r)[4])
{
  const Column a = __builtin_shufflevector(r[0], r[1], 0, 4, 2, 6), b = __builtin_shufflevector(r[0], r[1], 1, 5, 3, 7);
  const Column c = __builtin_shufflevector(r[2], r[3], 0, 4, 2, 6), d = __builtin_shufflevector(r[2], r[3], 1, 5, 3, 7);
  r[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
  r[1] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
  r[2] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
  r[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}
} // namespace dolfinx_impact::common
