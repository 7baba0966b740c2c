// SPDX-License-Identifier: MIT
#include "frequency.h"
#include "../kernels/check.h"
#include "CellMatrix.h"
#include "CellValues.h"
#include "SymmetricMatrices.h"
#include "lanes.h"
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
/// Numbers of the degrees of freedom of two cells, from zero, in the order of their matrix: those that both have are
/// one.
int number_dofs(const FunctionSpace& V, std::span<const std::int32_t> cells, std::vector<int>& numbers)
{
  const auto& map = *V.dofmap();
  std::vector<std::int32_t> nodes;
  numbers.clear();
  for (const std::int32_t cell : cells)
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

constexpr int num_together = SymmetricMatrices::num;

/// Matrices of one size that wait until there are enough to find the ends of their spectra together: a matrix per lane.
class Waiting
{
public:
  explicit Waiting(int size)
      : _matrices(size), _stiffness(std::size_t(size) * size * num_together),
        _diagonals(std::size_t(size) * num_together)
  {
  }

  /// @param[in] entity number of the matrix, among the results
  /// @param[in] cell the first of the entity
  /// @param[in] m masses
  /// @returns the place of the matrix's first entry; one entry stands num_together behind the other, row by row
  double* add(std::size_t entity, std::int32_t cell, const double* m)
  {
    const int lane = _num++;
    _entities[lane] = {entity, cell};
    for (int i = 0; i < _matrices.size(); ++i)
      _diagonals[std::size_t(i) * num_together + lane] = 1.0 / std::sqrt(m[i]);
    return _stiffness.data() + lane;
  }
  /// Matrices of all lanes.
  AlignedVector& stiffness() { return _stiffness; }
  bool full() const { return _num == num_together; }
  /// Write the eigenvalues of what waits, [3*entity] and [3*entity + 1], and the Frobenius norm of the skew-symmetric
  /// part, scaled by the mass.
  /// @throws std::runtime_error if an entry is not a number
  void finish(std::vector<double>& out)
  {
    const auto norms = _matrices.set_scaled(_stiffness.data(), _diagonals.data());
    for (int lane = 0; lane < _num; ++lane)
      if (!std::isfinite(norms[lane].symmetric) || !std::isfinite(norms[lane].skew))
        throw std::runtime_error("the stiffness of cell " + std::to_string(_entities[lane].cell) +
                                 " of this rank is not a number");
    const auto ends = _matrices.extreme_eigenvalues();
    for (int lane = 0; lane < _num; ++lane)
    {
      double* const found = out.data() + 3 * _entities[lane].number;
      std::ranges::copy(ends[lane], found);
      found[2] = norms[lane].skew;
    }
    _num = 0;
  }
  bool empty() const { return _num == 0; }

private:
  struct Place
  {
    std::size_t number;
    std::int32_t cell;
  };

  SymmetricMatrices _matrices;
  AlignedVector _stiffness; ///< of all lanes; where nothing waits it is an earlier one, or zero
  AlignedVector _diagonals; ///< one over the root of the masses
  std::array<Place, num_together> _entities{};
  int _num = 0;
};

/// Spectra of entities whose matrices are all of the kernel's size: cells and exterior facets.
void find_spectra(const Integral& matrix, CellMatrix& kernel, CellValues& values, std::span<const double> masses,
                  std::vector<double>& out)
{
  const int n = kernel.num_rows(), stride = std::string(matrix.kernel->integral_type) == "cell" ? 1 : 2;
  const std::size_t size = std::size_t(n) * n, num = out.size() / 3, together = kernel.num_cells();
  const bool in_place = together == num_together; // the kernel has a matrix per lane as well
  Waiting waiting(n);
  AlignedVector own(in_place ? 0 : size * together);
  AlignedVector& K = in_place ? waiting.stiffness() : own;
  for (std::size_t e = 0; e < num; e += together)
  {
    const std::size_t count = std::min(together, num - e);
    const std::int32_t* given = matrix.entities.data() + stride * e;
    if (stride == 1)
      values.gather(std::span(given, count));
    else
      values.gather(given[0]);
    std::ranges::fill(K, 0.0);
    kernel.add(K.data(), values.w(), matrix.constants, values.nodes(), stride == 1 ? 0 : given[1]);
    for (std::size_t lane = 0; lane < count; ++lane)
    {
      double* const place = waiting.add(e + lane, given[stride * lane], masses.data() + (e + lane) * n);
      for (std::size_t k = 0; k < size && !in_place; ++k)
        place[k * num_together] = K[k * together + lane];
      if (waiting.full())
        waiting.finish(out);
    }
  }
  if (!waiting.empty())
    waiting.finish(out);
}

/// Spectra at facets between two cells, which share more degrees of freedom or less.
void find_joint_spectra(const Integral& matrix, const FunctionSpace& V, CellMatrix& kernel, CellValues& values,
                        std::span<const double> masses, std::vector<double>& out)
{
  const int n = kernel.num_rows();
  std::vector<double> K(std::size_t(n) * n), mass;
  std::vector<int> numbers;
  std::map<int, Waiting> of_size;
  for (std::size_t e = 0; e < out.size() / 3; ++e)
  {
    const std::span<const std::int32_t> entity = std::span(matrix.entities).subspan(3 * e, 3);
    for (int side = 0; side < 2; ++side)
      values.gather(entity[side], side);
    std::ranges::fill(K, 0.0);
    kernel.add(K.data(), values.w(), matrix.constants, values.nodes(), entity[2]);
    const int size = number_dofs(V, entity.first(2), numbers);
    mass.assign(size, 0.0);
    for (int i = 0; i < n; ++i)
      mass[numbers[i]] += masses[e * n + i];
    Waiting& waiting = of_size.try_emplace(size, size).first->second;
    double* const place = waiting.add(e, entity[0], mass.data());
    for (int k = 0; k < size * size; ++k)
      place[std::size_t(k) * num_together] = 0.0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        place[(std::size_t(size) * numbers[i] + numbers[j]) * num_together] += K[std::size_t(n) * i + j];
    if (waiting.full())
      waiting.finish(out);
  }
  for (auto& [size, waiting] : of_size)
    if (!waiting.empty())
      waiting.finish(out);
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
  CellValues values(k, V, coefficients, kernel.num_cells());
  std::vector<double> out(3 * num);
  if (sides == 2)
    find_joint_spectra(matrix, V, kernel, values, masses, out);
  else
    find_spectra(matrix, kernel, values, masses, out);
  return out;
}
} // namespace dolfinx_impact::operators
