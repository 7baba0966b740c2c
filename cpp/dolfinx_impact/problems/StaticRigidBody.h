// SPDX-License-Identifier: MIT
#pragma once
#include "../solve/RigidEquations.h"
#include <array>
#include <span>

namespace dolfinx_impact::problems
{
/// A rigid body of a static problem, which loads and contacts move: its centre by a displacement, and about it by a
/// rotation vector of the increment, of which some components are zero.
class StaticRigidBody : public solve::RigidEquations
{
public:
  /// @param[in] fixed components that stay: x, y, z, rx, ry, rz
  /// @param[in] force, torque views of the external force [F] and of the torque about the centre [F L], three
  /// components each, at the present part of the load step
  /// @param[in] centre before the displacement [L]
  /// @param[in] length by which angles become lengths, and torques forces [L]
  /// @throws std::invalid_argument unless a load has three components and the length is positive
  StaticRigidBody(const std::array<bool, 6>& fixed, std::span<const double> force, std::span<const double> torque,
                  const gap::Vector3& centre, double length);

  /// An increment begins where the body is.
  void begin(const solve::RigidPlace& start) { _start = start; }

  std::size_t size() const override { return _free.size(); }
  std::string component(std::size_t unknown) const override;
  std::vector<double> first_guess() const override { return std::vector<double>(_free.size(), 0.0); }
  solve::RigidPlace place(std::span<const double> q) const override;
  gap::Vector3 centre() const override { return _centre; }
  solve::RigidBalance balance(std::span<const double> q, const gap::Vector3& force,
                              const gap::Vector3& torque) const override;
  bool needs_contact() const override { return true; }
  bool turns() const override { return !_free.empty() && _free.back() >= 3; }

private:
  std::vector<int> _free; ///< components
  std::span<const double> _force, _torque;
  gap::Vector3 _centre;
  double _length;
  solve::RigidPlace _start;
};
} // namespace dolfinx_impact::problems
