// SPDX-License-Identifier: MIT
#pragma once
#include "../../operators/CooMatrix.h"
#include "Constraints.h"
#include <petscvec.h>

namespace dolfinx_impact::enforcement
{
/// Multipliers condensed: unknowns and equations of slave nodes exchanged for those that contact leaves free
/// (docs/contact.md; Wohlmuth and Krause 2003, Popp et al. 2010). With u = T y + known the constrained components leave
/// the system, and with test functions of the same kind (T_L under slip) so do the multipliers: T_L^T K T has the size
/// and, without friction, the symmetry of K.
class Condensation
{
public:
  /// Collective.
  /// @param[in] num_owned, first degrees of freedom of this rank and the global number of the first
  /// @param[in] parts constraints of all contacts
  Condensation(MPI_Comm comm, std::size_t num_owned, std::int64_t first, int gdim, std::vector<Constraints> parts);

  /// T and T_L, borrowed; the same matrix if symmetric().
  Mat right() const { return _right.matrix(); }
  Mat left() const { return _symmetric ? _right.matrix() : _left.matrix(); }
  bool symmetric() const { return _symmetric; }
  /// Known increments by owned degrees of freedom [L].
  std::vector<double> known;
  /// Owned unknowns whose equations are those of multipliers: to be pinned at zero.
  const std::vector<std::int8_t>& pinned() const { return _pinned; }

  /// T_L^T times a nodal residual, zero at pinned unknowns. Collective.
  std::vector<double> residual(std::span<const double> values) const;
  /// Nodal forces without a part along constrained directions whose `residual` is given, with entries of zero at pinned
  /// unknowns.
  std::vector<double> forces(std::span<const double> residual) const;
  /// Unknowns y that stand for displacement increments: a first guess.
  std::vector<double> unknowns(std::span<const double> increments) const;
  /// Displacement increments T y + known. Collective.
  std::vector<double> increment(Vec y) const;
  /// Add displacement increments along a constrained direction.
  /// @param[in] unknown that stands for the direction, pinned
  /// @param[in,out] increments owned; those of its node have one more along the direction [L]
  void add_constrained(std::int32_t unknown, std::span<double> increments) const;
  /// T_L^T K T, the caller's to destroy. Collective.
  Mat condense(Mat K) const;

private:
  void add(const Constraints& part, std::int64_t first, operators::CooMatrix::Entries& right,
           operators::CooMatrix::Entries& left);

  int _gdim;
  bool _symmetric;
  std::vector<Constraints> _parts;
  std::vector<std::int8_t> _pinned;
  operators::CooMatrix _right, _left;
};
} // namespace dolfinx_impact::enforcement
