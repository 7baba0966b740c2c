// SPDX-License-Identifier: MIT
#pragma once
#include "../../gap/MortarIntegrals.h"
#include "../../operators/CooMatrix.h"
#include "../../operators/RigidBodyModes.h"
#include "Constraints.h"
#include "TieOptions.h"
#include <memory>
#include <span>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// The conditions of a tie, docs/tie.md: for a slave node j and a direction t_d
///
///     C_jd u = w_jd t_d . (u_j - sum_l P_jdl u_l) = 0,   P = D^-1 M, w the diagonal of D.
///
/// D and M are the mortar integrals of the reference configuration, made once. A direction is an axis, or the normal
/// alone. Components that are prescribed at the slave node, or that another tie holds there, have no condition; the
/// multiplier's function goes to the neighbours (gap::mortar), so that constant tractions stay in the space. Arrays by
/// node are [i*gdim + d], i over the nodes.
class TieConditions
{
public:
  /// Collective.
  /// @param[in] slave, master this rank's facets (make_surface)
  /// @param[in] fixed mask of prescribed degrees of freedom, owned and ghosts
  /// @throws std::invalid_argument on all ranks: slave nodes without a master, unless `partial` is set
  TieConditions(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave, surface::Facets master,
                const TieOptions& options, std::vector<std::int8_t> fixed);

  /// Leave out components that other ties hold, and make the conditions anew. Collective.
  /// @param[in] taken mask of owned degrees of freedom
  void leave_out(std::span<const std::int8_t> taken);

  MPI_Comm comm() const { return _space->mesh()->comm(); }
  int gdim() const { return _slave.gdim; }
  const surface::FunctionSpace& space() const { return *_space; }
  const TieOptions& options() const { return _options; }
  const surface::Facets& slave() const { return _slave; }
  const surface::Facets& master() const { return _master; }
  /// Diagonal of the box around the bodies [L].
  double size() const { return _size; }
  /// Owned slave nodes that face the master.
  std::span<const std::int32_t> nodes() const { return _nodes; }
  /// Their global numbers.
  std::span<const std::int64_t> numbers() const { return _numbers; }
  std::size_t num_nodes() const { return _nodes.size(); }
  /// Slave nodes of all ranks without a master, left free.
  long long num_free() const { return _num_free; }
  /// Integrals of the nodes' functions over the part that faces the master [L, L^2].
  const std::vector<double>& area() const { return _area; }
  /// Unit normals out of the master in the reference configuration, [i*gdim + c].
  const std::vector<double>& normal() const { return _normal; }
  /// Positions in the reference configuration, [i*gdim + c] [L].
  const std::vector<double>& points() const { return _points; }
  /// Distances of slave from master along the directions in the reference configuration, zero without a condition [L].
  const std::vector<double>& offset() const { return _offset; }

  /// Nodes with a condition, their frames and rows of P; `known` is zero.
  const Constraints& rows() const { return _rows; }
  /// Of each of these nodes and directions, [k*gdim + d]: w, and the force on the slave per multiplier [L, L^2].
  const std::vector<double>& weight() const { return _weight; }
  const std::vector<double>& cover() const { return _cover; }
  /// The directions t_d of these nodes, [(k*gdim + a)*gdim + d]; and their lengths along q_d (Constraints).
  const std::vector<double>& directions() const { return _directions; }
  const std::vector<double>& length() const { return _length; }
  /// C: rows are the degrees of freedom of slave nodes. Borrowed.
  Mat matrix() const { return _matrix.matrix(); }
  /// C u over the weights, zero without a condition, [i*gdim + d] [L]. Collective.
  /// @param[in] u owned values
  std::vector<double> jump(std::span<const double> u) const;
  /// Nodal forces C^T z on both surfaces, owned [F]. Collective.
  /// @param[in] z multipliers, [i*gdim + d] [F/L^2]
  std::vector<double> forces(std::span<const double> z) const;
  /// Tractions on the slave that multipliers stand for, [i*gdim + c] [F/L^2].
  std::vector<double> traction(std::span<const double> z) const;
  /// Products of the conditions applied to rigid body modes, see StaticContact. Collective.
  std::vector<double> rigid_body_products(const operators::RigidBodyModes& modes) const;
  /// Slave and master nodes of this rank, owned and ghosts: marks. Collective.
  std::vector<std::int8_t> marks(bool slave, bool master) const;

private:
  void find_nodes();
  std::vector<std::vector<std::int8_t>> carriers(std::span<const std::int8_t> taken) const;

  std::shared_ptr<const surface::FunctionSpace> _space;
  surface::Facets _slave, _master;
  TieOptions _options;
  std::vector<std::int8_t> _fixed;
  double _size;
  std::unique_ptr<gap::MortarIntegrals> _integrals;
  std::vector<std::int32_t> _places; ///< of the nodes among those that may have a multiplier
  std::vector<std::int32_t> _nodes;
  std::vector<std::int64_t> _numbers;
  long long _num_free = 0;
  std::vector<double> _area, _normal, _points, _offset;
  Constraints _rows;
  std::vector<double> _weight, _cover, _directions, _length;
  operators::CooMatrix _matrix;
};
} // namespace dolfinx_impact::enforcement
