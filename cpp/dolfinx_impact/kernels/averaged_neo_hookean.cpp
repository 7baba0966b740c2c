// SPDX-License-Identifier: MIT
#include "averaged_neo_hookean.h"

namespace dolfinx_impact::kernels
{
#if defined(__x86_64__) && defined(__GNUC__)
// Of averaged_neo_hookean_lanes.cpp, which is compiled for each width.
AveragedNeoHookeanKernels averaged_neo_hookean_4();
AveragedNeoHookeanKernels averaged_neo_hookean_8();

AveragedNeoHookeanKernels averaged_neo_hookean(int width)
{
  return width == 8 ? averaged_neo_hookean_8() : width == 4 ? averaged_neo_hookean_4() : AveragedNeoHookeanKernels{};
}
#else
AveragedNeoHookeanKernels averaged_neo_hookean(int)
{
  return {};
}
#endif
} // namespace dolfinx_impact::kernels
