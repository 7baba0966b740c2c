// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <mpi.h>
#include <span>
#include <vector>

namespace dolfinx_impact::rolling
{
/// Slave nodes of all contacts and ranks for which contact is decided, in one order: by rank, contact and node. What is
/// gathered is on rank 0. Arrays of a contact's nodes have `width` entries for each node.
class Candidates
{
public:
  /// Values of the nodes of each contact on this rank.
  typedef std::vector<std::vector<double>> ByContact;

  /// Collective.
  /// @param[in] chosen masks of the nodes of each contact
  Candidates(MPI_Comm comm, const std::vector<std::vector<std::int8_t>>& chosen);

  /// Candidates of all ranks.
  int count() const { return _count; }
  /// The chosen nodes of each contact on this rank.
  const std::vector<std::vector<std::int32_t>>& local() const { return _local; }
  /// Values of all candidates, on rank 0; empty on others. Collective.
  std::vector<double> gather(const ByContact& values, int width) const;
  std::vector<double> gather(const std::vector<std::vector<std::int8_t>>& values, int width) const;
  /// Values of the nodes of each contact on this rank, zero at nodes that are none. Collective.
  /// @param[in] values of all candidates, on rank 0
  /// @param[in] sizes number of nodes of each contact on this rank
  ByContact scatter(const std::vector<double>& values, const std::vector<std::size_t>& sizes, int width) const;

private:
  MPI_Comm _comm;
  int _rank = 0, _count = 0;
  std::vector<std::vector<std::int32_t>> _local;
  std::vector<int> _counts, _starts; ///< by rank
};
} // namespace dolfinx_impact::rolling
