#pragma once

/// Sixth stage: gaps turned into forces.
namespace impact::enforcement
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

FrictionResult evaluate(const Friction& point);

/// Exact derivative of the traction, as a linear map of `num` variables.
/// @param[in] d_pressure num entries
/// @param[in] d_normal,d_increment gdim x num, row-major
/// @param[out] d_traction gdim x num, row-major
void linearise(const Friction& point, const FrictionResult& result, int num, const double* d_pressure,
               const double* d_normal, const double* d_increment, double* d_traction);
} // namespace impact::enforcement
