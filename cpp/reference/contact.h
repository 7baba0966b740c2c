// SPDX-License-Identifier: MIT
#pragma once
#include "contact_projection.h"
#include "contact_rigid.h"
#include <Eigen/SparseCore>
#include <limits>
#include <optional>

/// Contact as docs/contact.md states it, with brute-force search and tangents by automatic differentiation.
namespace impact_reference
{
/// What both discretisations start from. Forces act on the right-hand side, tractions on the slave.
struct ContactPair
{
  const Model& model;
  Surface slave;
  Surface master;                    ///< no facets if the master is rigid
  std::optional<Rigid> rigid;        ///< the obstacle
  double friction = 0;               ///< Coulomb's coefficient [1]
  std::vector<bool> prescribed = {}; ///< (num_dofs) true where the displacement is prescribed
  double search_distance = std::numeric_limits<double>::infinity(); ///< [L]
  Vector gap_shift = {}; ///< added to the gaps of the slave's points, (num_points) or empty [L]

  double size() const; ///< longest side of the box around the model [L]
};

using Flags = Eigen::Matrix<std::int64_t, Eigen::Dynamic, 1>;

/// Converged state friction refers to.
struct ContactHistory
{
  Vector u;         ///< (num_dofs) [L]
  RigidPlace place; ///< of the rigid obstacle
  Matrix traction;  ///< tangential, per slave point (num_points, gdim) [F/L^2]
  Matrix slip;      ///< sum of the steps, per slave point (num_points, gdim) [L]
  Flags touched;    ///< per slave point: 1 where it was closed
};

enum class ContactStatus : std::int64_t
{
  open,
  stick,
  slip
};

/// Functions psi of the multipliers: dual to the shape functions, these themselves, or linear ones of the corners.
enum class Basis
{
  dual,
  standard,
  linear
};

using Entries = std::vector<Eigen::Triplet<double>>;
/// Sum of entries by rows.
Csr csr(const Entries& entries, std::int64_t size);

/// Quantities at the quadrature points of all slave facets, facet by facet.
struct ContactPoints
{
  Vector gap;                      ///< +infinity without master [L]
  Matrix normal;                   ///< out of the master; zero without master (num_points, gdim)
  std::vector<std::int64_t> facet; ///< of the master, or -1
  Matrix xi;                       ///< reference coordinates on the master (num_points, gdim - 1)
  Matrix position;                 ///< of the slave points (num_points, gdim) [L]
  Vector weight;                   ///< reference area, 2 pi R in it if axisymmetric
  Vector pressure;                 ///< [F/L^2]
  Matrix traction;                 ///< tangential (num_points, gdim) [F/L^2]
  std::vector<ContactStatus> status;
  Flags beside; ///< 1 beside the master's rim, where gaps are not shifted
};

struct Penalty
{
  Vector force;    ///< (num_dofs) [F]
  Entries tangent; ///< of minus the force [F/L]
  ContactPoints points;
  ContactHistory history; ///< if this state has converged
};

/// Gauss point to surface.
/// @param rule on the facet
/// @param chi, chi_t pressure per penetration, traction per slip [F/L^3]
/// @param multiplier per slave point, or empty [F/L^2]
Penalty penalty(const ContactPair& pair, const Rule& rule, const Vector& u, double chi, double chi_t,
                const ContactHistory& history, const Vector& multiplier);

/// A state without slip or traction.
ContactHistory no_history(const ContactPair& pair, std::int64_t num_points);

/// Degrees of freedom of a facet.
std::vector<std::int64_t> facet_dofs(const Surface& surface, const Facet& facet);
} // namespace impact_reference
