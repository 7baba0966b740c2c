// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/mortar/Condensation.h"
#include "../enforcement/mortar/SaddlePoint.h"
#include <cstdint>
#include <memory>
#include <optional>
#include <petscmat.h>
#include <span>
#include <vector>

/// Seventh stage: equilibrium of bodies and contacts, by Newton's method and linear solvers.
namespace dolfinx_impact::solve
{
/// A linear system A y = b whose unknowns stand for increments of displacement, K and what contacts add to it being its
/// stiffness. Matrices are borrowed, and must stay as they are as long as the system lives. All calls are collective.
class LinearSystem
{
public:
  /// @param[in] K matrix of the displacements [F/L]
  /// @param[in] extra matrices of the same size, which are added to it [F/L]
  LinearSystem(Mat K, std::span<const Mat> extra);
  virtual ~LinearSystem() = default;
  LinearSystem(const LinearSystem&) = delete;
  LinearSystem& operator=(const LinearSystem&) = delete;

  /// y = A x.
  virtual void mult(Vec x, Vec y) = 0;
  /// A as a matrix of its own, the caller's to destroy.
  virtual Mat assemble() = 0;
  /// Right-hand side.
  /// @param[in] residual without contact forces of multipliers, owned [F]
  /// @param[in] values unknowns, of which pinned ones are read
  virtual void load(std::span<const double> residual, Vec values, Vec b) = 0;
  /// Increments of displacement that unknowns stand for, owned [L].
  virtual std::vector<double> displacements(Vec y) = 0;
  /// A vector of the unknowns, the caller's to destroy.
  virtual Vec create_vector() const = 0;

  /// Unknowns with given values, by owned unknown.
  virtual std::span<const std::int8_t> pinned() const = 0;
  virtual bool symmetric() const = 0;
  Mat K() const { return _stiffness.front(); }
  /// K, then what is added to it.
  std::span<const Mat> stiffness() const { return _stiffness; }
  /// A number that no other system of this process has.
  std::uint64_t id() const { return _id; }

protected:
  std::vector<Mat> _stiffness;

private:
  std::uint64_t _id;
};

/// Multipliers condensed, or no multipliers: A = Q T_L^T (K + sum of extra) T Q + d (1 - Q), where Q sets pinned
/// unknowns to zero. Products need no A; only a preconditioner forms it.
class CondensedSystem : public LinearSystem
{
public:
  /// @param[in] symmetric whether K and extra are symmetric
  /// @param[in] condensation of the multipliers; null: there are none
  /// @param[in] pinned mask over owned degrees of freedom
  /// @param[in] diagonal d, an entry of K's size [F/L]
  CondensedSystem(Mat K, std::span<const Mat> extra, bool symmetric,
                  std::shared_ptr<enforcement::Condensation> condensation, std::vector<std::int8_t> pinned,
                  double diagonal);
  ~CondensedSystem() override;

  void mult(Vec x, Vec y) override;
  Mat assemble() override;
  void load(std::span<const double> residual, Vec values, Vec b) override;
  std::vector<double> displacements(Vec y) override;
  Vec create_vector() const override;
  std::span<const std::int8_t> pinned() const override { return _pinned; }
  bool symmetric() const override { return _symmetric; }
  enforcement::Condensation* condensation() { return _condensation.get(); }
  /// The same, to be kept longer than the system.
  std::shared_ptr<enforcement::Condensation> shared_condensation() const { return _condensation; }
  /// Columns of A as a matrix that has a column for each of the unknowns of this rank that are given, the caller's to
  /// destroy. Rows of pinned unknowns are zero. Collective.
  /// @param[in] unknowns local numbers of owned unknowns that are not pinned
  Mat columns(std::span<const PetscInt> unknowns) const;
  /// Nodal forces whose condensed residual is a right-hand side without its pinned entries, owned [F].
  std::vector<double> forces(Vec b) const;
  /// Unknowns that stand for increments of displacement; pinned ones are those of the right-hand side.
  void set_unknowns(std::span<const double> increments, Vec b, Vec y) const;

protected:
  double diagonal() const { return _diagonal; }

private:
  void multiply_stiffness(Vec x, Vec y) const;

  std::shared_ptr<enforcement::Condensation> _condensation;
  bool _symmetric;
  std::vector<std::int8_t> _pinned;
  std::vector<PetscInt> _pinned_rows; ///< local
  double _diagonal;
  Vec _free = nullptr, _moved = nullptr, _force = nullptr; ///< work
};

/// A symmetric K, and unsymmetric matrices that are small beside it: A = Q (K + sum of extra) Q + d (1 - Q), without
/// multipliers. Preconditioners are made of K alone: Cholesky's factors are half as large, serve other extra matrices,
/// and tell which bodies nothing holds but these.
class PerturbedSystem : public CondensedSystem
{
public:
  /// @param[in] pinned mask over owned degrees of freedom
  /// @param[in] diagonal d, an entry of K's size [F/L]
  PerturbedSystem(Mat K, std::span<const Mat> extra, std::vector<std::int8_t> pinned, double diagonal);

  /// Q K Q + d (1 - Q), marked as symmetric; the caller's to destroy.
  Mat assemble() override;
};

/// Multipliers kept as unknowns behind each rank's displacements.
class SaddlePointSystem : public LinearSystem
{
public:
  /// @param[in] rows constraints of the present linear problem, assigned; must outlive the system
  SaddlePointSystem(Mat K, std::span<const Mat> extra, enforcement::SaddlePoint& rows);

  void mult(Vec x, Vec y) override { _rows.mult(_stiffness, x, y); }
  Mat assemble() override { return _rows.assemble(_stiffness); }
  void load(std::span<const double> residual, Vec values, Vec b) override
  {
    _rows.load(_stiffness, residual, values, b);
  }
  std::vector<double> displacements(Vec y) override;
  Vec create_vector() const override;
  std::span<const std::int8_t> pinned() const override { return _rows.pinned(); }
  bool symmetric() const override { return false; } // indefinite: nothing for conjugate gradients

private:
  enforcement::SaddlePoint& _rows;
};
} // namespace dolfinx_impact::solve
