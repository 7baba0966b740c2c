// SPDX-License-Identifier: MIT
#include "NodalStrain.h"
#include "Model.h"
#include <Eigen/Dense>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

namespace impact_reference
{
NodalStrain::NodalStrain(const Model& model) : model_(model)
{
  const NodalPressure same_cells(model);
}

NodalPressure::Answer NodalStrain::at_nodes(const Vector& u, const std::function<Law(int)>& law) const
{
  model_.check_vector(u);
  const int d = model_.gdim(), n = d + 1;
  typedef std::pair<std::int64_t, int> Place; // a node has one mean for each material around it
  std::map<Place, double> volumes;
  std::map<Place, Matrix> means;
  for (std::int64_t c = 0; c < model_.num_cells(); ++c)
  {
    const NodalPressure::Volume cell = NodalPressure::volume(model_.cell_points(c));
    const Vector ue = model_.gather(u, c);
    Matrix integral = Matrix::Zero(d, d); // of the displacement gradient
    for (int a = 0; a < n; ++a)
      for (int i = 0; i < d; ++i)
        for (int j = 0; j < d; ++j)
          integral(i, j) += ue(d * a + i) * cell.slope(a, j);
    for (const std::int64_t node : model_.cell_nodes(c))
    {
      const Place place(node, model_.tag(c));
      means.try_emplace(place, Matrix::Zero(d, d)).first->second += integral / n;
      volumes[place] += cell.value / n;
    }
  }
  NodalPressure::Answer answer{Vector::Zero(u.size()), 0};
  std::map<Place, Matrix> stresses;
  for (auto& [place, mean] : means)
  {
    mean /= volumes[place];
    const Law own = law(place.second);
    answer.energy += volumes[place] * own.energy(mean);
    stresses[place] = own.stress(mean);
  }
  for (std::int64_t c = 0; c < model_.num_cells(); ++c)
  {
    const NodalPressure::Volume cell = NodalPressure::volume(model_.cell_points(c));
    Matrix stress = Matrix::Zero(d, d);
    for (const std::int64_t node : model_.cell_nodes(c))
      stress += stresses[Place(node, model_.tag(c))] / n;
    Vector force(n * d);
    for (int a = 0; a < n; ++a)
      for (int i = 0; i < d; ++i)
        force(d * a + i) = stress.row(i).dot(cell.slope.row(a));
    model_.scatter(answer.force, d, c, force);
  }
  return answer;
}

NodalStrain::Law squared_strain_law(double mu)
{
  return {[=](const Matrix& H) { return mu * ((H + H.transpose()) / 2).squaredNorm(); },
          [=](const Matrix& H) { return Matrix(mu * (H + H.transpose())); }};
}

NodalStrain::Law stretched_law(double mu)
{
  const auto stretch = [](const Matrix& H)
  {
    const Matrix F = Matrix::Identity(H.rows(), H.cols()) + H;
    if (not(F.determinant() > 0))
      throw std::domain_error("the deformation turns the cells around a node inside out");
    return F;
  };
  return {[=](const Matrix& H)
          {
            const Matrix F = stretch(H);
            return mu / 2 * (F.squaredNorm() - double(F.rows())) - mu * std::log(F.determinant());
          },
          [=](const Matrix& H)
          {
            const Matrix F = stretch(H);
            return Matrix(mu * (F - F.inverse().transpose()));
          }};
}
} // namespace impact_reference
