// SPDX-License-Identifier: MIT
#pragma once
#include "../state/State.h"
#include <optional>
#include <petscmat.h>
#include <petscvec.h>
#include <span>
#include <string>

namespace dolfinx_impact::solve
{
/// What is known of bodies; see Body.
struct BodyProperties
{
  bool linear = false, keeps_tangent = false, symmetric = true, inelastic = false, has_inertia = false,
       has_springs = false, rounds_positions = false;
};

/// The bodies of a problem: residual of internal, external and inertia forces, and its derivative. Contact forces are
/// not in it. All calls are collective but those of properties.
class Body
{
public:
  virtual ~Body() = default;

  /// Internal minus external forces at the present displacement; owned entries are complete. Borrowed until the next
  /// call [F].
  virtual Vec residual() = 0;
  /// Derivative of the residual at the present displacement, borrowed until the next call [F/L].
  virtual Mat tangent() = 0;
  /// Why the last residual could not be computed; empty if it could.
  virtual std::string fault() { return ""; }
  /// Take the state of the last residual as the one that the next step begins from.
  virtual void accept_step() {}
  /// Internal variables that the next step begins from, as views: copied, the bodies can be brought back to them.
  virtual state::State state() { return state::State("bodies"); }
  /// Energy stored in the bodies and their foundations at the last residual, of all ranks; nothing: it is not known
  /// [F L].
  virtual std::optional<double> stored_energy() { return {}; }

  /// Whether the tangent does not change with the displacement, so that one serves an increment.
  virtual bool linear() const { return false; }
  /// Whether it does not change with time either, so that one serves all steps.
  virtual bool keeps_tangent() const { return linear(); }
  virtual bool symmetric() const { return true; }
  /// Whether there are internal variables: tangents of two iterations may be far apart.
  virtual bool inelastic() const { return false; }
  /// Whether inertia holds the bodies against rigid motions.
  virtual bool has_inertia() const { return false; }
  /// Whether springs to the ground may hold the bodies.
  virtual bool has_springs() const { return false; }
  /// Whether round-off of positions enters the forces, as with finite strain.
  virtual bool rounds_positions() const { return false; }
  /// Displacements that internal forces are measured from, owned; empty: zero [L].
  virtual std::span<const double> origin() const { return {}; }
};
} // namespace dolfinx_impact::solve
