#include "CentralDifference.h"
#include <algorithm>
#include <numeric>

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

/// Sum of a part's forces times the increments of the last step: what they do in it. Not for contact.
double CentralDifference::work(const Part& part) const
{
  return _last_step * sum_of_products(_own_size, part.force.data(), _v.data());
}

void CentralDifference::evaluate_contact(Part& part)
{
  const Stopwatch watch(_contact_seconds);
  const enforcement::NodalState state{_near.u.data(), _near.du.data(), _near.inverse.data(), _contact_step};
  for (Contact& c : _contacts)
    if (!c.contact->kinematic())
    {
      c.contact->add_forces(state, part.force.data());
      const double* sum = c.contact->force();
      for (int k = 0; k < _bs; ++k)
        _obstacle_work += 0.5 * c.moved[k] * sum[k];
    }
  const auto sweep = [&]<int D>()
  {
    double position[D] = {}, work[D] = {};
    for (std::size_t k = 0; k < _touched.size(); ++k)
      for (int c = 0; c < D; ++c)
      {
        const double force = part.force[k * D + c];
        _r[std::size_t(_touched[k]) * D + c] += part.sign * force;
        position[c] += force * _near.u[k * D + c];
        work[c] += force * _near.du[k * D + c];
      }
    part.position = std::accumulate(position, position + D, 0.0);
    part.work.before = 0.5 * std::accumulate(work, work + D, 0.0);
  };
  _bs == 2 ? sweep.operator()<2>() : sweep.operator()<3>();
}

void CentralDifference::evaluate_part(Part& part)
{
  part.account == Account::contact ? evaluate_contact(part) : evaluate_form(part);
}

void CentralDifference::evaluate_form(Part& part)
{
  double* force = part.force.data();
  std::fill(force, force + _own_size, 0.0);
  for (const auto& operation : {part.forces.inner, part.forces.outer})
    operation->assemble({force, _own_size});
  for (std::size_t i = 0; i < _own_size; ++i)
    _r[i] += part.sign * force[i];
  part.position = sum_of_products(_own_size, force, _u.data());
  part.work.before = 0.5 * work(part);
}

bool CentralDifference::evaluate()
{
  if (!_contacts.empty() && !(_contact_step > 0.0))
    throw std::invalid_argument("contact has no step to make its stiffness for: call set_contact_step first");
  _internal.inner->assemble({_r.data(), _own_size});
  receive();
  const bool stable = reduce_end();
  double springs_work = 0.0;
  if (!_contacts.empty())
  {
    const Stopwatch watch(_contact_seconds);
    springs_work = gather(springs());
  }
  for (Part& part : _parts) // the forces of the last time level, the motion since
    part.work.done += 0.5 * (part.account == Account::contact ? springs_work : work(part));
  for (Contact& c : _contacts)
    for (int k = 0; k < _bs; ++k)
      _obstacle_work += 0.5 * c.moved[k] * c.contact->force()[k];
  if (_search_due && !_contacts.empty())
  {
    const Stopwatch watch(_contact_seconds);
    search();
    gather(springs());
  }
  _internal.outer->assemble({_r.data(), _own_size});
  for (Part& part : _parts)
    evaluate_part(part);
  _used = 0.0;
  if (!_contacts.empty())
  {
    const Stopwatch watch(_contact_seconds);
    const enforcement::NodalState state{_near.u.data(), _near.du.data(), _near.inverse.data(), _contact_step};
    for (const Contact& c : _contacts)
      if (!(c.contact->used(state) < 1.0))
        _used += 1.0;
  }
  _halo->reverse(_r.data(), _bs);
  std::fill(_r.begin() + _owned, _r.end(), 0.0);
  _fresh = true;
  return stable;
}

void CentralDifference::revise()
{
  if (!_fresh)
    return; // nothing is known of this time level yet
  // Friction has its history: the forces of springs are not computed twice.
  const std::vector<double> contact = springs() ? kept_forces() : std::vector<double>(_owned, 0.0);
  std::fill(_r.begin(), _r.end(), 0.0);
  for (const auto& operation : {_internal.inner, _internal.outer})
    operation->assemble({_r.data(), _own_size});
  for (Part& part : _parts)
    if (part.account != Account::contact)
      evaluate_form(part);
  _halo->reverse(_r.data(), _bs);
  std::fill(_r.begin() + _owned, _r.end(), 0.0);
  for (std::size_t i = 0; i < _owned; ++i)
    _r[i] -= contact[i];
}
} // namespace impact::integrators
