// SPDX-License-Identifier: MIT
#pragma once
#include "Candidates.h"
#include "RollingContact.h"

namespace dolfinx_impact::rolling
{
/// Maps between the multipliers of contacts and the forces on the bodies, at one geometry. Multipliers are nodal
/// forces, in the axes of the mesh, [i*gdim + c] of each contact [F].
class ContactOperators
{
public:
  typedef Candidates::ByContact ByContact;

  /// Collective.
  /// @param[in] contacts after their `update`; they live as long as this
  /// @param[in] num_owned owned degrees of freedom
  ContactOperators(std::span<RollingContact* const> contacts, std::size_t num_owned);

  const std::vector<RollingContact*>& contacts() const { return _contacts; }
  int gdim() const { return _gdim; }
  /// Normal and tangents of the nodes of each contact as rows, [(i*gdim + a)*gdim + c].
  const ByContact& frames() const { return _frames; }
  /// Normals and tangents along which nothing can move, [i*gdim + a] of each contact.
  const std::vector<std::vector<std::int8_t>>& held() const { return _held; }
  /// Matrix from multipliers to nodal forces.
  Mat forces() const { return _forces.get(); }

  /// Global columns of the candidates in the matrix of forces, on all ranks. Collective.
  std::vector<PetscInt> columns(const Candidates& candidates) const;
  /// Areas by which tractions become nodal forces, zero where no multiplier lives [L^2].
  ByContact weights() const;
  /// Forces on both bodies, owned [F]. Collective.
  std::vector<double> nodal_forces(const ByContact& multipliers) const;
  /// Transpose of `nodal_forces`: the work of unit multipliers. Collective.
  /// @param[in] values over owned degrees of freedom
  ByContact jumps(std::span<const double> values) const;

private:
  operators::OwnedMatrix force_matrix(MPI_Comm comm, std::size_t num_owned) const;

  std::vector<RollingContact*> _contacts;
  int _gdim;
  ByContact _frames;
  std::vector<std::vector<std::int8_t>> _held;
  std::vector<std::size_t> _starts; ///< of each contact's multipliers on this rank, and their number
  operators::OwnedMatrix _forces;
};
} // namespace dolfinx_impact::rolling
