// SPDX-License-Identifier: MIT
#pragma once
#include "Kernel.h"
#include <vector>

namespace dolfinx_impact::kernels
{
/// Coordinates of the nodes of a kernel's reference cell, three per node; of two such cells for a facet between cells.
/// @throws std::invalid_argument for a kernel of another cell than DOLFINx's
std::vector<double> reference_nodes(const impact_kernel& kernel);

/// Time that a kernel takes per cell, its arrays in the cache: on a reference cell, with coefficients and constants
/// that are made up. Processor time would be too coarse; the least of several rounds is what others leave untouched.
/// @param[in] kernel
/// @param[in] widths cells per call, each of which the kernel and the processor have; they take turns
/// @returns time of each width [s]
/// @throws std::invalid_argument for a width that there is not
std::vector<double> seconds_per_cell(const impact_kernel& kernel, const std::vector<int>& widths);

/// The width among `widths` (widest first) that a kernel is fastest with. A narrower one has to be faster by a quarter:
/// sums of two widths may differ in the last digit, and runs shall not differ because a measurement was noisy.
/// Measured once for each kernel in a process, in a fraction of a millisecond.
int fastest_width(const impact_kernel& kernel, const std::vector<int>& widths);
} // namespace dolfinx_impact::kernels
