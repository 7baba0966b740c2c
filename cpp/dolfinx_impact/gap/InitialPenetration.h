// SPDX-License-Identifier: MIT
#pragma once
#include "../surface/Surface.h"
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::gap
{
/// Penetrations of the contact points in the reference configuration of bodies and obstacles.
class InitialPenetration
{
public:
  /// Collective.
  /// @param[in] name of the pair, for messages
  /// @param[in] slave, master this rank's facets, whose nodes are those of V; no master: it is rigid
  /// @param[in] x positions of the contact points, [i*gdim + c] [L]
  /// @param[in] gap of the contact points, infinite without master [L]
  /// @param[in] remove later gaps count from the penetrations
  /// @throws std::invalid_argument on all ranks, if every point penetrates by more than half of the thinner body: a
  /// press fit has less
  InitialPenetration(std::string name, const surface::FunctionSpace& V, const surface::Facets& slave,
                     const surface::Facets* master, std::span<const double> x, std::span<const double> gap,
                     bool remove);

  /// Number of contact points of all ranks that penetrate by more than round-off.
  std::int64_t num_points() const { return _num_points; }
  /// Their largest penetration [L].
  double depth() const { return _depth; }
  /// Position of the largest penetration, gdim entries; empty without penetration [L].
  const std::vector<double>& where() const { return _where; }
  /// Values to be added to all later gaps [L].
  const std::vector<double>& offset() const { return _offset; }
  /// How many points penetrate, how deep and where, in words; empty if none does.
  std::string warning() const;

private:
  std::string _name;
  bool _remove;
  std::int64_t _num_points = 0;
  double _depth = 0.0;
  std::vector<double> _where, _offset;
};
} // namespace dolfinx_impact::gap
