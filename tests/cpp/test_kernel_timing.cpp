// SPDX-License-Identifier: MIT
// Cells per kernel call are chosen by measurement: a kernel that is slow in its widest form runs in a narrower one.
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cstdlib>
#include <dolfinx_impact/kernels/FloatKernel.h>
#include <dolfinx_impact/kernels/KernelTable.h>
#include <dolfinx_impact/kernels/timing.h>

using namespace dolfinx_impact;

namespace
{
void quick(double* A, const double* w, const double*, const double* x, int)
{
  A[0] += w[0] * x[3];
}

/// Some hundred times as long as `quick`.
void slow(double* A, const double* w, const double* c, const double* x, int)
{
  for (int i = 0; i < 1000; ++i)
    quick(A, w + i % 2, c, x, 0);
}

void quick_in_float(float* A, const float* w, const double*, const float* x)
{
  A[0] += w[0] * x[3];
}

/// Some hundred times as long.
void slow_in_float(float* A, const float* w, const double* c, const float* x)
{
  for (int i = 0; i < 1000; ++i)
    quick_in_float(A, w + i % 2, c, x);
}

/// An energy of a triangle.
impact_kernel kernel(const char* type)
{
  impact_kernel k{};
  k.abi = IMPACT_KERNEL_ABI;
  k.name = "made_up";
  k.integral_type = type;
  k.cell = "triangle";
  k.geometry_degree = 1;
  k.gdim = 2;
  k.shape[0] = k.shape[1] = 1;
  k.size_A = 1;
  k.size_w = 2;
  k.tabulate[0] = k.tabulate[1] = k.tabulate[2] = quick;
  return k;
}

/// Number in `tabulate` of the widest one that the processor has.
int widest_slot()
{
  return kernels::processor_width() == 8 ? 2 : 1;
}
} // namespace

TEST_CASE("width: the widest, unless a narrower one is faster by a cell")
{
  if (std::getenv("IMPACT_SIMD_WIDTH") || kernels::processor_width() == 1)
    SKIP("there is nothing to choose");
  static const impact_kernel equal = kernel("cell"); // a call of any width takes the same time
  CHECK(kernels::width(equal) == kernels::processor_width());

  static impact_kernel spills = kernel("cell");
  spills.tabulate[widest_slot()] = slow;
  CHECK(kernels::width(spills) == kernels::processor_width() / (kernels::processor_width() == 8 ? 2 : 4));
  CHECK(kernels::width(spills, kernels::processor_width()) == kernels::processor_width()); // as asked for

  static impact_kernel point = kernel("expression");
  point.tabulate[widest_slot()] = slow;
  CHECK(kernels::width(point) == kernels::processor_width());
}

TEST_CASE("width: a kernel that was compiled for single cells only")
{
  static impact_kernel alone = kernel("cell");
  alone.tabulate[1] = alone.tabulate[2] = nullptr;
  CHECK(kernels::width(alone) == 1);
  CHECK_THROWS_WITH(kernels::seconds_per_cell(alone, {4}),
                    Catch::Matchers::ContainsSubstring("made_up") && Catch::Matchers::ContainsSubstring("4 cells"));
}

TEST_CASE("seconds per cell tell a slow kernel from a quick one")
{
  impact_kernel k = kernel("interior_facet");
  CHECK(kernels::reference_nodes(k).size() == 18);
  const double fast = kernels::seconds_per_cell(k, {1}).at(0);
  k.tabulate[0] = slow;
  CHECK(fast > 0.0);
  CHECK(kernels::seconds_per_cell(k, {1}).at(0) > 10.0 * fast);
}

TEST_CASE("float_functions: whole vectors of 512 bits where they are faster, else halves")
{
  static const impact_kernel in_double = kernel("cell");
  const auto in_float = [](impact_float_tabulate whole, impact_float_tabulate half)
  { return impact_float_kernel{&in_double, {quick_in_float, quick_in_float, whole, half}, {}}; };
  const auto also_quick = [](float* A, const float* w, const double* c, const float* x) { quick_in_float(A, w, c, x); };
  CHECK(kernels::float_functions(in_float(quick_in_float, quick_in_float), 1).lanes == 4);
  CHECK(kernels::float_functions(in_float(quick_in_float, quick_in_float), 4).lanes == 8);
  // A call takes the same time for 16 cells as for 8.
  CHECK(kernels::float_functions(in_float(quick_in_float, also_quick), 8).lanes == 16);
  const kernels::FloatFunctions found = kernels::float_functions(in_float(slow_in_float, quick_in_float), 8);
  if (kernels::environment_width() == 0)
    CHECK((found.lanes == 8 && found.tabulate == quick_in_float));
  else
    CHECK((found.lanes == 16 && found.tabulate == slow_in_float));
}
