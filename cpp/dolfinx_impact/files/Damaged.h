// SPDX-License-Identifier: MIT
#pragma once
#include <stdexcept>

namespace dolfinx_impact::files
{
/// The content of a file is not what was written.
struct Damaged : std::runtime_error
{
  using std::runtime_error::runtime_error;
};
} // namespace dolfinx_impact::files
