// SPDX-License-Identifier: MIT
#include "frequency.h"
#include "../kernels/check.h"
#include "CellMatrix.h"
#include "CellValues.h"
#include "SymmetricMatrix.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <unordered_map>

namespace dolfinx_impact::operators
{
std::vector<double> cell_spectra(const Integral& matrix, const FunctionSpace& V,
                                 const std::map<std::string, std::shared_ptr<const Function>>& coefficients,
                                 std::span<const double> masses)
{
  const impact_kernel& k = *matrix.kernel;
  const int n = k.shape[0], stride = std::string(k.integral_type) == "exterior_facet" ? 2 : 1;
  const std::size_t num = matrix.entities.size() / stride;
  kernels::check_mesh(k, *V.mesh());
  kernels::check_space(k, k.arguments[0], V, "space");
  CellMatrix kernel(k);
  if (int(matrix.constants.size()) != k.size_c || kernel.num_columns() != n)
    throw std::invalid_argument(std::string("kernel ") + k.name + " is not a stiffness with its constants");
  if (masses.size() != num * n)
    throw std::invalid_argument("cell_frequencies takes a mass for every degree of freedom of every cell");
  CellValues values(k, V, coefficients);
  std::vector<double> K(std::size_t(n) * n), out;
  out.reserve(3 * num);
  SymmetricMatrix A(n);
  std::unordered_map<long long, std::vector<std::pair<Traces, std::array<double, 2>>>> known;
  for (std::size_t e = 0; e < num; ++e)
  {
    const std::int32_t cell = matrix.entities[stride * e];
    values.gather(cell);
    std::fill(K.begin(), K.end(), 0.0);
    kernel.add(K.data(), values.w(), matrix.constants, values.nodes(),
               stride == 2 ? matrix.entities[stride * e + 1] : 0);
    const double* m = masses.data() + e * n;
    double skew = 0.0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
      {
        const double to = K[std::size_t(n) * i + j], fro = K[std::size_t(n) * j + i];
        A(i, j) = 0.5 * (to + fro) / std::sqrt(m[i] * m[j]);
        skew += 0.25 * (to - fro) * (to - fro) / (m[i] * m[j]);
      }
    const Traces t = A.traces();
    if (!std::isfinite(t.second))
      throw std::runtime_error("the stiffness of cell " + std::to_string(cell) + " of this rank is not a number");
    auto& bucket = known[std::llround(1e9 * std::log(std::max(t.second, 1e-300)))];
    auto same = std::find_if(bucket.begin(), bucket.end(), [&](const auto& entry) { return entry.first == t; });
    if (same == bucket.end())
    {
      bucket.push_back({t, A.extreme_eigenvalues()});
      same = bucket.end() - 1;
    }
    out.insert(out.end(), {same->second[0], same->second[1], std::sqrt(skew)});
  }
  return out;
}

std::vector<double> cell_frequencies(const Integral& stiffness, const FunctionSpace& V,
                                     const std::map<std::string, std::shared_ptr<const Function>>& coefficients,
                                     std::span<const double> masses)
{
  const std::vector<double> spectra = cell_spectra(stiffness, V, coefficients, masses);
  std::vector<double> out(spectra.size() / 3);
  for (std::size_t e = 0; e < out.size(); ++e)
    out[e] = std::max(0.0, spectra[3 * e + 1]);
  return out;
}
} // namespace dolfinx_impact::operators
