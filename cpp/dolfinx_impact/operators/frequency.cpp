#include "frequency.h"
#include "../kernels/KernelTable.h"
#include "../kernels/check.h"
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <dolfinx/fem/DofMap.h>
#include <stdexcept>
#include <unordered_map>

namespace impact::operators
{
namespace
{
/// Traces of the powers one to three: matrices that have them in common are those of congruent cells.
struct Traces
{
  double first, second, third;

  bool operator==(const Traces& other) const
  {
    const auto same = [](double a, double b) { return std::abs(a - b) <= 1e-12 * std::abs(a); };
    return same(first, other.first) && same(second, other.second) && same(third, other.third);
  }
};

Traces traces(const Eigen::MatrixXd& A, Eigen::MatrixXd& square)
{
  square.noalias() = A * A;
  return {A.trace(), A.squaredNorm(), square.cwiseProduct(A).sum()};
}
} // namespace

std::vector<double> cell_frequencies(const Integral& stiffness, const FunctionSpace& V,
                                     const std::map<std::string, std::shared_ptr<const Function>>& coefficients,
                                     std::span<const double> masses)
{
  const impact_kernel& k = *stiffness.kernel;
  const auto& mesh = *V.mesh();
  kernels::check_mesh(k, mesh);
  kernels::check_space(k, k.arguments[0], V, "space");
  const int n = k.shape[0];
  if (k.rank != 2 || int(stiffness.constants.size()) != k.size_c || k.shape[1] != n)
    throw std::invalid_argument(std::string("kernel ") + k.name + " is not a stiffness with its constants");
  if (masses.size() != stiffness.entities.size() * n)
    throw std::invalid_argument("cell_frequencies takes a mass for every degree of freedom of every cell");
  std::vector<std::shared_ptr<const Function>> functions;
  for (int i = 0; i < k.num_coefficients; ++i)
  {
    const auto found = coefficients.find(k.coefficients[i].name);
    if (found == coefficients.end())
      throw std::invalid_argument(std::string("kernel ") + k.name + " needs a coefficient named '" +
                                  k.coefficients[i].name + "'");
    kernels::check_space(k, k.coefficients[i].element, *found->second->function_space(), found->first);
    functions.push_back(found->second);
  }
  const impact_tabulate tabulate = kernels::tabulate(k, 1);
  const auto x_dofmap = mesh.geometry().dofmap();
  const auto x = mesh.geometry().x();
  std::vector<double> K(std::size_t(n) * n), w(k.size_w), nodes(3 * x_dofmap.extent(1)), out;
  Eigen::MatrixXd A(n, n), square(n, n);
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(n);
  std::unordered_map<long long, std::vector<std::pair<Traces, double>>> known;
  for (std::size_t e = 0; e < stiffness.entities.size(); ++e)
  {
    const std::int32_t cell = stiffness.entities[e];
    for (std::size_t i = 0; i < x_dofmap.extent(1); ++i)
      std::copy_n(x.data() + 3 * std::size_t(x_dofmap(cell, i)), 3, nodes.data() + 3 * i);
    for (int c = 0; c < k.num_coefficients; ++c)
    {
      const auto& map = *functions[c]->function_space()->dofmap();
      const auto dofs = map.cell_dofs(cell);
      const std::span<const double> values = functions[c]->x()->array();
      for (std::size_t i = 0; i < dofs.size(); ++i)
        for (int b = 0; b < map.bs(); ++b)
          w[k.coefficients[c].offset + i * map.bs() + b] = values[std::size_t(dofs[i]) * map.bs() + b];
    }
    std::fill(K.begin(), K.end(), 0.0);
    tabulate(K.data(), w.data(), stiffness.constants.data(), nodes.data(), 0);
    const double* m = masses.data() + e * n;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) // the symmetric part: what a tangent of follower loads adds does not move bounds
        A(i, j) = 0.5 * (K[std::size_t(n) * i + j] + K[std::size_t(n) * j + i]) / std::sqrt(m[i] * m[j]);
    const Traces t = traces(A, square);
    if (!std::isfinite(t.second))
      throw std::runtime_error("the stiffness of cell " + std::to_string(cell) + " of this rank is not a number");
    auto& bucket = known[std::llround(1e9 * std::log(std::max(t.second, 1e-300)))];
    const auto same = std::find_if(bucket.begin(), bucket.end(), [&](const auto& entry) { return entry.first == t; });
    if (same != bucket.end())
    {
      out.push_back(same->second);
      continue;
    }
    solver.compute(A, Eigen::EigenvaluesOnly);
    out.push_back(std::max(0.0, solver.eigenvalues()[n - 1]));
    bucket.emplace_back(t, out.back());
  }
  return out;
}
} // namespace impact::operators
