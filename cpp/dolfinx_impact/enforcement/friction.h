// SPDX-License-Identifier: MIT
#pragma once
#include <cmath>

/// Sixth stage: gaps turned into forces.
namespace dolfinx_impact::enforcement
{
/// Coulomb's law at a point with a tangential stiffness, over one step (docs/contact.md, seed (3.43)).
struct Friction
{
  int gdim = 3;
  double pressure = 0.0;    ///< [F/L^2]
  double coefficient = 0.0; ///< [1]
  double stiffness = 0.0;   ///< chi_T [F/L^3]
  const double* normal = nullptr;
  const double* last = nullptr;      ///< tangential traction of the last converged state [F/L^2]
  const double* increment = nullptr; ///< displacement of slave against master since then [L]
};

struct FrictionResult
{
  double traction[3] = {0.0, 0.0, 0.0}; ///< tangential, acts on the slave [F/L^2]
  double slip[3] = {0.0, 0.0, 0.0};     ///< what is added to the slip: the increment less its elastic part [L]
  double trial[3] = {0.0, 0.0, 0.0};    ///< traction if it sticks [F/L^2]
  bool slips = false;
};

/// Coulomb's law with a tangential stiffness, over one step (docs/contact.md, seed (3.43)), for forces or tractions.
/// @param[in] n unit normal
/// @param[in] k,per_k tangential stiffness and its reciprocal [F/L] or [F/L^3]
/// @param[in] limit of the force [F] or [F/L^2]
/// @param[in,out] t tangential force on the slave, of the last step and of this one
/// @param[in,out] s in: motion of slave against master in the step; out: what is added to the slip [L]
/// @param[out] trial the force if it sticks
/// @returns does it slip?
template <int D>
bool coulomb(const double* n, double k, double per_k, double limit, double* t, double* s, double* trial)
{
  double along = 0.0, turn = 0.0, size = 0.0, left = 0.0;
#pragma GCC unroll 4
  for (int c = 0; c < D; ++c)
  {
    along += n[c] * s[c];
    turn += n[c] * t[c];
    size += t[c] * t[c];
  }
  double turned[D];
#pragma GCC unroll 4
  for (int c = 0; c < D; ++c)
  {
    s[c] -= along * n[c];
    turned[c] = t[c] - turn * n[c];
    left += turned[c] * turned[c];
  }
  const double scale = left > 0.0 ? std::sqrt(size / left) : 0.0; // the force keeps its size when the normal turns
  double squared = 0.0;
#pragma GCC unroll 4
  for (int c = 0; c < D; ++c)
  {
    turned[c] *= scale;
    t[c] = trial[c] = turned[c] - k * s[c];
    squared += t[c] * t[c];
  }
  // A node that slipped in the last step begins this one at its limit: round-off must not make it slip on.
  const bool slips = squared > limit * limit * (1.0 + 2e-12);
  const double factor = slips ? limit / std::sqrt(squared) : 1.0;
#pragma GCC unroll 4
  for (int c = 0; c < D; ++c)
  {
    t[c] *= factor;
    s[c] = slips ? s[c] + (t[c] - turned[c]) * per_k : 0.0;
  }
  return slips;
}

FrictionResult evaluate(const Friction& point);

/// Exact derivative of the traction, as a linear map of `num` variables.
/// @param[in] d_pressure num entries
/// @param[in] d_normal,d_increment gdim x num, row-major
/// @param[out] d_traction gdim x num, row-major
void linearise(const Friction& point, const FrictionResult& result, int num, const double* d_pressure,
               const double* d_normal, const double* d_increment, double* d_traction);
} // namespace dolfinx_impact::enforcement
