#include "CentralDifference.h"
#include <algorithm>

// The forces of a time level.
namespace impact::integrators
{
namespace
{
/// By four sums: additions do not wait for each other.
double sum_of_products(std::size_t size, const double* a, const double* b)
{
  double sum[4] = {};
  std::size_t k = 0;
  for (; k + 4 <= size; k += 4)
    for (int j = 0; j < 4; ++j)
      sum[j] += a[k + j] * b[k + j];
  for (; k < size; ++k)
    sum[0] += a[k] * b[k];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}
} // namespace

/// Ghosts' displacements arrive; their velocities follow from them.
void CentralDifference::receive()
{
  if (!_pending)
    return;
  std::copy(_u.begin() + _owned, _u.end(), _old_ghosts.begin());
  _halo->forward_end(_u.data(), _bs);
  for (std::size_t i = _owned; i < _u.size(); ++i)
    _v[i] = (_u[i] - _old_ghosts[i - _owned]) / _last_step;
  _pending = false;
}

/// Sum of a part's forces times velocities.
double CentralDifference::product(const Part& part) const
{
  const bool contact = part.account == Account::contact;
  const double* v = contact ? _near.v.data() : _v.data();
  const std::size_t size = contact ? part.force.size() : _own_size;
  return sum_of_products(size, part.force.data(), v);
}

void CentralDifference::evaluate_part(Part& part)
{
  double* force = part.force.data();
  if (part.account == Account::contact)
  {
    std::fill(part.force.begin(), part.force.end(), 0.0);
    const enforcement::NodalState state{_near.u.data(), _near.du.data(), _near.inverse.data(), _contact_step};
    for (Contact& c : _contacts)
      if (!c.contact->kinematic())
      {
        c.contact->add_forces(state, force);
        const double* sum = c.contact->force();
        for (int k = 0; k < _bs; ++k)
          _obstacle_work += 0.5 * c.moved[k] * sum[k];
      }
    for (std::size_t k = 0; k < _touched.size(); ++k)
      for (int c = 0; c < _bs; ++c)
        _r[std::size_t(_touched[k]) * _bs + c] += part.sign * force[k * _bs + c];
    part.position = sum_of_products(part.force.size(), force, _near.u.data());
    part.work.before = 0.5 * _last_step * product(part);
    return;
  }
  std::fill(force, force + _own_size, 0.0);
  for (const auto& operation : {part.forces.inner, part.forces.outer})
    if (operation)
      operation->assemble({force, _own_size});
  for (std::size_t i = 0; i < _own_size; ++i)
    _r[i] += part.sign * force[i];
  part.position = sum_of_products(_own_size, force, _u.data());
  part.work.before = 0.5 * _last_step * product(part);
}

bool CentralDifference::evaluate()
{
  if (_internal.inner)
    _internal.inner->assemble({_r.data(), _own_size});
  receive();
  const bool stable = reduce_end();
  if (!_contacts.empty())
    gather();
  for (Part& part : _parts)
    part.work.done += 0.5 * _last_step * product(part); // the forces of the last time level, the motion since
  for (Contact& c : _contacts)
    for (int k = 0; k < _bs; ++k)
      _obstacle_work += 0.5 * c.moved[k] * c.contact->force()[k];
  if (_search_due && !_contacts.empty())
  {
    search();
    gather();
  }
  if (_internal.outer)
    _internal.outer->assemble({_r.data(), _own_size});
  for (Part& part : _parts)
    evaluate_part(part);
  _used = 0.0;
  const enforcement::NodalState state{_near.u.data(), _near.du.data(), _near.inverse.data(), _contact_step};
  for (const Contact& c : _contacts)
    if (!(c.contact->used(state) < 1.0))
      _used += 1.0;
  _halo->reverse(_r.data(), _bs);
  std::fill(_r.begin() + _owned, _r.end(), 0.0);
  _fresh = true;
  return stable;
}
} // namespace impact::integrators
