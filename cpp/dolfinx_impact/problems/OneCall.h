// SPDX-License-Identifier: MIT
#pragma once
#include "../common/OnAllRanks.h"
#include <string>

namespace dolfinx_impact::problems
{
/// Marks a call of a problem as under way, as long as this lives: functions that it tells may not call it again.
class OneCall
{
public:
  /// @param[in,out] under_way the problem's mark, the same on all ranks
  /// @throws common::Failure if there is a call already
  OneCall(bool& under_way, const std::string& call) : _under_way(under_way)
  {
    if (under_way)
      throw common::Failure(call + " was called by a function that a call of it tells: return from that first");
    under_way = true;
  }
  ~OneCall() { _under_way = false; }
  OneCall(const OneCall&) = delete;
  OneCall& operator=(const OneCall&) = delete;

private:
  bool& _under_way;
};
} // namespace dolfinx_impact::problems
