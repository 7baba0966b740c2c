// SPDX-License-Identifier: MIT
#pragma once

/// What this processor can do, measured: the scale that benchmarks are shown against.
namespace dolfinx_impact::common
{
/// Memory bandwidth of one core, bytes per second: best of several runs of a[i] = b[i] + s c[i] on arrays far larger
/// than the caches; three arrays counted (McCalpin's STREAM triad).
double triad_bandwidth();

/// Double-precision operations per second of one core, in processor time: independent multiply-adds, fused where the
/// processor does that; a multiply-add counts as two.
/// @param[in] lanes numbers in a vector, 2, 4 (AVX2) or 8 (AVX-512); 0: the best of those that this processor has
/// @return operations per second; 0 if the processor does not have such vectors
/// @throws std::invalid_argument for other numbers
double peak_flops(int lanes = 0);

/// Give memory that set-up no longer needs back to the system, where the C library can.
void release_memory();
} // namespace dolfinx_impact::common
