// SPDX-License-Identifier: MIT
#pragma once
#include "../solve/LoadSteps.h"
#include "../surface/Surface.h"
#include <array>
#include <cstdint>
#include <dolfinx/fem/Constant.h>
#include <memory>
#include <span>
#include <variant>
#include <vector>

/// Ninth stage: steady rolling in the ALE frame. The mesh stands still, and the material flows through it;
/// docs/rolling.md.
namespace dolfinx_impact::rolling
{
/// Rotation of the material about a fixed axis.
struct Spin
{
  std::array<double, 3> point{};          ///< on the axis [L]
  std::array<double, 3> axis{0., 0., 1.}; ///< unit vector; in the plane it is (0, 0, 1) or (0, 0, -1)
};

/// Translation of the material with one velocity.
struct Translation
{
};

/// Motion of the material of a body through its mesh.
struct Motion
{
  std::variant<Spin, Translation> kind;
  /// Angular velocity about the axis [1/T], or the gdim components of a velocity [L/T]. Forms of the inertia of the
  /// flow have the same constant. Load steps run through its values.
  std::shared_ptr<dolfinx::fem::Constant<double>> rate;
  std::vector<std::int32_t> nodes; ///< of the body, owned and ghosts, sorted

  const Spin* spin() const { return std::get_if<Spin>(&kind); }
  /// Velocity of the undeformed material at a place x, (gdim) each [L/T].
  void velocity(const double* x, int gdim, double* w) const;
};

/// How the material of all bodies flows through the mesh.
class Flow
{
public:
  /// @param[in] V displacement space
  /// @throws std::invalid_argument for an axis that is no unit vector, or in the plane not along z, and rates with
  /// another number of components
  Flow(std::shared_ptr<const surface::FunctionSpace> V, std::vector<Motion> motions);

  const std::vector<Motion>& motions() const { return _motions; }
  /// The first motion that is a Spin; null: nothing spins.
  const Motion* first_spin() const;
  int gdim() const { return _gdim; }
  /// Position of a node in the reference configuration, (gdim) [L].
  const double* place(std::int32_t node) const { return &_places[3 * std::size_t(node)]; }
  /// Velocity of the undeformed material at the nodes, owned and ghosts, [node*gdim + c] [L/T].
  std::vector<double> at_nodes() const;

  /// Rates, as load steps run through them: views of the present ones and of those that were reached.
  std::vector<solve::Ramp> ramps();
  /// The present rates of all motions one after the other.
  std::vector<double> rates() const;
  void set_rates(std::span<const double> rates);
  /// The rates that the last solve has reached.
  std::vector<double> reached() const;
  /// Take the present rates as those that the last solve has reached.
  void settle();

  /// Creepages besides those of the motions: the body of the first Spin moves along its axis with `lateral` times the
  /// speed of the surfaces [1], and turns with `turn` times that speed about the contact's normal that
  /// points into it [1/L].
  double lateral = 0.0, turn = 0.0;

private:
  int _gdim;
  std::vector<double> _places;
  std::vector<Motion> _motions;
  std::vector<std::vector<double>> _reached;
};
} // namespace dolfinx_impact::rolling
