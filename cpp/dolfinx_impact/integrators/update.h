// SPDX-License-Identifier: MIT
#pragma once
#include "NodeMasses.h"
#include <cstddef>

namespace dolfinx_impact::integrators
{
/// Sums over degrees of freedom that energies are made of; see docs/explicit/energies.md. Velocities are those half a
/// step before (old) and after (new).
struct Sums
{
  double momentum = 0.0;    ///< m v_old v_new
  double speed = 0.0;       ///< m v_new v_new
  double old_speed = 0.0;   ///< m v_old v_old
  double position = 0.0;    ///< u r
  double before = 0.0;      ///< r v_old
  double after = 0.0;       ///< r v_new
  double load_before = 0.0; ///< load v_old
  double load_after = 0.0;  ///< load v_new
};

/// v_new = keep*v_old + push*a, a = (load - r)/m; u += dt*v_new.
struct Coefficients
{
  double keep = 1.0;
  double push = 0.0;
  double dt = 0.0;
};

/// One central-difference update of all degrees of freedom, with the sums energies need; r is set to zero for the next
/// step. Degrees of freedom without inverse mass keep moving as they do.
/// @param[in] n degrees of freedom
/// @param[in,out] r what equilibrium lacks: internal forces less contact and others
/// @param[in] load external forces, or null; all arrays begin with a cache line (operators::AlignedVector)
/// @param[in] inverse_mass per degree of freedom; zero where velocities are prescribed [1/M]
/// @param[in] mass per degree of freedom, for the sums [M]
/// @param[in,out] u, v displacements and velocities
Sums update(std::size_t n, double* r, const double* load, const double* inverse_mass, const double* mass,
            const Coefficients& c, double* u, double* v);
/// The same of nodes of three components that are padded to four entries; masses.known().
Sums update(std::size_t num_nodes, double* r, const double* load, const NodeMasses& masses, const Coefficients& c,
            double* u, double* v);
/// The same sums without the update, v_new being what it would be.
Sums measure(std::size_t n, const double* r, const double* load, const double* inverse_mass, const double* mass,
             const Coefficients& c, const double* u, const double* v);
} // namespace dolfinx_impact::integrators
