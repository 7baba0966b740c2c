// SPDX-License-Identifier: MIT
#include "frequency.h"
#include "../kernels/check.h"
#include "CellMatrix.h"
#include "CellValues.h"
#include "SymmetricMatrix.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <stdexcept>
#include <unordered_map>

namespace dolfinx_impact::operators
{
namespace
{
/// Cells of entity e of a list of Batches.h's Integral, and what the kernel takes as its entity.
struct Entity
{
  std::span<const std::int32_t> cells;
  int facet;
};

/// Numbers of an entity's degrees of freedom, from zero, in the order of its matrix: those that two cells share are
/// one.
int number_dofs(const FunctionSpace& V, const Entity& entity, std::vector<int>& numbers)
{
  const auto& map = *V.dofmap();
  std::vector<std::int32_t> nodes;
  numbers.clear();
  for (const std::int32_t cell : entity.cells)
    for (const std::int32_t node : map.cell_dofs(cell))
    {
      const auto found = std::find(nodes.begin(), nodes.end(), node);
      const int number = int(found - nodes.begin());
      if (found == nodes.end())
        nodes.push_back(node);
      for (int b = 0; b < map.bs(); ++b)
        numbers.push_back(number * map.bs() + b);
    }
  return int(nodes.size()) * map.bs();
}
} // namespace

std::vector<double> cell_spectra(const Integral& matrix, const FunctionSpace& V,
                                 const std::map<std::string, std::shared_ptr<const Function>>& coefficients,
                                 std::span<const double> masses)
{
  const impact_kernel& k = *matrix.kernel;
  const std::string type = k.integral_type;
  const int n = k.shape[0], sides = type == "interior_facet" ? 2 : 1, stride = type == "cell" ? 1 : 1 + sides;
  const std::size_t num = matrix.entities.size() / stride;
  kernels::check_mesh(k, *V.mesh());
  kernels::check_space(k, k.arguments[0], V, "space");
  CellMatrix kernel(k);
  if (int(matrix.constants.size()) != k.size_c || kernel.num_columns() != n)
    throw std::invalid_argument(std::string("kernel ") + k.name + " is not a stiffness with its constants");
  if (masses.size() != num * n)
    throw std::invalid_argument("cell_spectra takes a mass for every degree of freedom of every cell of an entity");
  CellValues values(k, V, coefficients);
  std::vector<double> K(std::size_t(n) * n), out;
  out.reserve(3 * num);
  std::vector<int> numbers;
  std::vector<double> reduced, mass, scale; // scale: one over the root of the masses
  std::map<int, SymmetricMatrix> of_size;   // two cells share more degrees of freedom or less
  std::unordered_map<long long, std::vector<std::pair<Traces, std::array<double, 2>>>> known;
  for (std::size_t e = 0; e < num; ++e)
  {
    const std::int32_t* given = matrix.entities.data() + stride * e;
    const Entity entity{{given, std::size_t(sides)}, type == "cell" ? 0 : given[sides]};
    for (int side = 0; side < sides; ++side)
      values.gather(entity.cells[side], side);
    std::fill(K.begin(), K.end(), 0.0);
    kernel.add(K.data(), values.w(), matrix.constants, values.nodes(), entity.facet);
    const double *m = masses.data() + e * n, *S = K.data();
    int size = n;
    if (sides == 2)
    {
      size = number_dofs(V, entity, numbers);
      reduced.assign(std::size_t(size) * size, 0.0);
      mass.assign(size, 0.0);
      for (int i = 0; i < n; ++i)
      {
        mass[numbers[i]] += m[i];
        for (int j = 0; j < n; ++j)
          reduced[std::size_t(size) * numbers[i] + numbers[j]] += K[std::size_t(n) * i + j];
      }
      m = mass.data(), S = reduced.data();
    }
    SymmetricMatrix& A = of_size.try_emplace(size, size).first->second;
    scale.resize(size);
    for (int i = 0; i < size; ++i)
      scale[i] = 1.0 / std::sqrt(m[i]);
    double skew = 0.0;
    for (int i = 0; i < size; ++i)
      for (int j = 0; j <= i; ++j)
      {
        const double to = S[std::size_t(size) * i + j], fro = S[std::size_t(size) * j + i], s = scale[i] * scale[j];
        A(i, j) = A(j, i) = 0.5 * (to + fro) * s;
        skew += 0.5 * (to - fro) * (to - fro) * s * s; // of both entries; the diagonal has none
      }
    const Traces t = A.traces();
    if (!std::isfinite(t.second))
      throw std::runtime_error("the stiffness of cell " + std::to_string(entity.cells[0]) +
                               " of this rank is not a number");
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
} // namespace dolfinx_impact::operators
