// SPDX-License-Identifier: MIT
#pragma once
#include "../state/State.h"
#include "BodyProperties.h"
#include <optional>
#include <petscmat.h>
#include <petscvec.h>
#include <span>
#include <string>

namespace dolfinx_impact::solve
{
/// The bodies of a problem: residual of internal, external and inertia forces, and its derivative. Contact forces are
/// not in it. All calls are collective but those of properties.
class Body
{
public:
  explicit Body(BodyProperties properties) : _properties(properties) {}
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
  /// The same as a checkpoint holds them, values of their own by owned cell: those of other ranks, too, can be gone on
  /// from. Without internal variables it has no fields.
  virtual state::State saved_state() { return state::State("material"); }
  /// Continue from what `saved_state` of the same bodies has returned.
  virtual void resume(const state::State&) {}
  /// Energy stored in the bodies and their foundations at the last residual, of all ranks; nothing: it is not known
  /// [F L].
  virtual std::optional<double> stored_energy() { return {}; }

  const BodyProperties& properties() const { return _properties; }
  /// Displacements that internal forces are measured from, owned; empty: zero [L].
  virtual std::span<const double> origin() const { return {}; }

private:
  BodyProperties _properties;
};
} // namespace dolfinx_impact::solve
