// SPDX-License-Identifier: MIT
#pragma once
#include "contact.h"
#include <map>

namespace impact_reference
{
/// Derivatives of a vector of one node: degree of freedom and derivative by it, in any order, to be added up.
using Slope = std::vector<std::pair<std::int64_t, Vec<double>>>;

/// A vector of a slave node with its derivatives.
struct NodalVector
{
  Vec<double> value;
  Slope slope;
};

/// What mortar contact knows of one slave node.
struct MortarNode
{
  double area = 0;    ///< of its facets
  double share = 0;   ///< int psi_j over the whole of them
  double cover = 0;   ///< int psi_j over what is covered, with what other nodes leave to it
  bool part = false;  ///< a multiplier lives here
  NodalVector gamma;  ///< int psi_j (x_s - x_m) dA_0
  NodalVector moved;  ///< sum D_jk du_k - sum M_jl du_l since the last converged state
  NodalVector normal; ///< out of the master

  bool is_enough(double integral) const { return integral > 1e-2 * area; }
};

struct Mortar
{
  std::map<std::int64_t, MortarNode> nodes; ///< by number of the field's node
  Entries D, M;                             ///< (num_nodes, num_nodes)
  Vector force;                             ///< sum D_jk z_j on the slave, - sum M_jl z_j on the master (num_dofs) [F]
  Entries tangent;                          ///< of minus the force at constant z
};

/// Integrals and forces, all with exact derivatives: the text holds weights and dual basis, which changes the way to
/// the solution, not the solution.
/// @param rule on the interval or triangle for segments; on the facet if the master is rigid
/// @param z multipliers (num_nodes, gdim); only those of nodes that take part count [F/L^2]
Mortar mortar(const ContactPair& pair, const Rule& rule, Basis basis, const Vector& u, const ContactHistory& history,
              const Matrix& z);

namespace detail
{
/// What the functions of a facet's nodes become when nodes without multiplier leave theirs in equal parts to the
/// others. Zero if no node has one.
Eigen::MatrixXd handed_over(const Facet& facet, const Mortar& mortar);

/// Linear functions of a facet's corners at its nodes: N_j = sum A_jk phi_k; no rows for other nodes.
Eigen::MatrixXd corner_functions(const Surface& s);

/// Areas of the facets around every node and shares of the multipliers' functions.
void areas(const ContactPair& pair, Basis basis, Mortar& out);

/// Normals of the slave's nodes: mean of the facets' normals, turned round, in the planes of symmetry.
void normals(const ContactPair& pair, const Vector& u, Mortar& out);

/// All of it against an obstacle: the multiplier's integrals are constant, the gap is that of the node itself.
/// @param rule on the facet
void against_obstacle(const ContactPair& pair, const Rigid& rigid, const Rule& rule, Basis basis, const Vector& u,
                      const ContactHistory& history, const Matrix& z, Mortar& out);
} // namespace detail
} // namespace impact_reference
