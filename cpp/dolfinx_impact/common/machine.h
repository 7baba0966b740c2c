// SPDX-License-Identifier: MIT
#pragma once
#include <cstddef>

/// What this processor can do, measured: the scale that benchmarks are shown against.
namespace dolfinx_impact::common
{
/// Bandwidth of one core, bytes per second: best of several runs of a[i] = b[i] + s c[i]; three arrays counted
/// (McCalpin's STREAM triad). By default of the memory: the arrays are far larger than the caches.
/// @param[in] n entries of each array; 1,024 stay in the first-level cache
/// @throws std::invalid_argument for none
double triad_bandwidth(std::size_t n = std::size_t(1) << 24);

/// Double-precision operations per second of one core, in processor time: independent multiply-adds, fused where the
/// processor does that; a multiply-add counts as two.
/// @param[in] lanes numbers in a vector, 2, 4 (AVX2) or 8 (AVX-512); 0: the best of those that this processor has
/// @return operations per second; 0 if the processor does not have such vectors
/// @throws std::invalid_argument for other numbers
double peak_flops(int lanes = 0);

/// Give memory that set-up no longer needs back to the system, where the C library can.
void release_memory();
} // namespace dolfinx_impact::common
