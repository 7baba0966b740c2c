// SPDX-License-Identifier: MIT
#pragma once
#include "../operators/PointHistory.h"
#include "../state/State.h"
#include "BodyProperties.h"
#include <memory>
#include <optional>
#include <petscmat.h>
#include <petscvec.h>
#include <span>
#include <string>
#include <vector>

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
  /// Internal variables of each integral that has some. Not collective.
  virtual std::vector<std::shared_ptr<operators::PointHistory>> histories() const { return {}; }
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
