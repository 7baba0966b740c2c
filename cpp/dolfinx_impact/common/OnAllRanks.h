// SPDX-License-Identifier: MIT
#pragma once
#include <stdexcept>

namespace dolfinx_impact::common
{
/// Part of exceptions that all ranks throw together: who handles one may communicate.
struct OnAllRanks
{
  virtual ~OnAllRanks() = default;
};

/// A value that does not fit.
struct BadValue : std::invalid_argument, OnAllRanks
{
  using std::invalid_argument::invalid_argument;
};

/// A computation that cannot go on: it does not converge, or is unstable.
struct Failure : std::runtime_error, OnAllRanks
{
  using std::runtime_error::runtime_error;
};
} // namespace dolfinx_impact::common
