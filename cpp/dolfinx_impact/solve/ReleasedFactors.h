// SPDX-License-Identifier: MIT
#pragma once
#include "CondensedFactors.h"
#include "LinearSystem.h"
#include <cstdint>
#include <memory>
#include <petscmat.h>
#include <petscvec.h>
#include <span>
#include <vector>

namespace dolfinx_impact::solve
{
/// Factors of bodies that multipliers press together made good for systems without multipliers: springs in the place of
/// the multipliers, or surfaces that are apart.
///
/// The factors invert the bodies' stiffness K under the conditions of the constrained nodes, u = T y. Displacements X
/// that open one gap each, in equilibrium under the others' conditions, are known columns. The inverse of K without
/// conditions is
///
///     T (T^T K T)^-1 T^T + X (X^T K X)^-1 X^T,
///
/// as X^T K T y = 0. For another stiffness A, as of springs between the surfaces, the first part is followed by the
/// Galerkin correction with A in the columns: what is left of A is that of gaps between the nodes. A preconditioner
/// that needs few iterations when springs are not much stiffer than cells. Sherman, Morrison and Woodbury; Golub and
/// Van Loan (2013), 2.1.4; multiplicative correction: Tang, Nabben, Vuik and Erlangga (2009), J. Sci. Comput. 39, 340.
class ReleasedFactors
{
public:
  /// Collective.
  /// @param[in] factors of the system's matrix, borrowed
  /// @param[in] condensation of that system, whose known increments are set to zero
  /// @param[in] pinned unknowns of that system, those of the condensation among them
  /// @param[in] K stiffness of the bodies, read here only [F/L]
  ReleasedFactors(Mat factors, std::shared_ptr<enforcement::Condensation> condensation, std::vector<std::int8_t> pinned,
                  Mat K);
  ~ReleasedFactors();
  ReleasedFactors(const ReleasedFactors&) = delete;
  ReleasedFactors& operator=(const ReleasedFactors&) = delete;

  /// Number of columns for a condensation, of all ranks. Collective.
  static std::int64_t num_columns(MPI_Comm comm, const enforcement::Condensation& condensation);

  /// Make the correction for a system. Collective.
  /// @param[in] system without multipliers; must live as long as `apply` is called
  /// @returns whether there is one: the columns hold no motion that nothing resists
  bool select(CondensedSystem& system);
  /// Whether the correction is that of this system.
  bool serves(const LinearSystem& system) const { return _system_id == system.id(); }
  /// z = inverse of the system times r, nearly. Collective.
  void apply(Vec r, Vec z) const;

private:
  std::vector<double> products(std::span<const double> values) const;
  std::vector<double> forces_of(std::span<const Mat> stiffness, int begin, std::span<const std::int8_t> pinned) const;
  std::vector<double> forces_of(std::span<const double> increments) const;

  MPI_Comm _comm;
  int _num_columns = 0;
  CondensedFactors _factors;
  std::vector<double> _columns; ///< X, owned: column k is [k*num_owned, (k + 1)*num_owned) [L]
  std::vector<double> _inverse; ///< of X^T A X, [i*num_columns + j]
  CondensedSystem* _system = nullptr;
  std::uint64_t _system_id = 0;           ///< no system has it
  Vec _moved = nullptr, _force = nullptr; ///< work
};
} // namespace dolfinx_impact::solve
