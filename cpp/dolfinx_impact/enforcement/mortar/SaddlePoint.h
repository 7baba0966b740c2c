// SPDX-License-Identifier: MIT
#pragma once
#include "../../operators/CooMatrix.h"
#include "Constraints.h"
#include <array>
#include <petscvec.h>

namespace dolfinx_impact::enforcement
{
/// Multipliers kept as unknowns: the saddle point system of displacements and contact forces,
///
///     [ K    -C_L^T ] [ du ]   [ -R + C_L^T f ]
///     [ -C    0     ] [ df ] = [ -known       ].
///
/// Row (j, d) of C is the component q_jd . u_j - m_jd . sum_l P_jl u_l of the jump at slave node j that contact
/// constrains (Constraints), f_jd the force that enforces it, R the residual without contact. In C_L the normal force
/// of a slipping node leans along its friction. Rows of C are multiplied by an entry of K's size, so that residuals of
/// both kinds are forces. Multipliers of any basis will do; the matrix is indefinite and needs a direct solver.
///
/// Nodes that several contacts constrain have the conditions of all. Those that others imply, or that contradict them,
/// are left out: those of ties come first, then the normals, the most closed before the others, then what sticks along
/// directions that no normal of the node holds, in the order of the contacts.
///
/// A rank's unknowns are its displacements, then `gdim` forces for every node of its contacts. Those of directions that
/// are not constrained are pinned at zero. Matrices keep their pattern from one linear problem to the next while it
/// stands.
class SaddlePoint
{
public:
  /// Collective.
  /// @param[in] num_owned degrees of freedom of this rank
  /// @param[in] sizes number of nodes of every contact on this rank
  SaddlePoint(MPI_Comm comm, std::size_t num_owned, int gdim, std::vector<std::size_t> sizes);
  ~SaddlePoint();
  SaddlePoint(const SaddlePoint&) = delete;
  SaddlePoint& operator=(const SaddlePoint&) = delete;

  /// A new linear problem. Collective.
  /// @param[in] parts constraints of all contacts, in the order of `sizes`
  /// @param[in] pinned owned degrees of freedom that are prescribed
  /// @param[in] forces of the multipliers at the start, [node*gdim + d], over the diagonal [L]
  /// @param[in] diagonal entry of K's size [F/L]
  /// @throws std::invalid_argument for arrays of other sizes
  void assign(std::span<const Constraints> parts, std::span<const std::int8_t> pinned, std::span<const double> forces,
              double diagonal);

  std::size_t num_displacements() const { return _num; }
  std::size_t num_unknowns() const { return _pinned.size(); }
  /// Pinned unknowns: prescribed displacements, forces of directions without constraint.
  const std::vector<std::int8_t>& pinned() const { return _pinned; }
  /// Nodes whose normal condition was left out, by contact: Constraints::rows.
  const std::vector<std::vector<std::int32_t>>& redundant() const { return _redundant; }
  /// C and C_L by rows of the forces, borrowed.
  Mat right() const { return _right.matrix(); }
  Mat left() const { return _left.matrix(); }

  /// y = A x; `stiffness` is a sum of matrices, K and what contacts add to it. Collective.
  void mult(std::span<const Mat> stiffness, Vec x, Vec y);
  /// Right-hand side. Collective.
  /// @param[in] residual without contact, owned entries [F]
  /// @param[in] values of pinned displacements in the unknowns [L]
  void load(std::span<const Mat> stiffness, std::span<const double> residual, Vec values, Vec b);
  /// A as a matrix of its own, the caller's to destroy. Collective.
  Mat assemble(std::span<const Mat> stiffness);
  /// Unknowns that stand for increments of displacement [L] and multipliers' forces over the diagonal [L]: a guess.
  std::vector<double> unknowns(std::span<const double> increments, std::span<const double> forces) const;
  /// Multipliers' forces over the diagonal [L] that unknowns stand for, [node*gdim + d].
  std::vector<double> forces(Vec y) const;

private:
  void add(const Constraints& part, std::span<const std::int8_t> constrained, std::size_t start,
           operators::CooMatrix::Entries& right, operators::CooMatrix::Entries& left) const;
  std::vector<std::vector<std::int8_t>> independent(std::span<const Constraints> parts);
  void product(std::span<const Mat> stiffness, std::span<const double> x, std::vector<double>& y);

  MPI_Comm _comm;
  std::size_t _num; ///< displacements
  int _gdim;
  std::vector<std::size_t> _starts; ///< of every contact's nodes among all, and the end
  std::vector<std::vector<std::int32_t>> _redundant;
  std::vector<PetscInt> _u_ends;     ///< of the ranks' displacements among all
  std::vector<PetscInt> _force_ends; ///< of the ranks' forces among all
  PetscInt _first_u, _first_force;
  double _diagonal = 1.0;
  std::vector<std::int8_t> _pinned;
  std::vector<double> _forces; ///< at the start, zero where nothing is constrained
  std::vector<double> _known;  ///< increments of constrained jumps times the diagonal [F]
  operators::CooMatrix _right, _left, _matrix;
  std::array<Vec, 3> _u{}; ///< work: increment, force, force of the multipliers
  std::array<Vec, 2> _f{}; ///< work: multipliers' forces, jumps
};
} // namespace dolfinx_impact::enforcement
