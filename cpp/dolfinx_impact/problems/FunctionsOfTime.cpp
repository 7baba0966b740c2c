// SPDX-License-Identifier: MIT
#include "FunctionsOfTime.h"
#include "../common/OnAllRanks.h"
#include "../common/agree.h"
#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace dolfinx_impact::problems
{
void FunctionOfTime::sample(std::span<const double> times, std::span<double> values) const
{
  _sample(times, values);
  const auto bad = std::ranges::find_if_not(values, [](double value) { return std::isfinite(value); });
  if (bad == values.end())
    return;
  std::ostringstream text;
  text << _name << " is " << *bad << " at the time " << times[(bad - values.begin()) / _size];
  throw std::invalid_argument(text.str());
}

double FunctionOfTime::at(double time) const
{
  double value = 0.0;
  if (_size != 1)
    throw std::invalid_argument(_name + " has three components: one is needed");
  sample({&time, 1}, {&value, 1});
  return value;
}

int FunctionsOfTime::add(FunctionOfTime function)
{
  const int first = _num_columns;
  _num_columns += function.size();
  _functions.push_back(std::move(function));
  return first;
}

std::vector<double> FunctionsOfTime::table(std::span<const double> times) const
{
  std::vector<double> out(times.size() * _num_columns), part;
  int column = 0;
  for (const FunctionOfTime& f : _functions)
  {
    part.resize(times.size() * f.size());
    f.sample(times, part);
    for (std::size_t k = 0; k < times.size(); ++k)
      std::copy_n(part.begin() + k * f.size(), f.size(), out.begin() + k * _num_columns + column);
    column += f.size();
  }
  return out;
}

std::vector<double> FunctionsOfTime::table_on_all_ranks(MPI_Comm comm, std::span<const double> times) const
{
  if (!_source)
  {
    std::vector<double> out;
    common::agree(comm, [&] { out = table(times); });
    return out;
  }
  std::vector<double> out = _source(times);
  if (out.size() != times.size() * _num_columns)
    throw common::BadValue("a table of functions of time has another size");
  return out;
}
} // namespace dolfinx_impact::problems
