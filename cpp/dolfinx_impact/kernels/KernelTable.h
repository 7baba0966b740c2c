// SPDX-License-Identifier: MIT
#pragma once
#include "Kernel.h"
#include <span>
#include <string>
#include <vector>

/// First stage: kernels generated from UFL forms, built with the package, with a program, or loaded at run time.
namespace dolfinx_impact::kernels
{
/// Kernels built with the package, in the order of forms/registry.py.
std::span<const impact_kernel* const> table();

/// What to look for in the table.
struct Key
{
  std::string name; ///< for example "linear_elastic.force"
  std::string cell; ///< "triangle", "quadrilateral", "tetrahedron", "hexahedron"
  int degree = 1;   ///< of the test function (of the first coefficient for an energy)
  int geometry_degree = 1;
  std::string hypothesis = ""; ///< "3d", "plane_strain", ...; empty: the only one, or an error
};

/// Kernels of one form (one per integral): of the package, or added ones.
/// @throws std::runtime_error if there is no such form; the message lists the nearest
std::vector<const impact_kernel*> find(const Key& key);

/// From now on `find` finds these kernels, too: those of a header that `dolfinx-impact compile` wrote. Kernels that are
/// there already are left out, so that a header may be added twice.
/// @param[in] kernels descriptors that live as long as the process
/// @throws std::runtime_error if a kernel was compiled for another version, or another form has its name, cell, degrees
///   and hypothesis; then none is added
void add(std::span<const impact_kernel* const> kernels);

/// Kernels built with the package whose form has this signature (forms/compiler/emit.py), or an empty list.
std::vector<const impact_kernel*> find_signature(const std::string& signature);

/// Load kernels compiled at run time from a shared library. The library stays loaded until the process ends.
/// @param[in] path shared library
/// @param[in] symbols names of the descriptors
/// @throws std::runtime_error if it cannot be opened, a name is missing, or it was made for another version
std::vector<const impact_kernel*> load(const std::string& path, const std::vector<std::string>& symbols);

/// Cells per call on this machine: the width that the kernel is fastest with, measured once in a process (timing.h); of
/// an expression the widest that the processor has and the kernel was compiled for.
/// @param[in] kernel
/// @param[in] limit 1, 4 or 8: the widest up to this one, not measured. 0: IMPACT_SIMD_WIDTH=1|4|8 of the environment
///   is the limit, which makes runs the same to the last digit; without it the width is measured
int width(const impact_kernel& kernel, int limit = 0);

/// Width that IMPACT_SIMD_WIDTH asks for; 0: it is not given.
/// @throws std::runtime_error if it is given, but is no width
int environment_width();

/// Widest vector of doubles of this processor that kernels are compiled for: 1, 4 or 8.
int processor_width();

/// The function for a width that `width` returned.
impact_tabulate tabulate(const impact_kernel& kernel, int width);

/// The sweep for a width that `width` returned; null: the kernel has none.
impact_sweep sweep(const impact_kernel& kernel, int width);
} // namespace dolfinx_impact::kernels
