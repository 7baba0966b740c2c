// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>

namespace dolfinx_impact::enforcement
{
/// State of a contact point.
enum class ContactStatus : std::int8_t
{
  open = 0,
  stick = 1,
  slip = 2 ///< without friction every closed point slips
};
} // namespace dolfinx_impact::enforcement
