// SPDX-License-Identifier: MIT
#include "rigid.h"
#include "SymmetricEigen.h"
#include <numeric>

namespace impact_reference
{
namespace
{
// Union-find over nodes that share a cell; each body is named by its smallest node.
std::vector<std::vector<std::int64_t>> bodies(const Field& field)
{
  std::vector<std::int64_t> parent(field.points.rows());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](std::int64_t i)
  {
    while (parent[i] != i)
      i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::int64_t c = 0; c < field.cells.rows(); ++c)
    for (std::int64_t node : field.cells.row(c))
    {
      const std::int64_t a = root(node), b = root(field.cells(c, 0));
      parent[std::max(a, b)] = std::min(a, b);
    }
  std::map<std::int64_t, std::vector<std::int64_t>> lists;
  for (std::size_t i = 0; i < parent.size(); ++i)
    lists[root(std::int64_t(i))].push_back(std::int64_t(i));
  std::vector<std::vector<std::int64_t>> result;
  result.reserve(lists.size());
  for (auto& [first, list] : lists)
    result.push_back(std::move(list));
  return result;
}

std::string describe(const Vector& mode, int gdim, bool axisymmetric)
{
  const std::vector<std::string> plane{"translation x", "translation y", "rotation about z"};
  const std::vector<std::string> solid{"translation x",    "translation y",    "translation z",
                                       "rotation about x", "rotation about y", "rotation about z"};
  if (axisymmetric)
    return "translation z (the axial direction)";
  std::string text;
  for (int k = 0; k < mode.size(); ++k)
    if (std::abs(mode(k)) > 0.05)
      text += (text.empty() ? "" : " + ") + (gdim == 2 ? plane : solid)[k];
  return text;
}
} // namespace

Matrix rigid_motions(const Matrix& points, const Vector& centre, bool axisymmetric)
{
  const int d = int(points.cols()), count = axisymmetric ? 1 : (d == 2 ? 3 : 6);
  Matrix modes = Matrix::Zero(d * points.rows(), count);
  for (int i = 0; i < points.rows(); ++i)
  {
    const Vector x = points.row(i).transpose() - centre;
    if (axisymmetric)
    {
      modes(d * i + 1, 0) = 1;
      continue;
    }
    modes.block(d * i, 0, d, d).setIdentity();
    if (d == 2)
      modes.block(2 * i, 2, 2, 1) << -x(1), x(0);
    else
      for (int k = 0; k < 3; ++k)
        modes.block(3 * i, 3 + k, 3, 1) = Eigen::Vector3d::Unit(k).cross(Eigen::Vector3d(x));
  }
  return modes;
}

Matrix Model::rigid_modes() const
{
  return rigid_motions(field_.points, field_.points.colwise().mean().transpose(),
                       hypothesis_ == Hypothesis::axisymmetric);
}

std::string free_rigid_motions(const Model& model, const std::vector<bool>& fixed)
{
  const int d = model.gdim();
  const bool axisymmetric = model.hypothesis() == Hypothesis::axisymmetric;
  std::string text;
  for (const auto& nodes : bodies(model.field()))
  {
    const Matrix points = model.field().points(nodes, Eigen::all);
    Matrix modes = rigid_motions(points, points.colwise().mean().transpose(), axisymmetric);
    const double size = (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm();
    if (not axisymmetric)
      modes.rightCols(modes.cols() - d) /= size;
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(modes.cols(), modes.cols());
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (int a = 0; a < d; ++a)
        if (fixed[d * nodes[i] + a])
          gram += modes.row(d * i + a).transpose() * modes.row(d * i + a);
    const SymmetricEigen solver(gram);
    // Squares of arm / size: 1e-13 still sees a support arm of 3e-7 of the body.
    for (int k = 0; k < gram.rows(); ++k)
      if (solver.eigenvalues()(k) < 1e-13)
        text += (text.empty() ? "" : "; ") + describe(solver.eigenvectors().col(k), d, axisymmetric) +
                " of the body with node " + std::to_string(nodes[0]);
  }
  return text;
}
} // namespace impact_reference
