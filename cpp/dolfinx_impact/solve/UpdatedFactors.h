// SPDX-License-Identifier: MIT
#pragma once
#include "CondensedFactors.h"
#include "LinearSystem.h"
#include <cstdint>
#include <functional>
#include <memory>
#include <petscmat.h>
#include <petscvec.h>
#include <span>
#include <vector>

namespace dolfinx_impact::solve
{
/// Factors of one active set made good for others: a low-rank update through the Schur complement of contact.
///
/// The factors invert the bodies' stiffness under the conditions of the nodes that were active then. Forces at the
/// nodes that have closed since and gaps at those that have opened are unknowns of a small dense system; the
/// displacements that they cause are known columns. The result is the inverse of the system of the present active set
/// as long as stiffness and normals are those of the factors, and a preconditioner that needs few iterations when they
/// have changed a little. Sherman, Morrison and Woodbury; Golub and Van Loan (2013), 2.1.4.
class UpdatedFactors
{
public:
  /// Response to a change of the state of one node.
  struct Column
  {
    std::int64_t node;             ///< global number
    bool opened;                   ///< whether the node was active when the factors were made
    std::vector<double> force;     ///< of unit tractions at a node that closes, owned; empty for one that opens [F]
    std::vector<double> increment; ///< displacements, owned: by that force, or by a unit gap [L]
  };
  /// Forces of displacement increments, owned [F] of owned [L]. Collective.
  typedef std::function<std::vector<double>(std::span<const double>)> Product;

  /// Collective.
  /// @param[in] factors of the system's matrix, borrowed
  /// @param[in] condensation of that system, whose known increments are set to zero
  /// @param[in] pinned unknowns of that system
  /// @param[in] active nodes then, by node of the contact
  /// @param[in] columns the same nodes on all ranks
  /// @param[in] product with the stiffness of bodies and contacts, called here only
  UpdatedFactors(MPI_Comm comm, Mat factors, std::shared_ptr<enforcement::Condensation> condensation,
                 std::vector<std::int8_t> pinned, std::vector<std::int8_t> active, std::vector<Column> columns,
                 const Product& product);

  /// Choose the columns of the present active set. Collective.
  /// @param[in] system of that set; must live as long as `apply` is called
  /// @param[in] numbers global numbers of the contact's nodes
  /// @param[in] active nodes now, by node of the contact
  void select(CondensedSystem& system, std::span<const std::int64_t> numbers, std::span<const std::int8_t> active);
  /// Whether they were chosen for this system.
  bool serves(const LinearSystem& system) const { return _system_id == system.id(); }
  /// Nodes of all ranks whose state differs from that of the factors and that have no column. Each of them costs an
  /// iteration or so.
  std::int64_t num_missing() const { return _num_missing; }
  /// z = inverse of the system times r, nearly. Collective.
  void apply(Vec r, Vec z) const;

private:
  MPI_Comm _comm;
  CondensedFactors _factors;
  std::vector<std::int8_t> _active;
  std::vector<Column> _columns;
  std::vector<double> _matrix;      ///< conditions of the nodes (rows) by columns: [i*num_columns + j]
  std::vector<std::size_t> _chosen; ///< columns in use
  std::vector<double> _inverse;     ///< of their part of the matrix
  CondensedSystem* _system = nullptr;
  std::uint64_t _system_id = 0; ///< no system has it
  std::int64_t _num_missing = 0;
};
} // namespace dolfinx_impact::solve
