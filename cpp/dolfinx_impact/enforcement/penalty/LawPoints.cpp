// SPDX-License-Identifier: MIT
#include "LawPoints.h"
#include "../../common/vectors.h"
#include "../interface/tangential.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace dolfinx_impact::enforcement
{
namespace
{
/// Adds rows of a law's derivative times the derivative of its input.
/// @param[in] d derivative of pressure and shear by the input
/// @param[in] p point
/// @param[in] d_input size x num
/// @param[in,out] out (1 + gdim) x num
void add_product(const InterfaceDerivative& d, std::size_t p, int gdim, int num, const double* d_input, double* out)
{
  if (d.values.empty())
    return;
  const double* rows = d.values.data() + p * (1 + gdim) * d.size;
  for (int i = 0; i < 1 + gdim; ++i)
    for (int k = 0; k < d.size; ++k)
      for (int j = 0; j < num; ++j)
        out[i * num + j] += rows[i * d.size + k] * d_input[k * num + j];
}

/// Largest modulus of a derivative's entries.
double largest(const InterfaceDerivative& d)
{
  return common::largest_modulus(d.values);
}
} // namespace

LawPoints::LawPoints(std::shared_ptr<const InterfaceLaw> law, std::size_t num_points)
    : _law(std::move(law)), _gdim(_law->gdim()), _last_gap(num_points, std::numeric_limits<double>::infinity()),
      _last_pressure(num_points, 0.0), _last_shear(num_points * _gdim, 0.0), _last_stored(num_points, 0.0),
      _last_shear_stored(num_points, 0.0), _history(_law->make_history(num_points)), _place(num_points, -1),
      _acts(num_points, 0), _points(_law->make_points(0))
{
}

void LawPoints::evaluate(const gap::Points& points, const Motion& motion, const Fields& slave, const Fields& master)
{
  const int gdim = _gdim;
  _accepted = false;
  std::size_t num = 0;
  for (std::size_t q = 0; q < points.size(); ++q)
  {
    const double gap = points.gap[q] + (points.beside[q] ? 0.0 : motion.offset[q]);
    const bool asked = std::isfinite(gap) && gap <= _law->reach();
    _place[q] = asked ? std::int32_t(num++) : -1;
    _acts[q] = 0;
  }
  _points.resize(num);
  _knows_gap.resize(num);
  for (std::vector<double>* values : {&_increment, &_slip_before, &_slip_turned})
    values->resize(num * gdim);
  _shear.resize(num * gdim);
  const double per_step = time_step > 0.0 ? 1.0 / time_step : 0.0;
  for (std::size_t q = 0; q < points.size(); ++q)
  {
    if (_place[q] < 0)
      continue;
    const std::size_t p = _place[q];
    const double* n = points.normal.data() + q * gdim;
    const double* moved = motion.increment.data() + q * gdim;
    _points.row[p] = std::int32_t(q);
    _points.gap[p] = points.gap[q] + (points.beside[q] ? 0.0 : motion.offset[q]);
    const double along = dot(n, moved, gdim);
    _knows_gap[p] = std::isfinite(_last_gap[q]);
    _points.gap_rate[p] = per_step * (_knows_gap[p] ? _points.gap[p] - _last_gap[q] : along);
    double* turned = _slip_turned.data() + p * gdim;
    std::copy_n(motion.slip.data() + q * gdim, gdim, _slip_before.data() + p * gdim);
    turn(gdim, n, _slip_before.data() + p * gdim, turned);
    for (int c = 0; c < gdim; ++c)
    {
      const double slip = moved[c] - along * n[c];
      _points.normal[p * gdim + c] = n[c];
      _points.slip[p * gdim + c] = turned[c] + slip;
      _points.slip_rate[p * gdim + c] = per_step * slip;
      _increment[p * gdim + c] = moved[c];
    }
    for (InterfaceHistory::Variable& v : _history.variables)
      if (v.tangential)
        turn(gdim, n, v.committed.data() + q * gdim, v.turned.data() + q * gdim);
    for (std::size_t f = 0; f < slave.size(); ++f)
    {
      _points.slave_fields[f][p] = slave[f][q];
      _points.master_fields[f][p] = master[f][q];
    }
  }
  for (InterfaceHistory::Variable& v : _history.variables)
    v.updated = v.committed; // points out of reach keep theirs
  _law->evaluate(_points, _history, _tractions);
  const auto nonzero = [&](const InterfaceDerivative& d, std::size_t p)
  {
    const std::size_t size = (1 + gdim) * std::size_t(d.size);
    return !d.values.empty() && std::any_of(d.values.begin() + p * size, d.values.begin() + (p + 1) * size,
                                            [](double value) { return value != 0.0; });
  };
  for (std::size_t q = 0; q < points.size(); ++q)
  {
    if (_place[q] < 0)
      continue;
    const std::size_t p = _place[q];
    const double* n = points.normal.data() + q * gdim;
    const double* shear = _tractions.shear.data() + p * gdim;
    const double along = dot(n, shear, gdim);
    bool any = _tractions.pressure[p] != 0.0;
    for (int c = 0; c < gdim; ++c)
    {
      _shear[p * gdim + c] = shear[c] - along * n[c];
      any |= shear[c] != 0.0;
    }
    for (const InterfaceDerivative* d :
         {&_tractions.by_gap, &_tractions.by_slip, &_tractions.by_gap_rate, &_tractions.by_slip_rate})
      any = any || nonzero(*d, p);
    _acts[q] = any;
  }
}

ContactStatus LawPoints::status(std::size_t q) const
{
  if (!acts(q))
    return ContactStatus::open;
  const bool sticks = _tractions.sticks.empty() ? _law->has_shear() : _tractions.sticks[_place[q]] > 0.5;
  return sticks ? ContactStatus::stick : ContactStatus::slip;
}

double LawPoints::stiffness(std::size_t q) const
{
  if (!acts(q))
    return 0.0;
  const std::size_t row = std::size_t(_place[q]) * (1 + _gdim);
  double out = 0.0;
  if (!_tractions.by_gap.values.empty())
    out -= _tractions.by_gap.values[row];
  if (!_tractions.by_gap_rate.values.empty() && time_step > 0.0)
    out -= _tractions.by_gap_rate.values[row] / time_step;
  return out;
}

double LawPoints::largest_stiffness() const
{
  return std::max(largest(_tractions.by_gap), largest(_tractions.by_slip));
}

void LawPoints::traction_derivative(std::size_t q, const Variation& v, const double* n, const double* increment,
                                    const double* d_increment, double* dz) const
{
  const int gdim = _gdim, num = v.num;
  const std::size_t p = _place[q];
  constexpr int width = Variation::max_num;
  double out[4 * width] = {}; // of pressure and shear as the law returns them
  add_product(_tractions.by_gap, p, gdim, num, v.d_gap, out);
  add_product(_tractions.by_normal, p, gdim, num, v.d_normal, out);
  const double along = dot(n, increment, gdim);
  double moved[3 * width], turned[3 * width], slip[3 * width], rate[width];
  for (int j = 0; j < num; ++j)
  {
    double d_along = 0.0;
    for (int c = 0; c < gdim; ++c)
      d_along += n[c] * d_increment[c * num + j] + v.d_normal[c * num + j] * increment[c];
    rate[j] = _knows_gap[p] ? v.d_gap[j] : d_along;
    for (int c = 0; c < gdim; ++c)
      moved[c * num + j] = d_increment[c * num + j] - n[c] * d_along - v.d_normal[c * num + j] * along;
  }
  if (time_step > 0.0)
  {
    double by_time[3 * width];
    std::transform(moved, moved + gdim * num, by_time, [this](double value) { return value / time_step; });
    add_product(_tractions.by_slip_rate, p, gdim, num, by_time, out);
    std::transform(rate, rate + num, by_time, [this](double value) { return value / time_step; });
    add_product(_tractions.by_gap_rate, p, gdim, num, by_time, out);
  }
  if (!_tractions.by_slip.values.empty())
  {
    turn_derivative(gdim, n, _slip_before.data() + p * gdim, _slip_turned.data() + p * gdim, num, v.d_normal, turned);
    for (int i = 0; i < gdim * num; ++i)
      slip[i] = turned[i] + moved[i];
    add_product(_tractions.by_slip, p, gdim, num, slip, out);
  }
  for (std::size_t k = 0; k < _history.variables.size(); ++k)
    if (const InterfaceHistory::Variable& h = _history.variables[k];
        h.tangential && !_tractions.by_history[k].values.empty())
    {
      turn_derivative(gdim, n, h.committed.data() + q * gdim, h.turned.data() + q * gdim, num, v.d_normal, turned);
      add_product(_tractions.by_history[k], p, gdim, num, turned, out);
    }
  // traction = pressure n + (I - n n) shear
  const double* shear = _tractions.shear.data() + p * gdim;
  const double pressure = _tractions.pressure[p], shear_n = dot(n, shear, gdim);
  for (int j = 0; j < num; ++j)
  {
    double d_along = 0.0;
    for (int c = 0; c < gdim; ++c)
      d_along += n[c] * out[(1 + c) * num + j] + v.d_normal[c * num + j] * shear[c];
    for (int c = 0; c < gdim; ++c)
      dz[c * num + j] =
          out[j] * n[c] + (pressure - shear_n) * v.d_normal[c * num + j] + out[(1 + c) * num + j] - n[c] * d_along;
  }
}

LawPoints::Work LawPoints::work(std::size_t q) const
{
  Work out;
  if (_place[q] < 0)
    return out;
  const std::size_t p = _place[q];
  const double* n = _points.normal.data() + p * _gdim;
  const double* moved = _increment.data() + p * _gdim;
  const double along = dot(n, moved, _gdim);
  const double opened = _knows_gap[p] ? _points.gap[p] - _last_gap[q] : along;
  out.normal = -0.5 * (_last_pressure[q] + _tractions.pressure[p]) * opened;
  double last[3];
  turn(_gdim, n, _last_shear.data() + q * _gdim, last);
  for (int c = 0; c < _gdim; ++c)
    out.shear -= 0.5 * (last[c] + _shear[p * _gdim + c]) * (moved[c] - along * n[c]);
  return out;
}

/// Energy stored per area in the present state; where a law does not know it, the work done counts.
double LawPoints::stored(std::size_t q) const
{
  const std::int32_t p = _place[q];
  if (p < 0)
    return 0.0;
  if (_law->has_energy())
    return _tractions.energy[p];
  const Work done = work(q);
  const double shear =
      _tractions.shear_energy.empty() ? done.shear : _tractions.shear_energy[p] - _last_shear_stored[q];
  return _last_stored[q] + done.normal + shear;
}

double LawPoints::energy(std::span<const double> weight) const
{
  double out = 0.0;
  for (std::size_t q = 0; q < weight.size(); ++q)
    out += weight[q] * (_accepted ? _last_stored[q] : stored(q));
  return out;
}

/// The last evaluation of a point becomes its last converged state.
void LawPoints::keep(std::size_t q, double stored)
{
  const std::int32_t p = _place[q];
  _last_stored[q] = stored;
  _last_shear_stored[q] = p < 0 || _tractions.shear_energy.empty() ? 0.0 : _tractions.shear_energy[p];
  _last_gap[q] = p < 0 ? std::numeric_limits<double>::infinity() : _points.gap[p];
  _last_pressure[q] = pressure(q);
  for (int c = 0; c < _gdim; ++c)
    _last_shear[q * _gdim + c] = p < 0 ? 0.0 : _shear[p * _gdim + c];
}

void LawPoints::begin()
{
  for (std::size_t q = 0; q < _place.size(); ++q)
    keep(q, _place[q] >= 0 && _law->has_energy() ? _tractions.energy[_place[q]] : 0.0);
  _begun = 1.0;
  _accepted = true;
}

double LawPoints::accept(std::span<const double> weight)
{
  double dissipated = 0.0;
  if (std::exchange(_accepted, true))
    return dissipated;
  for (std::size_t q = 0; q < weight.size(); ++q)
  {
    const double now = stored(q);
    const Work done = work(q);
    dissipated += weight[q] * (done.normal + done.shear - (now - _last_stored[q]));
    keep(q, now);
  }
  _history.commit();
  return dissipated;
}

void LawPoints::resume()
{
  for (std::size_t q = 0; q < _place.size(); ++q)
    if (const std::int32_t p = _place[q]; p >= 0)
    {
      _tractions.pressure[p] = _last_pressure[q];
      turn(_gdim, _points.normal.data() + p * _gdim, _last_shear.data() + q * _gdim, _shear.data() + p * _gdim);
    }
  _begun = 1.0;
  _accepted = true;
}

std::vector<std::string> LawPoints::names() const
{
  std::vector<std::string> out{"law_begun", "law_gap", "law_pressure", "law_shear", "law_energy", "law_shear_energy"};
  for (const InterfaceHistory::Variable& v : _history.variables)
    out.push_back("law variable " + v.name);
  return out;
}

void LawPoints::add_to(state::State& out, std::size_t per_facet)
{
  using state::Place;
  out.add("law_begun", Place::all, _begun);
  out.add("law_gap", Place::facet, _last_gap, per_facet);
  out.add("law_pressure", Place::facet, _last_pressure, per_facet);
  out.add("law_shear", Place::facet, _last_shear, per_facet * _gdim);
  out.add("law_energy", Place::facet, _last_stored, per_facet);
  out.add("law_shear_energy", Place::facet, _last_shear_stored, per_facet);
  for (InterfaceHistory::Variable& v : _history.variables)
    out.add("law variable " + v.name, Place::facet, v.committed, per_facet * v.size);
}
} // namespace dolfinx_impact::enforcement
