// SPDX-License-Identifier: MIT
#pragma once
#include <array>
#include <cstdint>
#include <dolfinx/fem/FunctionSpace.h>
#include <mpi.h>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::operators
{
/// Bodies: the connected parts of a mesh.
struct Bodies
{
  std::vector<std::int32_t> number; ///< of the body of each owned and ghost node
  int count = 0;                    ///< of all ranks
};

/// Find the bodies of a space. They are numbered alike on all ranks. Collective.
Bodies bodies(const dolfinx::fem::FunctionSpace<double>& V);

/// Nodes of the bodies that some nodes of any rank belong to, owned and ghosts, ascending. Collective.
/// @param[in] nodes of this rank, owned or ghosts
std::vector<std::int32_t> nodes_of_bodies(const dolfinx::fem::FunctionSpace<double>& V,
                                          std::span<const std::int32_t> nodes);

/// Linearised rigid motions of all bodies, as fields over positions. Translations have length one; rotations are about
/// the body's centre and scaled by its size. Modes are numbered body by body, [body*per_body() + k].
class RigidBodyModes
{
public:
  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] u displacements of the configuration, owned and ghosts [L]
  /// @param[in] axisymmetric x is the radius: bodies may move along y alone
  RigidBodyModes(const dolfinx::fem::FunctionSpace<double>& V, std::span<const double> u, bool axisymmetric);

  int gdim() const { return _gdim; }
  MPI_Comm comm() const { return _comm; }
  int num_bodies() const { return _bodies.count; }
  /// Modes of one body.
  int per_body() const { return int(_names.size()); }
  int num_modes() const { return num_bodies() * per_body(); }
  std::int32_t num_owned() const { return _num_owned; }
  /// Of the modes of one body, in words: "move along x", "turn about z".
  const std::vector<std::string>& names() const { return _names; }
  /// Body of each owned and ghost node.
  std::span<const std::int32_t> body() const { return _bodies.number; }
  /// Present positions of owned and ghost nodes, [node*gdim + c] [L].
  std::span<const double> x() const { return _x; }
  /// Mean positions of the bodies, [body*gdim + c] [L].
  std::span<const double> centres() const { return _centres; }

  /// Displacement of a point under one mode of its body.
  /// @param[in] k mode of one body
  /// @param[in] x position, gdim entries [L]
  std::array<double, 3> displacement(std::int32_t body, int k, const double* x) const;
  /// Add the work of a unit force on the modes of all bodies to a row.
  /// @param[in] x point at which it acts, gdim entries [L]
  /// @param[in] vector gdim entries [1]
  /// @param[in] factor of the work
  /// @param[in,out] row num_modes() entries
  void add_work(std::int32_t body, const double* x, const double* vector, double factor, std::span<double> row) const;
  /// Displacements of the owned nodes under a combination of modes, [node*gdim + c] [1].
  /// @param[in] mode num_modes() coefficients
  std::vector<double> field(std::span<const double> mode) const;

private:
  MPI_Comm _comm;
  int _gdim;
  bool _axisymmetric;
  std::int32_t _num_owned;
  Bodies _bodies;
  std::vector<double> _x, _centres, _size;
  std::vector<std::string> _names;
};
} // namespace dolfinx_impact::operators
