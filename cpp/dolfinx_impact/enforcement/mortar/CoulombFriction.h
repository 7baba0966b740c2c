// SPDX-License-Identifier: MIT
#pragma once
#include "active_set.h"
#include <array>

namespace dolfinx_impact::enforcement
{
/// Friction tractions of a contact by multipliers that no equilibrium of a node tells, and what Newton's method sees of
/// tractions that change with the slip; docs/contact.md, "Where components are prescribed".
///
/// The tangent plane of a node has three kinds of directions. Along free ones the node's equilibrium gives the
/// traction. Along prescribed ones there is no equation of the node: `imposed` is the traction of nodes that stick,
/// raised from one linear solution to the next until nothing slips (driven directions), or kept from the last converged
/// state where nothing can slip, because the relative motion is prescribed to be zero (locked directions).
/// Vectors are [i*gdim + c], projectors [(i*gdim + a)*gdim + b].
class CoulombFriction
{
public:
  CoulombFriction(int gdim, std::size_t num_nodes);

  int gdim() const { return _gdim; }
  std::size_t num_nodes() const { return _num; }
  /// Imposed tractions [F/L^2].
  std::vector<double> imposed;

  /// A new state to linearise about: prescribed directions of usable nodes; imposed tractions follow the surface;
  /// springs are forgotten.
  /// @param[in] usable nodes that carry a multiplier and may be moved along the normal
  /// @param[in] geometry normal, fixed and frames are used
  /// @param[in] locked components along which the relative motion is prescribed to be zero, [i*gdim + c]
  void update_directions(std::span<const std::int8_t> usable, const NodalGeometry& geometry,
                         std::span<const std::int8_t> locked);
  /// Directions along which another contact of the same node holds it: nothing slips there, and equilibrium does not
  /// tell the friction, which is taken for none.
  /// @param[in] projectors of all nodes; empty: there are none
  void set_edges(std::vector<double> projectors);
  /// Projectors on locked directions.
  const std::vector<double>& locked() const { return _locked; }
  /// Projectors on locked and driven directions together.
  std::vector<double> prescribed() const;

  /// Imposed tractions after changes of the active set and of multipliers: driven nodes that come to rest start from
  /// the traction they had, locked directions keep that of the last converged state as far as the bound leaves room.
  /// @param[in] was_stuck nodes that stuck before the change
  /// @param[in] traction_n friction tractions of the last converged state [F/L^2]
  /// @returns mask of nodes whose kept traction is another one than in the last solution
  std::vector<std::int8_t> update_imposed(const NodalMultipliers& now, std::span<const std::int8_t> was_stuck,
                                          std::span<const double> traction_n);

  /// Springs of a linear problem, in parallel to the constraints.
  struct Springs
  {
    std::vector<std::int32_t> rows; ///< numbers of the nodes that have a spring
    std::vector<double> blocks;     ///< of these nodes, [(k*gdim + a)*gdim + b] [F/L]
    std::vector<double> traction;   ///< of all nodes: to be taken from the right-hand side [F/L^2]
  };
  /// Tractions that change with the slip. In space the traction of a node that slips turns with the slip: across its
  /// direction, friction bound over slip (return mapping t = bound trial / |trial|, linearised). Of a node that has
  /// closed in this step, pressure over the gap it has closed. Along driven directions of a node that sticks, many
  /// times the bodies' stiffness.
  /// @param[in] geometry normal, slip, weight and cover are used
  /// @param[in] slave_stiffness, master_stiffness of the bodies at the nodes and opposite to them [F/L]
  Springs update_springs(const NodalMultipliers& now, const NodalGeometry& geometry,
                         std::span<const double> slave_stiffness, std::span<const double> master_stiffness);
  /// Has the present linear problem springs (update_springs since update_directions)?
  bool has_springs() const { return _has_springs; }

  /// After a linear solution: what still slips along driven directions raises the imposed traction.
  void raise_imposed(const NodalMultipliers& now);
  /// Tractions that neither the node's equilibrium nor its pressure tells, after a linear solution: imposed ones and
  /// those of springs [F/L^2].
  std::vector<double> known_tractions(const NodalMultipliers& now) const;

private:
  int _gdim;
  std::size_t _num;
  std::array<double, 9> without_slip(std::size_t i) const;

  std::vector<double> _locked, _driven; ///< projectors
  std::vector<double> _edges;           ///< projectors, or empty
  std::vector<std::int8_t> _is_driven;  ///< nodes with driven directions
  bool _has_springs = false;
  std::vector<double> _spring, _driving; ///< stiffness per area of slipping and driven nodes [F/L^3]
  std::vector<double> _slack;            ///< slip at which springs are slack [L]
};
} // namespace dolfinx_impact::enforcement
