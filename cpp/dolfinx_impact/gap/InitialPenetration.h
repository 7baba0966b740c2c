// SPDX-License-Identifier: MIT
#pragma once
#include "../surface/Surface.h"
#include "GapAdjustment.h"
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::gap
{
/// Penetrations of the contact points in the reference configuration of bodies and obstacles, and what their gaps are
/// adjusted by.
class InitialPenetration
{
public:
  /// Collective.
  /// @param[in] name of the pair, for messages
  /// @param[in] slave, master this rank's facets, whose nodes are those of V; no master: it is rigid
  /// @param[in] x positions of the contact points, [i*gdim + c] [L]
  /// @param[in] gap of the contact points, infinite without master [L]
  /// @param[in] adjustment by how much later gaps differ from the distances of the surfaces
  /// @throws std::invalid_argument on all ranks, if every point penetrates by more than half of the thinner body: a
  /// press fit has less
  InitialPenetration(std::string name, const surface::FunctionSpace& V, const surface::Facets& slave,
                     const surface::Facets* master, std::span<const double> x, std::span<const double> gap,
                     const GapAdjustment& adjustment);

  /// Number of contact points of all ranks that penetrate by more than round-off, layers of the surfaces counted.
  std::int64_t num_points() const { return _deepest.num_points; }
  /// Their largest penetration [L].
  double depth() const { return _deepest.size; }
  /// Position of the largest penetration, gdim entries; empty without penetration [L].
  const std::vector<double>& where() const { return _deepest.where; }
  /// Number of contact points of all ranks whose gap was adjusted by more than round-off.
  std::int64_t num_adjusted() const { return _farthest.num_points; }
  /// The largest adjustment of a gap [L].
  double largest_adjustment() const { return _farthest.size; }
  /// Position of the largest adjustment, gdim entries; empty without any [L].
  const std::vector<double>& where_adjusted() const { return _farthest.where; }
  /// Values to be added to all later gaps [L].
  const std::vector<double>& offset() const { return _offset; }
  /// How many points penetrate or were adjusted, how far and where, in words; empty if none is.
  std::string warning() const;

private:
  /// Points of all ranks with a value above round-off, and the largest value.
  struct Largest
  {
    std::int64_t num_points = 0;
    double size = 0.0;
    std::vector<double> where;
  };
  static Largest largest(MPI_Comm comm, int gdim, std::span<const double> x, std::span<const double> values,
                         double least);

  std::string _name;
  GapAdjustment _adjustment;
  Largest _deepest, _farthest;
  std::vector<double> _offset;
};
} // namespace dolfinx_impact::gap
