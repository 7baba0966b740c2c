// SPDX-License-Identifier: MIT
#include "FloatKernel.h"
#include <cstddef>

namespace dolfinx_impact::kernels
{
extern const impact_float_kernel* const generated_float_table[]; // written by forms/compiler/build.py
extern const std::size_t generated_float_table_size;

const impact_float_kernel* find_float(const impact_kernel& kernel)
{
  // Kernels that are placed on the cells of a tag are copies of those of the table, with the same functions.
  for (std::size_t i = 0; i < generated_float_table_size; ++i)
    if (generated_float_table[i]->kernel->tabulate[0] == kernel.tabulate[0])
      return generated_float_table[i];
  return nullptr;
}

namespace
{
int slot(int width)
{
  return width == 8 ? 2 : width == 4 ? 1 : 0;
}
} // namespace

impact_float_tabulate tabulate(const impact_float_kernel& kernel, int width)
{
  return kernel.tabulate[slot(width)];
}

impact_float_sweep sweep(const impact_float_kernel& kernel, int width)
{
  return kernel.sweep[slot(width)];
}
} // namespace dolfinx_impact::kernels
