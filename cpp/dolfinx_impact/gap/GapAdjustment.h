// SPDX-License-Identifier: MIT
#pragma once
#include <optional>

namespace dolfinx_impact::gap
{
/// How gaps differ from the distances of the meshed surfaces (docs/contact.md, "Clearances, offsets and overlaps").
struct GapAdjustment
{
  double offset = 0.0; ///< thickness of layers that the meshes do not have, of both sides: gaps are less [L]
  std::optional<double> clearance; ///< initial gap of the points that are adjusted; nothing: zero [L]
  /// Points are adjusted whose initial gap is at most this, and all that overlap; nothing: with a clearance all points
  /// that have a master, else none [L].
  std::optional<double> adjust;

  /// Are any points adjusted?
  bool adjusts() const { return clearance || adjust; }
  bool any() const { return adjusts() || offset != 0.0; }
  /// Only overlaps are removed.
  bool removes_penetration() const { return adjust == 0.0 && !clearance && offset == 0.0; }
};
} // namespace dolfinx_impact::gap
