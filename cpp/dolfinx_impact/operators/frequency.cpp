// SPDX-License-Identifier: MIT
#include "frequency.h"
#include "../kernels/check.h"
#include "CellMatrix.h"
#include "CellValues.h"
#include "SymmetricMatrices.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

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

/// Matrices of one size that wait until there are enough to find the ends of their spectra together.
class Waiting
{
public:
  explicit Waiting(int size) : _matrices(size) {}

  /// @param[in] entity number of the matrix, among the results
  /// @param[in] S, m matrix, row by row, and masses
  /// @returns the Frobenius norm of the skew-symmetric part, scaled by the mass; not finite if an entry is not
  double add(std::size_t entity, const double* S, const double* m)
  {
    const int size = _matrices.size(), which = _num++;
    _entities[which] = entity;
    _scale.resize(size);
    for (int i = 0; i < size; ++i)
      _scale[i] = 1.0 / std::sqrt(m[i]);
    double skew = 0.0, all = 0.0;
    for (int i = 0; i < size; ++i)
      for (int j = 0; j <= i; ++j)
      {
        const double to = S[std::size_t(size) * i + j], fro = S[std::size_t(size) * j + i], s = _scale[i] * _scale[j];
        const double even = 0.5 * (to + fro) * s, odd = 0.5 * (to - fro) * s;
        _matrices(which, i, j) = even;
        all += even * even;
        skew += 2.0 * odd * odd; // of both entries; the diagonal has none
      }
    return std::isfinite(all) ? std::sqrt(skew) : all;
  }
  bool full() const { return _num == SymmetricMatrices::num; }
  /// Write the eigenvalues of what waits, [3*entity] and [3*entity + 1].
  void finish(std::vector<double>& out)
  {
    if (_num == 0)
      return;
    const int size = _matrices.size();
    for (int which = _num; which < SymmetricMatrices::num; ++which)
      for (int i = 0; i < size; ++i)
        for (int j = 0; j <= i; ++j)
          _matrices(which, i, j) = 0.0;
    const auto ends = _matrices.extreme_eigenvalues();
    for (int which = 0; which < _num; ++which)
      std::copy_n(ends[which].begin(), 2, out.begin() + 3 * std::ptrdiff_t(_entities[which]));
    _num = 0;
  }

private:
  SymmetricMatrices _matrices;
  std::array<std::size_t, SymmetricMatrices::num> _entities{};
  std::vector<double> _scale; ///< one over the root of the masses
  int _num = 0;
};
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
  std::vector<double> K(std::size_t(n) * n), out(3 * num), reduced, mass;
  std::vector<int> numbers;
  std::map<int, Waiting> of_size; // two cells share more degrees of freedom or less
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
    Waiting& waiting = of_size.try_emplace(size, size).first->second;
    out[3 * e + 2] = waiting.add(e, S, m);
    if (!std::isfinite(out[3 * e + 2]))
      throw std::runtime_error("the stiffness of cell " + std::to_string(entity.cells[0]) +
                               " of this rank is not a number");
    if (waiting.full())
      waiting.finish(out);
  }
  for (auto& [size, waiting] : of_size)
    waiting.finish(out);
  return out;
}
} // namespace dolfinx_impact::operators
