// SPDX-License-Identifier: MIT
#include "FloatKernel.h"
#include "KernelTable.h"
#include "timing.h"
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <limits>
#include <map>
#include <mutex>
#include <vector>

namespace dolfinx_impact::kernels
{
extern const impact_float_kernel* const generated_float_table[]; // written by forms/compiler/build.py
extern const std::size_t generated_float_table_size;

const impact_float_kernel* find_float(const impact_kernel& kernel)
{
  // Kernels that are placed on the cells of a tag are copies of those of the table, with the same functions.
  for (std::size_t i = 0; i < generated_float_table_size; ++i)
    if (generated_float_table[i]->kernel->tabulate[0] == kernel.tabulate[0])
      return generated_float_table[i];
  return nullptr;
}

namespace
{
FloatFunctions functions(const impact_float_kernel& kernel, int variant)
{
  constexpr int lanes[IMPACT_FLOAT_VARIANTS] = {4, 8, 16, 8};
  return {lanes[variant], kernel.tabulate[variant], kernel.sweep[variant]};
}

/// Memory as kernels take it: aligned to lines of the cache.
struct alignas(64) Line
{
  float values[16];
};
typedef std::vector<Line> Lines;

/// Time per cell, with the arrays in the cache [s].
double seconds(const impact_kernel& kernel, const FloatFunctions& functions)
{
  constexpr int num_rounds = 5, num_calls = 50;
  const std::vector<double> nodes = reference_nodes(kernel); // the first one is the origin
  const auto lines = [&](std::size_t size) { return Lines(size * functions.lanes / 16 + 1); };
  const auto entry = [](Lines& of, std::size_t i) -> float& { return of[i / 16].values[i % 16]; };
  Lines A = lines(std::size_t(kernel.shape[0])), w = lines(std::size_t(kernel.size_w)), x = lines(nodes.size());
  for (std::size_t i = 0; i < std::size_t(kernel.size_w) * functions.lanes; ++i)
    entry(w, i) = 1e-3f * float(i % 11);
  for (std::size_t i = 0; i < nodes.size() * functions.lanes; ++i)
    entry(x, i) = float(nodes[i / functions.lanes]);
  const std::vector<double> constants(std::size_t(kernel.size_c), 0.3);
  double least = std::numeric_limits<double>::infinity();
  for (int round = 0; round < num_rounds; ++round)
  {
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < num_calls; ++i)
      functions.tabulate(A[0].values, w[0].values, constants.data(), x[0].values);
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
    least = std::min(least, time.count() / (num_calls * functions.lanes));
  }
  return least;
}

/// Variants for processors that compute eight cells in double at a time: whole vectors, and halves.
constexpr int whole = 2, half = 3;

/// Whole vectors have to be faster by a tenth: where they are not at all, noise of the measurement must not choose.
bool takes_halves(const impact_float_kernel& kernel)
{
  constexpr double margin = 0.9;
  static std::map<impact_float_tabulate, bool> known;
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  const auto [place, is_new] = known.try_emplace(kernel.tabulate[whole]);
  if (is_new)
    place->second =
        seconds(*kernel.kernel, functions(kernel, whole)) > margin * seconds(*kernel.kernel, functions(kernel, half));
  return place->second;
}
} // namespace

FloatFunctions float_functions(const impact_float_kernel& kernel, int width)
{
  if (width != 8)
    return functions(kernel, width == 4 ? 1 : 0);
  return functions(kernel, environment_width() == 0 && takes_halves(kernel) ? half : whole);
}
} // namespace dolfinx_impact::kernels
