// SPDX-License-Identifier: MIT
#pragma once

/// What this processor can do, measured: the scale that benchmarks are shown against.
namespace dolfinx_impact::common
{
/// Memory bandwidth of one core, bytes per second: best of several runs of a[i] = b[i] + s c[i] on arrays far larger
/// than the caches; three arrays counted (McCalpin's STREAM triad).
double triad_bandwidth();

/// Double-precision operations per second of one core: independent fused multiply-adds in the widest vectors that
/// kernels are compiled for; a multiply-add counts as two.
double peak_flops();

/// Give memory that set-up no longer needs back to the system, where the C library can.
void release_memory();
} // namespace dolfinx_impact::common
