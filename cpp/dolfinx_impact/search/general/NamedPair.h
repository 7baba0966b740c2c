// SPDX-License-Identifier: MIT
#pragma once
#include "../../surface/Facets.h"

namespace dolfinx_impact::search
{
/// Two surfaces that another contact pushes apart: general contact leaves them alone.
struct NamedPair
{
  surface::Facets slave, master;
};
} // namespace dolfinx_impact::search
