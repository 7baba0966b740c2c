// SPDX-License-Identifier: MIT
#include "timing.h"
#include "KernelTable.h"
#include <algorithm>
#include <basix/finite-element.h>
#include <chrono>
#include <dolfinx/mesh/cell_types.h>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::kernels
{
namespace
{
constexpr int num_rounds = 5;
constexpr double round_seconds = 1e-5; ///< long against the clock's resolution, some 30 ns

/// Memory as kernels take it: aligned to lines of the cache.
struct alignas(64) Line
{
  double values[8];
};

/// An array of lines that begins with n values.
std::vector<Line> lines(std::size_t n)
{
  return std::vector<Line>(n / 8 + 1); // of none, there is one that can be pointed to
}

/// Arrays of a kernel for one width.
class Call
{
public:
  Call(const impact_kernel& kernel, const std::vector<double>& nodes, int width)
      : _tabulate(tabulate(kernel, width)), _width(width), _A(lines(std::size_t(kernel.size_A) * width)),
        _w(lines(std::size_t(kernel.size_w) * width)), _x(lines(nodes.size() * width)), _c(kernel.size_c, 1.0)
  {
    // No zeros, and nothing the same in two lanes; small beside the cell, as displacements are.
    for (std::size_t i = 0; i < std::size_t(kernel.size_w) * width; ++i)
      entry(_w, i) = 1e-3 * (1.0 + 0.1 * double(i % 11));
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (int lane = 0; lane < width; ++lane)
        entry(_x, i * width + lane) = nodes[i] * (1.0 + 0.01 * lane);
  }

  /// Time of some calls [s].
  double seconds(int calls)
  {
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < calls; ++i)
      _tabulate(&entry(_A, 0), &entry(_w, 0), _c.data(), &entry(_x, 0), 0);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }

  int width() const { return _width; }

private:
  static double& entry(std::vector<Line>& array, std::size_t i) { return array[i / 8].values[i % 8]; }

  impact_tabulate _tabulate;
  int _width;
  std::vector<Line> _A, _w, _x;
  std::vector<double> _c;
};
} // namespace

std::vector<double> reference_nodes(const impact_kernel& kernel)
{
  const auto cell = dolfinx::mesh::cell_type_to_basix_type(dolfinx::mesh::to_type(kernel.cell));
  const auto element =
      basix::create_element<double>(basix::element::family::P, cell, kernel.geometry_degree,
                                    static_cast<basix::element::lagrange_variant>(kernel.geometry_variant),
                                    basix::element::dpc_variant::unset, false);
  const auto& [points, shape] = element.points();
  const int sides = std::string(kernel.integral_type) == "interior_facet" ? 2 : 1;
  std::vector<double> x(3 * sides * shape[0], 0.0);
  for (int side = 0; side < sides; ++side)
    for (std::size_t i = 0; i < shape[0]; ++i)
      for (std::size_t d = 0; d < shape[1]; ++d)
        x[3 * (side * shape[0] + i) + d] = points[shape[1] * i + d];
  return x;
}

std::vector<double> seconds_per_cell(const impact_kernel& kernel, const std::vector<int>& widths)
{
  const std::vector<double> nodes = reference_nodes(kernel);
  std::vector<Call> calls;
  std::vector<int> counts;
  std::vector<double> least;
  for (const int w : widths)
  {
    if (width(kernel, w) != w)
      throw std::invalid_argument(std::string("kernel ") + kernel.name + " runs on this machine, but not with " +
                                  std::to_string(w) + " cells at once");
    Call& call = calls.emplace_back(kernel, nodes, w);
    call.seconds(1); // fetches code and arrays
    const double once = call.seconds(1);
    counts.push_back(std::clamp(int(round_seconds / std::max(once, 1e-9)), 1, 1000));
    least.push_back(once / w);
  }
  for (int round = 0; round < num_rounds; ++round)
    for (std::size_t i = 0; i < calls.size(); ++i)
      least[i] = std::min(least[i], calls[i].seconds(counts[i]) / (counts[i] * calls[i].width()));
  return least;
}

int fastest_width(const impact_kernel& kernel, const std::vector<int>& widths)
{
  constexpr double margin = 0.75;
  static std::map<const impact_kernel*, int> found;
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  if (const auto known = found.find(&kernel); known != found.end())
    return known->second;
  const std::vector<double> seconds = seconds_per_cell(kernel, widths);
  std::size_t best = 0;
  for (std::size_t i = 1; i < widths.size(); ++i)
    if (seconds[i] < margin * seconds[best])
      best = i;
  return found[&kernel] = widths.at(best);
}
} // namespace dolfinx_impact::kernels
