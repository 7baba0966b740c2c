// SPDX-License-Identifier: MIT
#pragma once
#include "material.h"

/// J2 plasticity at a point (Simo & Hughes 1998 ch. 2, 3; de Souza Neto, Peric & Owen 2008 ch. 6, 7, 14).
///
/// Yield function f = sqrt(3/2) |dev sigma - beta| - Y(a), associated flow d eps_p = da sqrt(3/2) n with
/// n = (dev sigma - beta) / |dev sigma - beta|, so that a is the equivalent plastic strain. Back stress of Armstrong
/// and Frederick, d beta = 2/3 C d eps_p - gamma beta da; gamma = 0 is Prager's linear law. Backward Euler.
namespace impact_reference
{
using Tensor = Eigen::Matrix3d;
/// Derivative of a tensor by a tensor: entry (3 i + j, 3 k + l) is dA_ij / dB_kl.
using Tensor4 = Eigen::Matrix<double, 9, 9>;
/// A tensor's components row by row: A_ij at 3 i + j.
using Components = Eigen::Matrix<double, 9, 1>;
Components components(const Tensor& A);

/// Strain that the law works with.
enum class PlasticStrain
{
  small,
  simo,  ///< finite: Simo's multiplicative law (Simo & Hughes Box 9.1)
  hencky ///< finite: logarithmic strain and exponential map (de Souza Neto et al. ch. 14)
};

/// Strain of a name: "small", "simo", "hencky".
/// @throws std::invalid_argument for an unknown name
PlasticStrain plastic_strain(const std::string& name);

struct J2Parameters
{
  double E = 0, nu = 0;         ///< elastic constants [F/L^2], [1]
  double yield_stress = 0;      ///< Y0 [F/L^2]
  double hardening = 0;         ///< H, slope of the linear part of Y(a) [F/L^2]
  double saturation_stress = 0; ///< Yinf of Voce's part (Yinf - Y0)(1 - exp(-delta a)); counts if delta > 0 [F/L^2]
  double saturation_rate = 0;   ///< delta [1]
  /// Y(a) as a table, linear between its points and constant beyond the last; takes the place of Y0, H and Voce's part.
  std::vector<double> table_strain, table_stress; ///< [1], [F/L^2]
  double kinematic = 0;                           ///< C [F/L^2]
  double recall = 0;                              ///< gamma [1]
};

/// @throws std::invalid_argument naming the value and the remedy
void check(const J2Parameters& parameters);

/// Internal variables of a point.
struct J2History
{
  /// Small strain: plastic strain, zero at first. Finite strain: inverse of the plastic right Cauchy-Green tensor,
  /// C_p^-1 = F^-1 b_e F^-T, the identity at first (b_e is J^(2/3) be_bar in Simo's law).
  Tensor plastic = Tensor::Zero();
  double equivalent = 0;               ///< equivalent plastic strain a [1]
  Tensor back_stress = Tensor::Zero(); ///< beta; in finite strain turned back by the rotation of F [F/L^2]
  Tensor stress = Tensor::Zero();      ///< Cauchy, or Kirchhoff turned back likewise; only `work` reads it [F/L^2]
  double work = 0;                     ///< int sigma : d eps_p per reference volume, trapezoidal rule [F/L^2]
  double thickness = 1;                ///< in plane stress of finite strain: stretch across the plane, F_33 [1]
};

/// Answer to a strain.
struct J2Answer
{
  Tensor stress = Tensor::Zero();    ///< Cauchy in small strain, 1st Piola-Kirchhoff in finite strain [F/L^2]
  Tensor4 tangent = Tensor4::Zero(); ///< its derivative by the strain, or by F; zero if not asked for [F/L^2]
  J2History history;                 ///< at the end of the step
  double energy = 0;                 ///< elastic, per reference volume [F/L^2]
  /// Of the step: Y da + 3 gamma/(2 C) beta : beta da, what neither elasticity nor the back stress stores [F/L^2].
  double dissipation = 0;
};

/// The law. Answers depend on the strain at the end of the step and the history at its start, which stays as it is.
class J2
{
public:
  /// @throws std::invalid_argument see check
  explicit J2(const J2Parameters& parameters);

  const J2Parameters& parameters() const { return parameters_; }
  /// History of a point that never yielded.
  static J2History virgin(PlasticStrain strain);

  double yield_stress(double a) const;    ///< Y(a) [F/L^2]
  double hardening_slope(double a) const; ///< Y'(a), of the right-hand piece at the points of a table [F/L^2]

  /// @param strain eps, symmetric
  /// @throws std::domain_error if the material has softened to nothing
  J2Answer small_strain(const Tensor& strain, const J2History& history, bool with_tangent = true) const;

  /// Plane stress: strain_33 follows from stress_33 = 0 and is not read, strains 13 and 23 must be zero. The tangent is
  /// condensed: its rows and columns of 33 are zero.
  /// @throws std::domain_error as above, or if no strain_33 is found
  J2Answer plane_stress(const Tensor& strain, const J2History& history, bool with_tangent = true) const;

  /// Hencky's law tau = K tr(eps_e) I + 2 G dev(eps_e) with eps_e = ln(b_e)/2, and the exponential map (de Souza Neto
  /// et al. ch. 14.4): the return of small strain in logarithmic strains. The back stress turns with the rotation of F.
  /// @param F deformation gradient
  /// @throws std::domain_error if det F <= 0 or the material has softened to nothing
  J2Answer hencky(const Tensor& F, const J2History& history, bool with_tangent = true) const;

  /// Simo's law: tau = K/2 (J^2 - 1) I + s, s = mu dev(be_bar), radial return of s with the modulus mu tr(be_bar_tr)/3
  /// (Simo & Hughes Box 9.1). Then be_bar = s/mu + i I with det(be_bar) = 1; the box keeps the trace of the trial
  /// instead, whose elastic energy K/2 ((J^2 - 1)/2 - ln J) + mu/2 (tr be_bar - 3) would grow by all plastic work.
  /// The back stress turns with the rotation of F (Green & Naghdi's rate; Johnson & Bammann 1984).
  /// @param F deformation gradient
  /// @throws std::domain_error if det F <= 0 or the material has softened to nothing
  J2Answer simo(const Tensor& F, const J2History& history, bool with_tangent = true) const;

  /// Plane stress of finite strain: F_33 follows from P_33 = 0 and is not read, F_13, F_23, F_31 and F_32 must be zero.
  /// The tangent is condensed as above.
  /// @param strain simo or hencky
  /// @throws std::domain_error as above, or if no F_33 is found
  J2Answer finite_plane_stress(PlasticStrain strain, const Tensor& F, const J2History& history,
                               bool with_tangent = true) const;

  /// One of the above. `gradient`: the strain, or F.
  J2Answer answer(PlasticStrain strain, Hypothesis hypothesis, const Tensor& gradient, const J2History& history,
                  bool with_tangent = true) const;

private:
  J2Parameters parameters_;
  double bulk_, shear_;
};
} // namespace impact_reference
