// SPDX-License-Identifier: MIT
#pragma once
#include "../../surface/FacetElement.h"

namespace dolfinx_impact::search
{
/// How fast a unit normal can rotate.
///
/// If every node of a facet moves by at most D (a common translation left out), tangents a and b at a place change by
/// at most C D, C the largest sum of the moduli of the shape functions' derivatives. With w = a x b, Q = C (|a| + |b|)
/// / (2 |w|) (in the plane Q = C / (2 |a|)) and q = Q D <= 0.2, e = |w' - w| / |w| <= 2 q + q^2, so that the unit
/// normal changes by at most e / sqrt(1 - e) <= 2.94 q. The normalised sum s of several unit normals changes by at most
/// x / sqrt(1 - x), x = 2.94 D sum(Q) / |s|: no more than 4.6 D sum(Q) / |s| as long as that is 0.9 at most.
struct NormalRotation
{
  static constexpr double factor = 4.6; ///< change of a unit normal, or of the mean of some, per Q and D
  static constexpr double most = 0.9;   ///< changes up to this are bounded by `factor`
  /// The Q of a facet at a place [1/L].
  /// @param[in] a tangents
  /// @param[in] slope the C of its element [1]
  static double rate(int tdim, const double a[2][3], double slope);
  /// The C of an element of which positions are given by its nodes.
  static double slope(const surface::FacetElement& element);
};
} // namespace dolfinx_impact::search
