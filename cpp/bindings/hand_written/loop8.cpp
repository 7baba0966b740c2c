// SPDX-License-Identifier: MIT
#define IMPACT_HAND_WRITTEN_WIDTH 8
#include "loop.h"

dolfinx_impact::hand_written::CellLoop dolfinx_impact::hand_written::loop8(const CellKind& kind)
{
  return loop(kind);
}
