// SPDX-License-Identifier: MIT
#pragma once
#include "../../solve/Body.h"
#include "Inertia.h"
#include "StepMotion.h"
#include "VelocityForce.h"
#include <dolfinx/fem/Function.h>
#include <memory>
#include <optional>

namespace dolfinx_impact::integrators
{
/// Bodies with inertia and damping over one implicit step, as Newton's method sees them: equilibrium
/// M a_1 + C v_1 + F(u_1) = 0 at its end as a residual in u_1. They are linear if the tangent is the same in all steps
/// of one size.
class MovingBody : public solve::Body
{
public:
  typedef dolfinx::fem::Function<double> Function;

  /// @param[in] body bodies without inertia
  /// @param[in] displacement the problem's unknown [L]
  /// @param[in] velocity function that forces of damping read; it is overwritten [L/T]
  /// @param[in] alpha factor of mass-proportional damping [1/T]
  /// @param[in] damping other forces that depend on the velocity; null: there are none
  MovingBody(std::shared_ptr<solve::Body> body, std::shared_ptr<Function> displacement,
             std::shared_ptr<Function> velocity, std::shared_ptr<const Inertia> inertia, double alpha = 0.0,
             std::shared_ptr<VelocityForce> damping = nullptr);
  ~MovingBody() override;
  MovingBody(const MovingBody&) = delete;
  MovingBody& operator=(const MovingBody&) = delete;

  /// Begin a step; the displacement has its start value, ghosts included. Collective.
  void begin_step(StepMotion step);
  /// Motion at the end of the step, with the present displacement.
  Motion end_of_step() const;
  /// Forces of damping C v, owned; the velocity function is set [F]. Collective.
  std::vector<double> damping_forces(const Motion& motion);

  Vec residual() override;
  Mat tangent() override;
  std::string fault() override { return _body->fault(); }
  void accept_step() override { _body->accept_step(); }
  state::State state() override { return _body->state(); }
  state::State saved_state() override { return _body->saved_state(); }
  void resume(const state::State& saved) override { _body->resume(saved); }
  std::optional<double> stored_energy() override { return _body->stored_energy(); }
  std::span<const double> origin() const override { return _origin; }

  solve::Body& body() { return *_body; }
  const Inertia& inertia() const { return *_inertia; }

private:
  std::size_t num_owned() const { return _inertia->massless().size(); }
  void make_vector(Vec& v, std::span<const double> values) const;

  std::shared_ptr<solve::Body> _body;
  std::shared_ptr<Function> _displacement, _velocity;
  std::shared_ptr<const Inertia> _inertia;
  double _alpha;
  std::shared_ptr<VelocityForce> _damping;
  std::optional<StepMotion> _step;
  std::vector<double> _origin;                    ///< displacement at the start of the step, owned [L]
  std::vector<double> _mass_factor, _factor;      ///< that `_mass` and the tangent of linear bodies were made with
  Mat _mass = nullptr, _linear_tangent = nullptr; ///< mass and its damping, scaled by the factors of the step
};
} // namespace dolfinx_impact::integrators
