// SPDX-License-Identifier: MIT
#include "KinematicStep.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::enforcement
{
namespace
{
/// Factor of every second sweep; it damps forces that alternate from node to node.
constexpr double over_relaxation = 1.5;

/// Largest eigenvalue of the symmetric matrix with the entries xx, xy, yy.
double largest_eigenvalue(double xx, double xy, double yy)
{
  return 0.5 * (xx + yy) + std::hypot(0.5 * (xx - yy), xy);
}

/// The same in space, by the trigonometric solution of the cubic equation.
double largest_eigenvalue(double xx, double xy, double yy, double xz, double yz, double zz)
{
  const double mean = (xx + yy + zz) / 3.0, a = xx - mean, b = yy - mean, c = zz - mean;
  const double size = std::sqrt((a * a + b * b + c * c + 2.0 * (xy * xy + xz * xz + yz * yz)) / 6.0);
  if (!(size > 0.0))
    return mean;
  const double determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz);
  const double cosine = std::clamp(0.5 * determinant / (size * size * size), -1.0, 1.0);
  return mean + 2.0 * size * std::cos(std::acos(cosine) / 3.0);
}
} // namespace

void KinematicStep::assign_numbers(operators::Halo& all, operators::Halo& halo, std::span<const std::int32_t> numbers)
{
  if (_contacts.empty())
    return;
  _halo = &halo;
  _gdim = _contacts.front()->candidates().gdim();
  // Surfaces that each node belongs to, whether it is a candidate for contact or not.
  std::vector<double> surfaces(all.num_nodes(), 0.0);
  for (const KinematicContact* contact : _contacts)
    for (std::int32_t node : contact->candidates().nodes())
      surfaces[node] += 1.0;
  all.forward(surfaces, 1);
  for (const KinematicContact* contact : _contacts)
    for (std::size_t k = 0; k < contact->master_areas().size(); ++k)
      surfaces[k] += contact->master_areas()[k] > 0.0;
  std::vector<std::int32_t> nodes;
  for (const KinematicContact* contact : _contacts)
    nodes.insert(nodes.end(), contact->nodes().begin(), contact->nodes().end());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  _ranges.clear();
  for (const std::size_t node : nodes)
    if (!_ranges.empty() && _ranges.back().second == node)
      ++_ranges.back().second;
    else
      _ranges.emplace_back(node, node + 1);
  const std::size_t num = halo.num_nodes();
  std::vector<char> shared(num, 0);
  _shared.clear();
  int any = 0;
  for (std::size_t k = 0; k < surfaces.size(); ++k)
    if (surfaces[k] > 1.0 && numbers[k] >= 0)
    {
      any = 1;
      shared[numbers[k]] = 1;
      if (numbers[k] < halo.num_owned())
        _shared.push_back(numbers[k]);
    }
  std::sort(_shared.begin(), _shared.end());
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, halo.map().comm());
  _values.weight.assign(num, 0.0);
  _values.largest.assign(any ? num : 0, 0.0);
  for (std::vector<double>& part : _values.tensor)
    part.assign(any ? num * 3 : 0, 0.0);
  for (std::vector<double>* values : {&_values.force, &_values.correction, &_values.before})
    values->assign(num * _gdim, 0.0);
  _values.shared = std::move(shared);
}

/// Owned nodes of several surfaces: the largest eigenvalue of their tensor, where no component is prescribed.
template <int D>
void KinematicStep::find_largest_weights(std::span<const double> inverse_mass)
{
  for (std::int32_t node : _shared)
  {
    const double* m = inverse_mass.data() + std::size_t(node) * D;
    if (!std::all_of(m, m + D, [](double value) { return value > 0.0; }))
      continue;
    const double* t = _values.tensor[0].data() + 3 * std::size_t(node);
    const double* s = _values.tensor[1].data() + 3 * std::size_t(node);
    const double found =
        D == 2 ? largest_eigenvalue(t[0], t[1], t[2]) : largest_eigenvalue(t[0], t[1], t[2], s[0], s[1], s[2]);
    _values.largest[node] = std::min(found, _values.weight[node]);
  }
}

/// What weighs on each node, of all ranks.
void KinematicStep::sum_weights(std::span<const double> inverse_mass)
{
  CorrectedNodes& v = _values;
  const bool shares = !v.largest.empty();
  // Ghosts still hold the values that their owners sent in the last step: all entries are reset.
  std::fill(v.weight.begin(), v.weight.end(), 0.0);
  for (std::vector<double>& part : v.tensor)
    std::fill(part.begin(), part.end(), 0.0);
  bool deformable = false;
  for (KinematicContact* contact : _contacts)
  {
    contact->add_weights(v);
    deformable = deformable || !contact->candidates().rigid();
  }
  if (deformable)
    _halo->reverse(v.weight, 1);
  if (shares)
  {
    if (deformable)
      for (int part = 0; part < (_gdim == 2 ? 1 : 2); ++part)
        _halo->reverse(v.tensor[part], 3);
    std::copy(v.weight.begin(), v.weight.end(), v.largest.begin());
    _gdim == 2 ? find_largest_weights<2>(inverse_mass) : find_largest_weights<3>(inverse_mass);
    if (deformable)
      _halo->forward(v.largest, 1);
  }
  if (deformable)
    _halo->forward(v.weight, 1);
}

/// Nodal sums of the contact forces and the displacements that they cause.
/// @param[in] last it was the last sweep
void KinematicStep::sum_forces(const PredictedStep& step, bool last)
{
  CorrectedNodes& v = _values;
  bool deformable = false;
  double *force = v.force.data(), *correction = v.correction.data();
  for_components(false, [force](std::size_t k) { force[k] = 0.0; });
  for (KinematicContact* contact : _contacts)
  {
    contact->add_forces(v.force, last);
    deformable = deformable || !contact->candidates().rigid();
  }
  if (deformable)
    _halo->reverse(v.force, _gdim);
  const double *inverse_mass = step.inverse_mass.data(), h = step.h;
  for_components(true, [=](std::size_t k) { correction[k] = h * force[k] * inverse_mass[k]; });
  if (deformable)
    _halo->forward(v.correction, _gdim);
}

void KinematicStep::correct(const PredictedStep& step, std::span<double> u, std::span<double> f)
{
  CorrectedNodes& v = _values;
  for_components(false,
                 [&](std::size_t k)
                 {
                   v.before[k] = step.du_before[k];
                   v.correction[k] = 0.0;
                 });
  int sweeps = 0;
  for (KinematicContact* contact : _contacts)
  {
    contact->predict(step, u);
    sweeps = std::max(sweeps, contact->sweeps());
  }
  sum_weights(step.inverse_mass);
  for (KinematicContact* contact : _contacts)
    contact->begin(step, v);
  for (int sweep = 0; sweep < sweeps; ++sweep)
  {
    for (KinematicContact* contact : _contacts)
      contact->solve_forces(v, step.h, sweep % 2 ? over_relaxation : 1.0, sweep == 0);
    sum_forces(step, sweep + 1 == sweeps);
  }
  for_components(true,
                 [&](std::size_t k)
                 {
                   u[k] += v.correction[k];
                   f[k] += v.force[k];
                 });
  _halo->forward(u, _gdim);
  for (KinematicContact* contact : _contacts)
    contact->record(v, step.h, step.dt);
}
} // namespace dolfinx_impact::enforcement
