// SPDX-License-Identifier: MIT
#pragma once
#include "active_set.h"
#include <memory>

namespace dolfinx_impact::enforcement
{
/// Frictionless contact of two deformable surfaces by dual Lagrange multipliers: what a static problem in C++ asks of
/// it in every iteration. Friction, rigid masters, prescribed slave nodes and other bases: compose the functions of
/// active_set.h, as the Python package does.
class FrictionlessMortar
{
public:
  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] slave, master this rank's facets (make_surface)
  /// @param[in] axisymmetric x is the radius
  FrictionlessMortar(const std::shared_ptr<const surface::FunctionSpace>& V, const surface::Facets& slave,
                     const surface::Facets& master, bool axisymmetric = false);

  /// Search, mortar integrals, gaps and normals. Collective.
  /// @param[in] u, start displacements now and when the step began, owned and ghosts [L]
  void update_gap(std::span<const double> u, std::span<const double> start);
  /// Multipliers of the active nodes from equilibrium.
  /// @param[in] residual internal minus external forces, owned entries [F]
  void update_multipliers(std::span<const double> residual);
  /// Close nodes that penetrate, open nodes that pull. Collective.
  /// @param[in] first the step has just begun: only gaps count
  /// @returns number of nodes of all ranks that have changed
  int update_active_set(bool first);
  /// Constraints of the active nodes, for Condensation.
  Constraints constraints() const;
  /// Nodal contact forces on both bodies, owned entries [F]. Collective.
  std::vector<double> contact_forces() const;

  const gap::MortarIntegrals& integrals() const { return _integrals; }
  /// By the integrals' nodes.
  const std::vector<std::int8_t>& active() const { return _active; }
  /// Multiplier: the contact pressure, by the integrals' nodes [F/L^2].
  const std::vector<double>& pressure() const { return _pressure; }

private:
  NodalMultipliers state() const;
  NodalGeometry geometry() const;

  MPI_Comm _comm;
  int _gdim;
  gap::MortarIntegrals _integrals;
  NodalFrames _frames;
  std::vector<std::int8_t> _active, _usable;
  std::vector<double> _pressure;
  double _tolerance; ///< gaps below it are none [L]
};
} // namespace dolfinx_impact::enforcement
