// SPDX-License-Identifier: MIT
#include "FrictionLaw.h"
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
void FrictionPoints::resize(std::size_t num)
{
  pressure.resize(num);
  slip_rate.resize(num * gdim);
  normal.resize(num * gdim);
  for (auto* fields : {&slave_fields, &master_fields})
    for (std::vector<double>& values : *fields)
      values.resize(num);
}

FrictionLaw::FrictionLaw(const impact_kernel* kernel, int gdim,
                         const std::vector<std::pair<std::string, double>>& constants,
                         std::vector<InterfaceField> fields)
    : _kernel(kernel, "the law of friction", constants), _gdim(gdim), _fields(std::move(fields))
{
  if (gdim != 2 && gdim != 3)
    throw std::invalid_argument("a law of friction is of two or three dimensions");
  for (int k = 0; k < kernel->num_coefficients; ++k)
    _inputs.push_back(input(kernel->coefficients[k]));
  for (int k = 0; k < kernel->num_outputs; ++k)
  {
    const impact_output& o = kernel->outputs[k];
    const std::string name = o.name;
    if (name == "coefficient" && o.num_components == 1)
      _coefficient = o.offset;
    if (name == "derivative by pressure" && o.num_components == 1)
      _by_pressure = o.offset;
    if (name == "derivative by slip_rate" && o.num_components == gdim)
      _by_slip_rate = o.offset;
  }
  if (_coefficient < 0)
    throw std::invalid_argument("a law of friction returns a coefficient");
  _has_rates = _by_slip_rate >= 0;
  _given.reserve(_inputs.size());
}

FrictionLaw::Input FrictionLaw::input(const impact_coefficient& c) const
{
  const std::string name = c.name;
  Input out{Source::pressure, 0, c.element.num_dofs, c.offset};
  if (name == "pressure" && out.size == 1)
    return out;
  for (const auto& [wanted, source] : {std::pair("slip_rate", Source::slip_rate), std::pair("normal", Source::normal)})
    if (name == wanted && out.size == _gdim)
    {
      out.source = source;
      return out;
    }
  if (const auto side = field_side(name, _fields))
    return {side->slave ? Source::slave_field : Source::master_field, side->field, out.size, out.offset};
  throw std::invalid_argument("the law of friction reads " + name + ", which is not known here");
}

FrictionPoints FrictionLaw::make_points(std::size_t num_points) const
{
  FrictionPoints out;
  out.gdim = _gdim;
  out.slave_fields.resize(_fields.size());
  out.master_fields.resize(_fields.size());
  out.resize(num_points);
  return out;
}

const double* FrictionLaw::values(const Input& input, const FrictionPoints& points) const
{
  switch (input.source)
  {
  case Source::pressure:
    return points.pressure.data();
  case Source::slip_rate:
    return points.slip_rate.data();
  case Source::normal:
    return points.normal.data();
  case Source::slave_field:
    return points.slave_fields[input.number].data();
  case Source::master_field:
    break;
  }
  return points.master_fields[input.number].data();
}

void FrictionLaw::evaluate(const FrictionPoints& points, FrictionCoefficients& out) const
{
  const std::size_t num = points.size();
  out.value.resize(num);
  out.by_pressure.resize(_by_pressure >= 0 ? num : 0);
  out.by_slip_rate.resize(_by_slip_rate >= 0 ? num * _gdim : 0);
  _given.clear();
  for (const Input& input : _inputs)
    _given.push_back({values(input, points), input.size, input.offset, nullptr});
  _kernel.evaluate(num, _given,
                   [&](const PointKernel::Outputs& found)
                   {
                     found.store(_coefficient, 1, out.value.data());
                     if (_by_pressure >= 0)
                       found.store(_by_pressure, 1, out.by_pressure.data());
                     if (_by_slip_rate >= 0)
                       found.store(_by_slip_rate, _gdim, out.by_slip_rate.data());
                   });
  for (std::size_t q = 0; q < num; ++q)
    if (out.value[q] < 0.0)
    {
      out.value[q] = 0.0;
      if (_by_pressure >= 0)
        out.by_pressure[q] = 0.0;
      if (_by_slip_rate >= 0)
        std::fill_n(&out.by_slip_rate[q * _gdim], _gdim, 0.0);
    }
}
} // namespace dolfinx_impact::enforcement
