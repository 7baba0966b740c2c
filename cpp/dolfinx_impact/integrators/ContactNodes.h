// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/node_to_surface/NodalContact.h"
#include "NodalFields.h"
#include <memory>
#include <span>
#include <vector>

namespace dolfinx_impact::integrators
{
/// The nodes that contacts act on, numbered one after the other, and their values: what contacts do to them in every
/// step stays in the cache.
class ContactNodes
{
public:
  /// Number the nodes that contacts need, owned ones first. Contact forces of the last step go on. Collective.
  /// @param[in] nodes of the fields' Halo that contacts on this rank need, in any order, perhaps several times
  /// @param[in] kinematic is there kinematic contact? Its corrections reach all ranks that have a node as a ghost
  void assign_numbers(NodalFields& fields, std::vector<std::int32_t> nodes, bool kinematic);
  /// Numbers by node of the fields' Halo, -1: none; valid until the next `number`.
  std::span<const std::int32_t> numbers() const { return _numbers; }
  /// Masses by number [M].
  const std::vector<double>& mass() const { return _mass; }
  /// Halo of these nodes alone; null before they are numbered.
  Halo* halo() const { return _halo.get(); }
  std::size_t size() const { return _nodes.size(); }

  /// Take displacements and increments of the last step from the fields, velocities too for kinematic contact.
  /// @param[in] dt step that led here [T]
  /// @param[in] springs sum up the work of the springs' forces of the last time level, and set them to zero
  /// @returns this work in the step, of this rank [F L]
  double gather(const NodalFields& fields, double dt, bool springs);
  /// Give corrected displacements back to the fields. Their increments, velocities and range follow once `v` of owned
  /// nodes is corrected as well: `finish_correction`.
  void put_displacements(NodalFields& fields) const;
  /// Give corrected velocities of owned nodes to the fields, and take those of ghosts. What a step begins with is then
  /// known here: until the next update of the fields, neither `gather` nor `keep` need to ask them.
  /// @param[in] dt step [T]
  void finish_correction(NodalFields& fields, double dt);
  /// Has `finish_correction` been called since the nodes were numbered, and no update since?
  bool corrected() const { return _corrected; }
  /// Least and largest increments of all nodes.
  const enforcement::IncrementRange& range() const { return _range; }
  /// Add the springs' forces to the residual.
  /// @returns sums over this rank's nodes
  struct Products
  {
    double position = 0.0; ///< u . force [F L]
    double work = 0.0;     ///< du . force [F L]
  };
  Products add_springs(NodalFields& fields) const;
  /// Keep velocities and residuals that an update is about to change, for kinematic contact. The update is expected.
  void keep(const NodalFields& fields);

  /// Contact forces of the last step on owned degrees of freedom of the fields, ghosts' contributions included.
  /// Collective.
  struct Forces
  {
    std::vector<double> springs, kinematic; ///< [F]
  };
  Forces forces(const NodalFields& fields);
  /// The same forces, for nodes that are numbered later.
  void restore(Forces forces) { _kept = std::move(forces); }
  void reset();
  Halo::Traffic traffic() const;

  /// By number*bs + component: displacement, its increment in the step, inverse mass, springs' and kinematic forces.
  std::vector<double> u, du, inverse, springs, kinematic;
  /// For kinematic contact: velocity after the update, before it; residual before it; increment of the step before.
  std::vector<double> v, v_before, r_before, du_before;
  /// Node of the fields' Halo, by number.
  std::span<const std::int32_t> nodes() const { return _nodes; }

private:
  template <int D, int stride, bool kinematic>
  double gather_all(const NodalFields& fields, double dt, bool springs);
  template <int D, int stride>
  void finish_all(NodalFields& fields, double dt);

  std::vector<std::int32_t> _nodes, _numbers;
  std::vector<double> _mass;
  std::unique_ptr<Halo> _halo;
  bool _kinematic = false, _corrected = false;
  enforcement::IncrementRange _range;
  Forces _kept; ///< until nodes are numbered
  Halo::Traffic _traffic;
};
} // namespace dolfinx_impact::integrators
