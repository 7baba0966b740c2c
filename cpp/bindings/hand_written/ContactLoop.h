// SPDX-License-Identifier: MIT
#pragma once
#include <cstddef>
#include <cstdint>

namespace dolfinx_impact::hand_written
{
/// A slave node over one quadrilateral of the master. Like CellLoop.h, the file takes no templates of the standard
/// library.
struct alignas(64) SlaveNode
{
  double X[3] = {};             ///< position before deformation [L]
  double xi[2] = {0.5, 0.5};    ///< reference coordinates of its projection
  double tangential[3] = {};    ///< force of friction [F]
  std::int32_t node = 0;        ///< its number
  std::int32_t corners[4] = {}; ///< of its facet, among the nodes of the master
  double gap = 0.0;             ///< [L]
  double pressed = 0.0;         ///< normal force [F]
  double slip[3] = {};          ///< [L]
};

/// A node of the master.
struct alignas(64) FacetNode
{
  double x[4] = {};  ///< position; the last one is padding [L]
  double du[4] = {}; ///< increment [L]
};

/// Arrays by node have three numbers a node.
struct ContactArrays
{
  SlaveNode* slaves = nullptr;
  std::size_t num_slaves = 0; ///< a multiple of four
  FacetNode* masters = nullptr;
  double* sums = nullptr; ///< forces on the master's nodes, four numbers each, aligned; zero between calls [F]
  const std::int32_t* numbers = nullptr; ///< of the master's nodes
  const double* X = nullptr;             ///< their positions before deformation, three numbers each [L]
  std::size_t num_masters = 0;
  const double* u = nullptr;  ///< displacements by node [L]
  const double* du = nullptr; ///< their increments by node [L]
  double* f = nullptr;        ///< forces by node are added [F]
  double stiffness = 0.0;     ///< of each slave node [F/L]
  double friction = 0.0;      ///< coefficient [1]
};

/// Adds the forces of penalty contact, four slave nodes at a time (AVX2): projections by two steps of Newton's method,
/// springs, Coulomb friction. No search, no change of facets, no energies, no correction of moments.
void add_contact_forces(const ContactArrays& arrays);
} // namespace dolfinx_impact::hand_written
