// SPDX-License-Identifier: MIT
#pragma once
#include "Sampler.h"
#include "material.h"

/// Element matrices and vectors. X are the geometry nodes of one cell, shape (num_geometry_nodes, gdim) [L]. Degrees of
/// freedom are node-major, the component runs fastest: u0x u0y (u0z) u1x ... All of them throw std::invalid_argument
/// for a bad material, a wrong array shape, NaN, or an inverted cell (`cell` is the number named in the message).
namespace impact_reference
{
/// Strain-displacement matrix of small strain, eps = B u, seed (3.18); shape (num_strains, gdim num_nodes) [1/L].
Matrix strain_matrix(Hypothesis hypothesis, const Sample& sample);

/// Variation of the Green-Lagrange strain, dE = B_L(u) du (Bathe ch. 6.4; Zienkiewicz & Taylor vol. 2 ch. 10) [1/L].
Matrix green_strain_matrix(Hypothesis hypothesis, const Sample& sample, const Eigen::Matrix3d& F);

/// F = I + sum u_i (x) grad N_i, with F33 = 1 in plane problems and 1 + u_r / r in axisymmetric ones.
Eigen::Matrix3d deformation_gradient(const Sample& sample, const Vector& u);

/// Adds weight B^T C B to a square matrix.
void add_BtCB(Matrix& result, double weight, const Matrix& B, const Matrix& C);

/// k_e = int B^T D B dV, seed (3.25) [F/L].
Matrix stiffness(const Sampler& sampler, const Matrix& X, const Material& material, std::int64_t cell = 0);

/// Internal force of any law, with energy and tangent.
struct Internal
{
  double energy = 0; ///< [F L]
  Vector force;      ///< int B_L^T S dV [F]
  Matrix tangent;    ///< int B_L^T C B_L dV + geometric stiffness [F/L]; empty if not asked for
};

/// @param u displacements (gdim num_nodes) [L]
/// @throws std::domain_error if the deformation turns a neo-Hookean material inside out
Internal internal(const Sampler& sampler, const Matrix& X, const Material& material, const Vector& u, bool with_tangent,
                  std::int64_t cell = 0);

/// Stress at every point of the rule: Cauchy for linear elasticity, 2nd Piola-Kirchhoff otherwise; shape
/// (num_points, num_strains) [F/L^2].
Matrix stress(const Sampler& sampler, const Matrix& X, const Material& material, const Vector& u,
              std::int64_t cell = 0);

/// Consistent mass, int rho N^T N dV (Hughes ch. 7) [M].
Matrix mass(const Sampler& sampler, const Matrix& X, const Material& material, std::int64_t cell = 0);

/// Scheme that "auto" stands for: row_sum for degree 1, hrz for simplices of degree 2 and for everything axisymmetric
/// of degree 2 (a node on the axis would get zero otherwise), nodal for tensor cells of degree 2.
/// @throws std::invalid_argument for an unknown scheme
std::string lumping_scheme(const std::string& scheme, CellType cell, int degree, bool axisymmetric);

/// Diagonal mass of one cell. Whatever the scheme, its sum per direction is the mass of the cell.
///   row_sum  row sums of the consistent mass; zero or negative at vertices of simplices of degree 2
///   hrz      diagonal of the consistent mass, scaled (Hinton, Rock, Zienkiewicz 1976)
///   nodal    quadrature at the nodes (Gauss-Lobatto: trapezium, Simpson), scaled (Cook et al. ch. 11)
class LumpedMass
{
public:
  LumpedMass(CellType cell, int degree, int geometry_degree, const Rule& rule, bool axisymmetric,
             const std::string& scheme);
  /// @returns one mass per degree of freedom (gdim num_nodes) [M]
  Vector operator()(const Matrix& X, const Material& material, std::int64_t cell = 0) const;

private:
  std::string scheme_;
  Sampler sampler_, nodal_;
};

/// int N^T f dV for a constant force per volume f (gdim) [F/L^3]; for a scalar field give one component.
Vector body_force(const Sampler& sampler, const Matrix& X, const Vector& f, std::int64_t cell = 0);

/// int k grad N_i . grad N_j dV for a scalar field, shape (num_nodes, num_nodes).
Matrix poisson(const Sampler& sampler, const Matrix& X, double k, std::int64_t cell = 0);

/// int N^T t dS over one facet for a constant traction t (gdim) [F/L^2], or a flux of one component for a scalar field;
/// vector of the whole cell.
Vector traction(const FacetSampler& sampler, const Matrix& X, int facet, const Vector& t);

/// Matrix of springs or dashpots between a facet and the ground, int N^T D N dS, for the whole cell.
/// @param k one value: along the normal n of the undeformed facet, D = k n n^T; gdim values: D = diag(k) [F/L^3]
/// @throws std::invalid_argument for another number of values, negative or NaN
Matrix foundation(const FacetSampler& sampler, const Matrix& X, int facet, const Vector& k);

/// External force of a pressure that follows the surface, f_i = - int p N_i J F^-T n0 dA0, and its tangent df/du.
/// By Nanson's formula J F^-T n0 dA0 is the area vector of the deformed facet, x_xi cross x_eta (Bonet & Wood ch. 8.5),
/// so no gradient of the cell is needed. Plane problems keep thickness 1; axisymmetric ones the current radius.
/// @param p pressure, positive pushes on the surface [F/L^2]
struct Follower
{
  Vector force;   ///< [F]
  Matrix tangent; ///< df/du, not symmetric in general [F/L]
};
Follower follower_pressure(const FacetSampler& sampler, const Matrix& X, const Vector& u, int facet, double p);

/// Matrices of the ALE frame that rotates with `spin` about `centre`: w = spin x (X - centre), A = grad N . w.
struct Ale
{
  Matrix gyroscopic; ///< G = int rho (N^T A - A^T N) dV, seed (3.56) [M/T]
  Matrix inertia;    ///< W = int rho A^T A dV, seed (3.57) [M/T^2]
  Vector load;       ///< int rho A^T w dV, the linear part of f_inertia, seed (3.57) with its errata [F]
};
/// @param spin angular velocity: one number in the plane (about z), three in space [1/T]
/// @param centre (gdim) [L]
/// @throws std::invalid_argument in an axisymmetric problem or for a wrong number of components
Ale ale(const Sampler& sampler, const Matrix& X, const Material& material, const Vector& spin, const Vector& centre,
        std::int64_t cell = 0);

/// The same with a constant w, whose flow has no acceleration: there is no load.
/// @param velocity w (gdim) [L/T]
Ale ale_translation(const Sampler& sampler, const Matrix& X, const Material& material, const Vector& velocity,
                    std::int64_t cell = 0);
} // namespace impact_reference
