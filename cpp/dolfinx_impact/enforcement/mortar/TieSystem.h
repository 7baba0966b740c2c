// SPDX-License-Identifier: MIT
#pragma once
#include "../../operators/CholeskyFactors.h"
#include "TieConditions.h"
#include <memory>
#include <petscmat.h>
#include <span>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// The forces between tied surfaces of bodies with lumped mass: S z = b with S = C M^-1 C^T, C the conditions of all
/// ties of a run; docs/tie.md. S is constant, sparse and positive definite, of the size of the surfaces. It falls into
/// blocks that have no common entry: conditions along different axes, joints apart from each other. Equal blocks, as
/// those of the axes are where no support meets the joint, have their factors in common. Every rank has all factors
/// (Cholesky), so that a solution is one exchange of right-hand sides and the same on all ranks. A rank's unknowns are
/// the conditions of its nodes, tie after tie, node after node.
class TieSystem
{
public:
  /// Collective.
  /// @param[in] ties of a problem, which leave out each other's components
  /// @param[in] inverse_mass of owned degrees of freedom, zero where prescribed [1/M]
  /// @throws std::runtime_error if S is singular: conditions of ties imply each other
  TieSystem(std::vector<const TieConditions*> ties, std::span<const double> inverse_mass);

  /// Number of this rank's unknowns.
  std::size_t size() const { return _rows.size(); }
  /// Numbers of blocks of S and of those that are factorised.
  std::size_t num_blocks() const { return _blocks.size(); }
  std::size_t num_factors() const { return _factors.size(); }
  /// Solve S z = b. Collective. No allocation.
  /// @param[in] b, z this rank's entries
  void solve(std::span<const double> b, std::span<double> z);
  /// Remove from accelerations or velocities what the conditions forbid: v - M^-1 C^T S^-1 C v. Collective.
  /// @param[in] v owned values
  std::vector<double> project(std::span<const double> v);
  /// Largest C v over the weights, of all ranks. Collective.
  double largest_jump(std::span<const double> v) const;

private:
  /// Unknowns that have entries of S in common.
  struct Block
  {
    std::vector<PetscInt> rows; ///< in S, ascending
    std::size_t factors = 0;    ///< place in `_factors`
  };

  void find_rows();
  void factorise(Mat S);

  MPI_Comm _comm;
  std::vector<const TieConditions*> _ties;
  std::vector<double> _inverse_mass;
  std::vector<PetscInt> _rows;       ///< degrees of freedom whose rows of C are this rank's unknowns
  std::vector<PetscInt> _all_rows;   ///< of all ranks, ascending: the rows of S
  std::vector<int> _counts, _starts; ///< of the unknowns of all ranks
  std::vector<std::size_t> _order;   ///< places in S of the unknowns, rank after rank
  std::vector<double> _received;     ///< right-hand sides, rank after rank
  std::vector<double> _b, _z;        ///< of all ranks, in the order of S
  std::vector<Block> _blocks;
  std::vector<std::unique_ptr<operators::CholeskyFactors>> _factors;
};
} // namespace dolfinx_impact::enforcement
