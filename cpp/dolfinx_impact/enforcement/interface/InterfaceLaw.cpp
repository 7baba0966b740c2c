// SPDX-License-Identifier: MIT
#include "InterfaceLaw.h"
#include <algorithm>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
namespace
{
const std::string by = "derivative by ", of_history = "history ";
} // namespace

InterfaceLaw::InterfaceLaw(const impact_kernel* kernel, int gdim,
                           const std::vector<std::pair<std::string, double>>& constants,
                           std::vector<InterfaceField> fields, const std::vector<std::string>& tangential, double reach)
    : _kernel(kernel, "a law of the interface", constants), _gdim(gdim), _reach(reach), _fields(std::move(fields))
{
  if (gdim != 2 && gdim != 3)
    throw std::invalid_argument("a law of the interface is of two or three dimensions");
  if (!(reach > 0.0))
    throw std::invalid_argument("the reach of a law of the interface is positive");
  for (int k = 0; k < kernel->num_outputs; ++k)
    if (const impact_output& o = kernel->outputs[k]; o.coefficient >= 0)
    {
      const bool turns = std::ranges::count(tangential, o.name) > 0;
      if (turns && o.num_components != gdim)
        throw std::invalid_argument(std::string("the internal variable ") + o.name + " is no vector along the surface");
      _variables.push_back({int(_history.variables.size()), o.num_components, o.offset});
      _history.variables.push_back({o.name, o.num_components, turns, {}, {}, {}});
    }
  for (int k = 0; k < kernel->num_coefficients; ++k)
    _inputs.push_back(input(kernel->coefficients[k]));
  for (const Input& i : _inputs)
    _has_rates |= i.source == Source::gap_rate || i.source == Source::slip_rate;
  for (int k = 0; k < kernel->num_outputs; ++k)
  {
    const impact_output& o = kernel->outputs[k];
    const std::string name = o.name;
    for (auto [wanted, offset] :
         {std::pair("pressure", &_pressure), std::pair("shear", &_shear), std::pair("energy", &_energy),
          std::pair("shear_energy", &_shear_energy), std::pair("sticks", &_sticks)})
      if (o.coefficient < 0 && name == wanted)
        *offset = o.offset;
    if (!name.starts_with(by))
      continue;
    std::string what = name.substr(by.size());
    if (what.starts_with(of_history))
      what = what.substr(of_history.size());
    const auto found = std::ranges::find_if(_inputs, [&](const Input& i)
                                            { return kernel->coefficients[&i - _inputs.data()].name == what; });
    if (found == _inputs.end() || o.num_components != (1 + gdim) * found->size)
      throw std::invalid_argument("the law of the interface has a derivative that does not fit: " + name);
    _derivatives.emplace_back(*found, o.offset);
    _has_shear |= found->source == Source::slip || found->source == Source::slip_rate ||
                  (found->source == Source::variable && _history.variables[found->number].tangential);
  }
  if (_pressure < 0 || _shear < 0)
    throw std::invalid_argument("a law of the interface returns a pressure and a shear traction");
}

InterfaceLaw::Input InterfaceLaw::input(const impact_coefficient& c) const
{
  const std::string name = c.name;
  Input out{Source::gap, 0, c.element.num_dofs, c.offset};
  const impact_kernel& kernel = _kernel.kernel();
  for (int k = 0; k < kernel.num_outputs; ++k)
    if (const impact_output& o = kernel.outputs[k]; o.coefficient >= 0 && &kernel.coefficients[o.coefficient] == &c)
    {
      const auto same = [&](const InterfaceHistory::Variable& v) { return v.name == o.name; };
      out.source = Source::variable;
      out.number = int(std::ranges::find_if(_history.variables, same) - _history.variables.begin());
      return out;
    }
  const std::pair<const char*, Source> scalars[] = {{"gap", Source::gap}, {"gap_rate", Source::gap_rate}};
  const std::pair<const char*, Source> vectors[] = {
      {"slip", Source::slip}, {"slip_rate", Source::slip_rate}, {"normal", Source::normal}};
  for (const auto& [wanted, source] : scalars)
    if (name == wanted && out.size == 1)
      return {source, 0, out.size, out.offset};
  for (const auto& [wanted, source] : vectors)
    if (name == wanted && out.size == _gdim)
      return {source, 0, out.size, out.offset};
  if (const auto side = field_side(name, _fields))
    return {side->slave ? Source::slave_field : Source::master_field, side->field, out.size, out.offset};
  throw std::invalid_argument("the law of the interface reads " + name + ", which is not known here");
}

InterfaceHistory InterfaceLaw::make_history(std::size_t num_points) const
{
  InterfaceHistory out = _history;
  out.resize(num_points);
  return out;
}

InterfacePoints InterfaceLaw::make_points(std::size_t num_points) const
{
  InterfacePoints out;
  out.gdim = _gdim;
  out.slave_fields.resize(_fields.size());
  out.master_fields.resize(_fields.size());
  out.resize(num_points);
  return out;
}

const double* InterfaceLaw::values(const Input& input, const InterfacePoints& points,
                                   const InterfaceHistory& history) const
{
  switch (input.source)
  {
  case Source::gap:
    return points.gap.data();
  case Source::slip:
    return points.slip.data();
  case Source::gap_rate:
    return points.gap_rate.data();
  case Source::slip_rate:
    return points.slip_rate.data();
  case Source::normal:
    return points.normal.data();
  case Source::slave_field:
    return points.slave_fields[input.number].data();
  case Source::master_field:
    return points.master_fields[input.number].data();
  case Source::variable:
    break;
  }
  const InterfaceHistory::Variable& variable = history.variables[input.number];
  return (variable.tangential ? variable.turned : variable.committed).data();
}

/// Where the i-th derivative of the kernel goes.
InterfaceDerivative& InterfaceLaw::derivative(InterfaceTractions& out, std::size_t i) const
{
  const Input& input = _derivatives[i].first;
  switch (input.source)
  {
  case Source::gap:
    return out.by_gap;
  case Source::slip:
    return out.by_slip;
  case Source::gap_rate:
    return out.by_gap_rate;
  case Source::slip_rate:
    return out.by_slip_rate;
  case Source::normal:
    return out.by_normal;
  default:
    return out.by_history[input.number];
  }
}

void InterfaceLaw::evaluate(const InterfacePoints& points, InterfaceHistory& history, InterfaceTractions& out) const
{
  const std::size_t num = points.size(), rows = 1 + std::size_t(_gdim);
  out.pressure.resize(num);
  out.shear.resize(num * _gdim);
  out.energy.resize(_energy >= 0 ? num : 0);
  out.shear_energy.resize(_shear_energy >= 0 ? num : 0);
  out.sticks.resize(_sticks >= 0 ? num : 0);
  out.by_history.resize(history.variables.size());
  for (std::size_t i = 0; i < _derivatives.size(); ++i)
  {
    InterfaceDerivative& d = derivative(out, i);
    d.size = _derivatives[i].first.size;
    d.values.resize(num * rows * d.size);
  }
  out.num_unsolved = 0;
  _given.clear();
  for (const Input& input : _inputs)
    _given.push_back({values(input, points, history), input.size, input.offset,
                      input.source == Source::variable ? points.row.data() : nullptr});
  const impact_kernel& kernel = _kernel.kernel();
  const auto take = [&](const PointKernel::Outputs& found)
  {
    found.store(_pressure, 1, out.pressure.data());
    found.store(_shear, _gdim, out.shear.data());
    for (auto [offset, values] : {std::pair(_energy, &out.energy), std::pair(_shear_energy, &out.shear_energy),
                                  std::pair(_sticks, &out.sticks)})
      if (offset >= 0)
        found.store(offset, 1, values->data());
    for (std::size_t i = 0; i < _derivatives.size(); ++i)
    {
      InterfaceDerivative& d = derivative(out, i);
      found.store(_derivatives[i].second, rows * d.size, d.values.data());
    }
    for (const Output& o : _variables)
      for (std::size_t c = 0; c < std::size_t(o.size); ++c)
        for (std::size_t lane = 0; lane < found.used; ++lane)
          history.variables[o.number].updated[std::size_t(points.row[found.first + lane]) * o.size + c] =
              found.A[(o.offset + c) * found.lanes + lane];
    if (kernel.local_unknowns > 0)
      for (std::size_t lane = 0; lane < found.used; ++lane)
        out.num_unsolved += found.A[(kernel.size_A - 3 - kernel.local_unknowns) * found.lanes + lane] > 0.0;
  };
  _kernel.evaluate(num, _given, take);
}
} // namespace dolfinx_impact::enforcement
