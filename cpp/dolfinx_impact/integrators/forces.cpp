#include "CentralDifference.h"
#include <algorithm>

// The forces of a time level.
namespace impact::integrators
{
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

double CentralDifference::product(const Part& part, const std::vector<double>& x) const
{
  // Four sums: additions do not wait for each other.
  double sum[4] = {};
  const auto add = [&](std::size_t size, auto&& at)
  {
    std::size_t k = 0;
    for (; k + 4 <= size; k += 4)
      for (int j = 0; j < 4; ++j)
        sum[j] += part.force[at(k + j)] * x[at(k + j)];
    for (; k < size; ++k)
      sum[0] += part.force[at(k)] * x[at(k)];
  };
  if (part.account == Account::contact && !_gathered)
    add(_touched.size(), [&](std::size_t k) { return std::size_t(_touched[k]); });
  else
    add(_own_size, [](std::size_t k) { return k; });
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

void CentralDifference::evaluate_part(Part& part)
{
  double* force = part.force.data();
  if (part.account == Account::contact)
  {
    for (std::int32_t i : _touched)
    {
      force[i] = 0.0;
      _du[i] = _last_step * _v[i];
    }
    const enforcement::NodalState state{_u.data(), _du.data(), _inverse.data(), _contact_step};
    for (Contact& c : _contacts)
      if (!c.contact->kinematic())
      {
        c.contact->add_forces(state, force);
        const double* sum = c.contact->force();
        for (int k = 0; k < _bs; ++k)
          _obstacle_work += 0.5 * c.moved[k] * sum[k];
      }
    // One way through memory for both sums; the components' sums do not wait for each other.
    double position[3] = {}, before[3] = {};
    for (std::size_t k = 0; k < _touched.size(); k += _bs)
      for (int c = 0; c < _bs; ++c)
      {
        const std::size_t i = std::size_t(_touched[k]) + c;
        _r[i] += part.sign * force[i];
        position[c] += force[i] * _u[i];
        before[c] += force[i] * _v[i];
      }
    part.position = position[0] + position[1] + position[2];
    part.work.before = 0.5 * _last_step * (before[0] + before[1] + before[2]);
    return;
  }
  std::fill(force, force + _own_size, 0.0);
  for (const auto& operation : {part.forces.inner, part.forces.outer})
    if (operation)
      operation->assemble({force, _own_size});
  for (std::size_t i = 0; i < _own_size; ++i)
    _r[i] += part.sign * force[i];
  part.position = product(part, _u);
  part.work.before = 0.5 * _last_step * product(part, _v);
}

bool CentralDifference::evaluate()
{
  if (_internal.inner)
    _internal.inner->assemble({_r.data(), _own_size});
  receive();
  const bool stable = reduce_end();
  for (Part& part : _parts)
    part.work.done += 0.5 * _last_step * product(part, _v); // the forces of the last time level, the motion since
  _gathered = false;
  for (Contact& c : _contacts)
    for (int k = 0; k < _bs; ++k)
      _obstacle_work += 0.5 * c.moved[k] * c.contact->force()[k];
  if (_search_due && !_contacts.empty())
    search();
  if (_internal.outer)
    _internal.outer->assemble({_r.data(), _own_size});
  for (Part& part : _parts)
    evaluate_part(part);
  _used = 0.0;
  const enforcement::NodalState state{_u.data(), _du.data(), _inverse.data(), _contact_step};
  for (const Contact& c : _contacts)
    if (!(c.contact->used(state) < 1.0))
      _used += 1.0;
  _halo->reverse(_r.data(), _bs);
  std::fill(_r.begin() + _owned, _r.end(), 0.0);
  _fresh = true;
  return stable;
}
} // namespace impact::integrators
