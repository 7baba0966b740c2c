// SPDX-License-Identifier: MIT
#include "RigidBall.h"
#include <cmath>
#include <stdexcept>

namespace impact_reference
{
RigidBall::RigidBall(int gdim, double radius, Vec<double> centre, double mass, double inertia, Vec<double> velocity,
                     Vec<double> spin, Vec<double> force)
    : gdim_(gdim), radius_(radius), mass_(mass), inertia_(inertia), centre_(centre), velocity_(velocity), spin_(spin),
      load_(force)
{
  if (not(mass > 0) or not(inertia > 0))
    throw std::invalid_argument("a ball needs a positive mass and inertia");
}

Vec<double> RigidBall::moved_at(const Vec<double>& x) const
{
  // r is turned back by Rodrigues' formula.
  const Vec<double> r = x - centre_ - displacement_;
  const double angle = norm(angle_);
  if (angle == 0)
    return moved_;
  const Vec<double> axis = (-1 / angle) * angle_;
  const Vec<double> before =
      std::cos(angle) * r + std::sin(angle) * cross(axis, r) + ((1 - std::cos(angle)) * dot(axis, r)) * axis;
  return moved_ + r - before;
}

void RigidBall::clear()
{
  force_ = {};
  torque_ = {};
}

void RigidBall::add(const Vec<double>& force, const Vec<double>& x)
{
  force_ = force_ - force;
  torque_ = torque_ - cross(x - centre_ - displacement_, force);
}

void RigidBall::push(double mean, bool first)
{
  external_ += dot(load_, moved_);
  const Vec<double> dv = (mean / mass_) * (load_ + force_), ds = (mean / inertia_) * torque_;
  const Vec<double> v_before = first ? velocity_ - dv : velocity_, s_before = first ? spin_ - ds : spin_;
  velocity_ = velocity_ + dv;
  spin_ = spin_ + ds;
  kinetic_ = mass_ * dot(v_before, velocity_) / 2 + inertia_ * dot(s_before, spin_) / 2;
}

void RigidBall::move(double dt)
{
  moved_ = dt * velocity_;
  angle_ = dt * spin_;
  displacement_ = displacement_ + moved_;
}

double RigidBall::mobility(double area, bool friction) const
{
  return area * (1 / mass_ + (friction ? radius_ * radius_ / inertia_ : 0));
}
} // namespace impact_reference
