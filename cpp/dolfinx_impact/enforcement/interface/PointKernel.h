// SPDX-License-Identifier: MIT
#pragma once
#include "../../kernels/Kernel.h"
#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// A kernel with one quadrature point on an interval, evaluated at many points: it takes as many of them at once as it
/// has lanes.
class PointKernel
{
public:
  /// @param[in] kernel of a form of forms/interface.py or forms/friction.py
  /// @param[in] what of which it is the kernel, for messages
  /// @param[in] constants by the kernel's names
  /// @throws std::invalid_argument for a kernel of another kind, or a constant that is missing
  PointKernel(const impact_kernel* kernel, std::string what,
              const std::vector<std::pair<std::string, double>>& constants);

  const impact_kernel& kernel() const { return *_kernel; }
  /// Change a constant.
  /// @throws std::invalid_argument if there is none of the name
  void set_constant(const std::string& name, double value);

  /// Values of one function of the kernel at the points of an evaluation.
  struct Input
  {
    const double* values;
    int size, offset;        ///< number of components; place in the kernel's array
    const std::int32_t* row; ///< of each point among the values; null: its own number
  };
  /// What the kernel has written for up to `lanes` points.
  struct Outputs
  {
    const double* A;
    std::size_t lanes, first, used; ///< number of the first point, and of points

    /// Write `size` values of each point into an array by point.
    void store(int offset, std::size_t size, double* values) const
    {
      for (std::size_t c = 0; c < size; ++c)
        for (std::size_t lane = 0; lane < used; ++lane)
          values[(first + lane) * size + c] = A[(offset + c) * lanes + lane];
    }
  };
  /// Evaluate the kernel. Within the largest kernel so far nothing is allocated.
  /// @param[in] num number of points
  /// @param[in] inputs of all its functions
  /// @param[in] take called with the Outputs of up to `lanes` points
  template <typename Take>
  void evaluate(std::size_t num, const std::vector<Input>& inputs, const Take& take) const
  {
    const std::size_t lanes = _lanes, size_A = _kernel->size_A;
    const Memory memory = this->memory();
    for (std::size_t first = 0; first < num; first += lanes)
    {
      const std::size_t used = std::min(lanes, num - first);
      std::fill_n(memory.A, size_A * lanes, 0.0);
      for (const Input& input : inputs)
        for (std::size_t lane = 0; lane < lanes; ++lane)
        {
          const std::size_t q = first + std::min(lane, used - 1); // lanes that are left over repeat the last point
          const std::size_t row = input.row ? std::size_t(input.row[q]) : q;
          for (std::size_t c = 0; c < std::size_t(input.size); ++c)
            memory.w[(input.offset + c) * lanes + lane] = input.values[row * input.size + c];
        }
      _tabulate(memory.A, memory.w, _constants.data(), memory.x, 0);
      take(Outputs{memory.A, lanes, first, used});
    }
  }

private:
  struct Memory
  {
    double *A, *w, *x;
  };
  Memory memory() const;

  const impact_kernel* _kernel;
  impact_tabulate _tabulate;
  int _lanes;
  std::string _what;
  std::vector<double> _constants;
};
} // namespace dolfinx_impact::enforcement
