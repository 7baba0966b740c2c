// SPDX-License-Identifier: MIT
#include "KinematicStep.h"
#include "../../common/clones.h"
#include "../../common/columns.h"
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

/// Calls each(k, n) for the components of a range of nodes: their positions in arrays by component, and in the padded
/// ones of CorrectedNodes.
void for_components(int gdim, std::size_t first, std::size_t last, auto&& each)
{
  const auto all = [&]<int D>()
  {
    for (std::size_t node = first; node < last; ++node)
#pragma GCC unroll 4
      for (int c = 0; c < D; ++c)
        each(node * D + c, node * CorrectedNodes::stride(D) + c);
  };
  gdim == 2 ? all.template operator()<2>() : all.template operator()<3>();
}

/// Displacements by forces, of padded nodes.
/// @param[in] inverse_mass three numbers a node
IMPACT_CLONES void displace(std::size_t first, std::size_t last, double h, const double* force,
                            const double* inverse_mass, double* correction)
{
  // A whole register of reciprocal masses reaches into the next node.
  for (std::size_t node = first; node + 1 < last; ++node)
    common::column(correction + 4 * node) =
        h * common::column(force + 4 * node) * common::column(inverse_mass + 3 * node);
  for (int c = 0; c < 3 && first < last; ++c)
    correction[4 * (last - 1) + c] = h * force[4 * (last - 1) + c] * inverse_mass[3 * (last - 1) + c];
}
} // namespace

void KinematicStep::assign_numbers(operators::Halo& all, operators::Halo& halo, std::span<const std::int32_t> numbers)
{
  if (_contacts.empty())
    return;
  _halo = &halo;
  _gdim = _contacts.front()->candidates().gdim();
  _stride = CorrectedNodes::stride(_gdim);
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
    values->assign(num * _stride, 0.0);
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

/// Nodal sums of the contact forces of a sweep, and the displacements that they cause.
void KinematicStep::sweep(const PredictedStep& step, double factor, KinematicContact::Sweep which)
{
  CorrectedNodes& v = _values;
  bool deformable = false;
  double *force = v.force.data(), *correction = v.correction.data();
  for_ranges(false, [&](std::size_t first, std::size_t last)
             { std::fill(force + first * _stride, force + last * _stride, 0.0); });
  for (KinematicContact* contact : _contacts)
  {
    contact->sweep(step, v, factor, which);
    deformable = deformable || !contact->candidates().rigid();
  }
  if (deformable)
    _halo->reverse(v.force, _gdim, _stride);
  const double *inverse_mass = step.inverse_mass.data(), h = step.h;
  for_ranges(true,
             [&](std::size_t first, std::size_t last)
             {
               if (_gdim == 3)
                 return displace(first, last, h, force, inverse_mass, correction);
               for (std::size_t k = first * _stride; k < last * _stride; ++k)
                 correction[k] = h * force[k] * inverse_mass[k];
             });
  if (deformable)
    _halo->forward(v.correction, _gdim, _stride);
}

void KinematicStep::correct(const PredictedStep& step, std::span<double> u, std::span<double> f)
{
  CorrectedNodes& v = _values;
  for_ranges(false,
             [&](std::size_t first, std::size_t last)
             {
               std::fill(v.correction.begin() + first * _stride, v.correction.begin() + last * _stride, 0.0);
               for_components(_gdim, first, last,
                              [&](std::size_t k, std::size_t n) { v.before[n] = step.du_before[k]; });
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
  for (int k = 0; k < sweeps; ++k)
    sweep(step, k % 2 ? over_relaxation : 1.0, {k == 0, k + 1 == sweeps});
  for_ranges(true,
             [&](std::size_t first, std::size_t last)
             {
               for_components(_gdim, first, last,
                              [&](std::size_t k, std::size_t n)
                              {
                                u[k] += v.correction[n];
                                f[k] += v.force[n];
                              });
             });
  _halo->forward(u, _gdim);
  for (KinematicContact* contact : _contacts)
    contact->record(v, step.h, step.dt);
}
} // namespace dolfinx_impact::enforcement
