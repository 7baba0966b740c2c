// SPDX-License-Identifier: MIT
#pragma once
#include "../../surface/Surface.h"
#include "../../surface/quadrature.h"
#include <array>
#include <dolfinx/common/IndexMap.h>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// Augmentation of penalty contact by multipliers: Uzawa's method, seed (3.48) with (3.47); Simo and Laursen (1992).
/// Multipliers live at the corners of the slave's facets and are interpolated linearly: at every quadrature point they
/// would be more conditions than the displacements of the nodes can satisfy.
class Uzawa
{
public:
  /// @param[in] map nodes of the displacement space
  /// @param[in] slave this rank's facets, whose nodes the map numbers
  /// @param[in] rule of the quadrature points of a facet
  Uzawa(std::shared_ptr<const dolfinx::common::IndexMap> map, const surface::Facets& slave,
        const surface::QuadratureRule& rule);

  /// Multipliers at owned and ghost nodes, zero at nodes that are not corners; ghosts are brought up to date where they
  /// are used [F/L^2].
  std::vector<double> multiplier;

  /// Number of augmentations of the present increment.
  int rounds() const { return _rounds; }

  /// Begin an increment.
  void begin();
  /// Update the multipliers if surfaces still penetrate. Collective.
  /// @param[in] gap of the quadrature points, facet by facet, infinite without master [L]
  /// @param[in] weight areas of the quadrature points [L^2]
  /// @param[in] penalty of the contact [F/L^3]
  /// @param[in] tolerance largest permitted penetration [L]
  /// @returns multipliers at the quadrature points; nothing if the penetration is below the tolerance [F/L^2]
  std::optional<std::vector<double>> augment(std::span<const double> gap, std::span<const double> weight,
                                             double penalty, double tolerance);
  /// Why the permitted number of augmentations was too small, and what to do, in words.
  std::string fault(double penalty, double tolerance) const;

private:
  std::vector<double> extrapolated(std::vector<double> values, const std::vector<std::int8_t>& little) const;

  std::shared_ptr<const dolfinx::common::IndexMap> _map;
  MPI_Comm _comm;
  int _num_corners;
  std::vector<std::int32_t> _corners; ///< of the facets, [facet*num_corners + i]
  std::vector<double> _table;         ///< corners' functions at the points, [point*num_corners + i]
  int _rounds = 0;
  /// Of the round before the last one and of the last one, the largest change of a multiplier divided by the penalty:
  /// mean penetration around a corner, or its opening where the multiplier decreases [L].
  std::array<double, 2> _penetration{};
};
} // namespace dolfinx_impact::enforcement
