// SPDX-License-Identifier: MIT
#include "MovingBody.h"
#include "../../common/dolfinx_api.h"
#include "../../operators/petsc_check.h"
#include <algorithm>

using dolfinx_impact::operators::check;

namespace dolfinx_impact::integrators
{
namespace
{
/// Properties of bodies that have got inertia and damping (may be null).
solve::BodyProperties in_motion(solve::BodyProperties properties, const VelocityForce* damping)
{
  properties.linear = properties.keeps_tangent && (!damping || damping->linear());
  properties.keeps_tangent = properties.linear;
  properties.symmetric = properties.symmetric && !damping;
  properties.has_inertia = true;
  return properties;
}
} // namespace

MovingBody::MovingBody(std::shared_ptr<solve::Body> body, std::shared_ptr<Function> displacement,
                       std::shared_ptr<Function> velocity, std::shared_ptr<const Inertia> inertia, double alpha,
                       std::shared_ptr<VelocityForce> damping)
    : Body(in_motion(body->properties(), damping.get())), _body(std::move(body)),
      _displacement(std::move(displacement)), _velocity(std::move(velocity)), _inertia(std::move(inertia)),
      _alpha(alpha), _damping(std::move(damping))
{
}

MovingBody::~MovingBody()
{
  MatDestroy(&_mass);
  MatDestroy(&_linear_tangent);
}

/// A vector of the mass matrix with given entries; it is the caller's. Collective.
void MovingBody::make_vector(Vec& v, std::span<const double> values) const
{
  check(MatCreateVecs(_inertia->matrix(), &v, nullptr), "a vector is made");
  operators::Entries entries(v);
  for (std::size_t i = 0; i < entries.size(); ++i)
    entries[i] = values[i];
}

void MovingBody::begin_step(StepMotion step)
{
  _step = std::move(step);
  const std::span<const double> u = common::array(*_displacement->x());
  _origin.assign(u.begin(), u.begin() + num_owned());
  const auto a = _step->acceleration_factor(), v = _step->velocity_factor();
  std::vector<double> mass(num_owned());
  for (std::size_t i = 0; i < mass.size(); ++i)
    mass[i] = a[i] + _alpha * v[i];
  int known = _mass && mass == _mass_factor && std::ranges::equal(v, _factor);
  MPI_Allreduce(MPI_IN_PLACE, &known, 1, MPI_INT, MPI_MIN, PetscObjectComm((PetscObject)_inertia->matrix()));
  if (known)
    return;
  _mass_factor = std::move(mass);
  _factor.assign(v.begin(), v.end());
  check(MatDestroy(&_mass), "a matrix is destroyed");
  check(MatDestroy(&_linear_tangent), "a matrix is destroyed");
  check(MatDuplicate(_inertia->matrix(), MAT_COPY_VALUES, &_mass), "a mass matrix is copied");
  Vec factors = nullptr;
  make_vector(factors, _mass_factor);
  check(MatDiagonalScale(_mass, nullptr, factors), "a mass matrix is scaled");
  VecDestroy(&factors);
}

Motion MovingBody::end_of_step() const
{
  return _step->end(_displacement->x()->array());
}

std::vector<double> MovingBody::damping_forces(const Motion& motion)
{
  std::ranges::copy(motion.velocity, common::array(*_velocity->x()).begin());
  std::vector<double> out(num_owned(), 0.0);
  if (_alpha > 0.0)
  {
    out = _inertia->times(motion.velocity);
    for (double& force : out)
      force *= _alpha;
  }
  if (_damping)
  {
    _velocity->x()->scatter_fwd();
    const std::vector<double> more = _damping->forces();
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] += more[i];
  }
  return out;
}

Vec MovingBody::residual()
{
  const Motion motion = end_of_step();
  const std::vector<double> inertia = _inertia->times(motion.acceleration), damping = damping_forces(motion);
  Vec b = _body->residual();
  operators::Entries entries(b);
  for (std::size_t i = 0; i < inertia.size(); ++i)
    entries[i] += inertia[i] + damping[i];
  return b;
}

Mat MovingBody::tangent()
{
  if (_linear_tangent)
    return _linear_tangent;
  Mat total = _body->tangent();
  if (properties().linear)
  {
    check(MatDuplicate(total, MAT_COPY_VALUES, &_linear_tangent), "a tangent is copied");
    total = _linear_tangent;
  }
  check(MatAXPY(total, 1.0, _mass, SUBSET_NONZERO_PATTERN), "a mass matrix is added");
  if (_damping)
  {
    Vec factors = nullptr;
    make_vector(factors, _factor);
    for (Mat part : _damping->tangent(factors))
      check(MatAXPY(total, 1.0, part, SUBSET_NONZERO_PATTERN), "a damping matrix is added");
    VecDestroy(&factors);
  }
  return total;
}
} // namespace dolfinx_impact::integrators
