// SPDX-License-Identifier: MIT
#pragma once

namespace dolfinx_impact::common
{
/// Ask the memory for a line of the cache that is read soon; no effect on results.
inline void prefetch(const void* address)
{
#if defined(__GNUC__)
  __builtin_prefetch(address);
#else
  (void)address;
#endif
}
} // namespace dolfinx_impact::common
