// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/StaticContact.h"
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace dolfinx_impact::solve
{
typedef std::span<enforcement::MultiplierContact* const> MultiplierContacts;

/// Updates active sets without cycling. All wrong nodes change at once while that reduces their number. If it fails to
/// do so several times in succession, one node changes at a time, the wrong one with the largest number, until there
/// are fewer wrong nodes than ever before. This ends after finitely many changes for P-matrices. Judice and Pires
/// (1994), Murty (1974).
class ActiveSetIteration
{
public:
  /// Update the active sets of contacts. Collective. @returns number of nodes that were wrong, of all ranks
  int change(MultiplierContacts contacts);

  int count() const { return _count; }
  /// Updates of all nodes that may still fail before single nodes change.
  int patience() const { return _patience; }

private:
  static constexpr int most_patience = 3;
  int _count = 0, _best = std::numeric_limits<int>::max(), _patience = most_patience;
};

/// Recognises active sets of a linearised problem that come again, although single nodes change. Such a problem has no
/// active set that fits: with friction there need not be one, as normal and friction forces of a node depend on each
/// other. Its updates would go round for ever.
class RepeatedStates
{
public:
  /// @param[in] later number of updates after the first repetition at which to stop, so that linearised problems that
  /// follow each other begin from different states of a cycle
  RepeatedStates(MPI_Comm comm, int later = 0) : _comm(comm), _later(later) {}

  /// Add the present state, after an update of a single node, and decide whether further updates are useless.
  /// Collective.
  bool stops(MultiplierContacts contacts);
  /// Forget all states: all nodes have changed at once.
  void forget();

private:
  struct State
  {
    std::vector<std::int8_t> active, sliding;
    std::vector<double> multiplier;
  };

  MPI_Comm _comm;
  int _later;
  std::vector<std::vector<State>> _states;
  std::optional<std::size_t> _end;
};
} // namespace dolfinx_impact::solve
