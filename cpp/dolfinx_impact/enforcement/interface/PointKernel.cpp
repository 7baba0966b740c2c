// SPDX-License-Identifier: MIT
#include "PointKernel.h"
#include "../../kernels/KernelTable.h"
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
namespace
{
/// The first entry of an aligned array inside a vector that has room for it.
double* aligned(std::vector<double>& memory, std::size_t& begin, std::size_t size)
{
  constexpr std::size_t line = 64 / sizeof(double);
  const std::size_t past = (reinterpret_cast<std::uintptr_t>(memory.data() + begin) / sizeof(double)) % line;
  double* out = memory.data() + begin + (past ? line - past : 0);
  begin = std::size_t(out - memory.data()) + size;
  return out;
}
} // namespace

PointKernel::PointKernel(const impact_kernel* kernel, std::string what,
                         const std::vector<std::pair<std::string, double>>& constants)
    : _kernel(kernel), _what(std::move(what))
{
  if (!kernel || kernel->rank != 0 || kernel->num_points != 1)
    throw std::invalid_argument(_what + " is a kernel with one point");
  _lanes = kernels::width(*kernel);
  _tabulate = kernels::tabulate(*kernel, _lanes);
  _constants.assign(kernel->size_c, std::nan(""));
  for (const auto& [name, value] : constants)
    for (int k = 0; k < kernel->num_constants; ++k)
      if (kernel->constants[k].name == name)
        _constants[kernel->constants[k].offset] = value;
  for (int k = 0; k < kernel->num_constants; ++k)
    if (std::isnan(_constants[kernel->constants[k].offset]))
      throw std::invalid_argument(_what + " needs the parameter " + kernel->constants[k].name);
}

void PointKernel::set_constant(const std::string& name, double value)
{
  for (int k = 0; k < _kernel->num_constants; ++k)
    if (_kernel->constants[k].name == name)
    {
      _constants[_kernel->constants[k].offset] = value;
      return;
    }
  throw std::invalid_argument(_what + " has no parameter " + name);
}

PointKernel::Memory PointKernel::memory() const
{
  thread_local std::vector<double> memory;
  const std::size_t size_A = _kernel->size_A, size_w = _kernel->size_w, lanes = _lanes;
  memory.resize(std::max(memory.size(), (size_A + size_w + 6) * lanes + 3 * 8));
  std::size_t begin = 0;
  Memory out{};
  out.A = aligned(memory, begin, size_A * lanes);
  out.w = aligned(memory, begin, size_w * lanes);
  out.x = aligned(memory, begin, 6 * lanes);
  // The point's cell is the interval from 0 to 1.
  for (std::size_t k = 0; k < 6; ++k)
    std::fill_n(out.x + k * lanes, lanes, k == 3 ? 1.0 : 0.0);
  return out;
}
} // namespace dolfinx_impact::enforcement
