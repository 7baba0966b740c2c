// SPDX-License-Identifier: MIT
#include "NodalPressure.h"
#include "Model.h"
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

namespace impact_reference
{
NodalPressure::NodalPressure(const Model& model) : model_(model)
{
  if (not is_simplex(model.geometry().cell) or model.geometry().degree != 1 or model.field().degree != 1)
    throw std::invalid_argument("pressure is averaged at the nodes of tetrahedra and triangles of degree 1 only");
  if (model.hypothesis() != Hypothesis::solid and model.hypothesis() != Hypothesis::plane_strain)
    throw std::invalid_argument("pressure is averaged at nodes in space and in plane strain only");
}

/// Volume of a simplex (area in the plane) by its edges from the first vertex, and what moving a vertex changes of it.
NodalPressure::Volume NodalPressure::volume(const Matrix& x)
{
  const Eigen::Index d = x.cols();
  Volume out{0, Matrix::Zero(d + 1, d)};
  if (d == 2)
  {
    const double ax = x(1, 0) - x(0, 0), ay = x(1, 1) - x(0, 1), bx = x(2, 0) - x(0, 0), by = x(2, 1) - x(0, 1);
    out.value = (ax * by - ay * bx) / 2;
    out.slope << 0, 0, by / 2, -bx / 2, -ay / 2, ax / 2;
  }
  else
  {
    const Eigen::Vector3d a = (x.row(1) - x.row(0)).transpose(), b = (x.row(2) - x.row(0)).transpose(),
                          c = (x.row(3) - x.row(0)).transpose();
    out.value = a.dot(b.cross(c)) / 6;
    out.slope.row(1) = b.cross(c).transpose() / 6;
    out.slope.row(2) = c.cross(a).transpose() / 6;
    out.slope.row(3) = a.cross(b).transpose() / 6;
  }
  out.slope.row(0) = -out.slope.colwise().sum();
  return out;
}

NodalPressure::Answer NodalPressure::at_nodes(const Vector& u, bool small, const std::function<Law(int)>& law) const
{
  return evaluate(u, small, law, true);
}

NodalPressure::Answer NodalPressure::in_cells(const Vector& u, bool small, const std::function<Law(int)>& law) const
{
  return evaluate(u, small, law, false);
}

NodalPressure::Answer NodalPressure::evaluate(const Vector& u, bool small, const std::function<Law(int)>& law,
                                              bool nodes) const
{
  model_.check_vector(u);
  const std::int64_t num_cells = model_.num_cells();
  const int d = model_.gdim(), n = d + 1;
  std::vector<Volume> rest, now;
  std::vector<double> J;
  for (std::int64_t c = 0; c < num_cells; ++c)
  {
    const Matrix X = model_.cell_points(c);
    const Vector ue = model_.gather(u, c);
    Matrix x = X;
    for (int a = 0; a < n; ++a)
      for (int i = 0; i < d; ++i)
        x(a, i) += ue(d * a + i);
    rest.push_back(volume(X));
    now.push_back(small ? rest.back() : volume(x));
    const double ratio = small ? 1 + (x - X).cwiseProduct(rest.back().slope).sum() / rest.back().value
                               : now.back().value / rest.back().value;
    if (not small and not(ratio > 0))
      throw std::domain_error("the deformation turns cell " + std::to_string(c) + " inside out");
    J.push_back(ratio);
  }
  // A node has one mean for each material around it.
  typedef std::pair<std::int64_t, int> Place;
  const auto place = [&](std::int64_t cell, std::int64_t node)
  { return nodes ? Place(node, model_.tag(cell)) : Place(cell, model_.tag(cell)); };
  std::map<Place, double> volumes, means;
  for (std::int64_t c = 0; c < num_cells; ++c)
  {
    const Law own = law(model_.tag(c));
    for (const std::int64_t node : model_.cell_nodes(c))
    {
      const double share = rest[c].value / n;
      volumes[place(c, node)] += share;
      means[place(c, node)] += share * own.measure(J[c]);
    }
  }
  Answer answer{Vector::Zero(u.size()), 0};
  for (auto& [where, mean] : means)
  {
    mean /= volumes[where];
    answer.energy += volumes[where] * law(where.second).energy(mean);
  }
  for (std::int64_t c = 0; c < num_cells; ++c)
  {
    const Law own = law(model_.tag(c));
    double pressure = 0;
    for (const std::int64_t node : model_.cell_nodes(c))
      pressure += own.pressure(means[place(c, node)]) / n;
    Vector force(n * d);
    for (int a = 0; a < n; ++a)
      for (int i = 0; i < d; ++i)
        force(d * a + i) = pressure * own.measure_slope(J[c]) * now[c].slope(a, i);
    model_.scatter(answer.force, d, c, force);
  }
  return answer;
}

NodalPressure::Law squared_law(double lambda, bool small)
{
  const auto energy = [=](double m) { return lambda / 2 * m * m; };
  const auto pressure = [=](double m) { return lambda * m; };
  if (small)
    return {[](double J) { return J - 1; }, [](double) { return 1.0; }, energy, pressure};
  return {[](double J) { return std::log(J); }, [](double J) { return 1 / J; }, energy, pressure};
}

NodalPressure::Law plastic_law(double bulk, bool small)
{
  if (small)
    return squared_law(bulk, true);
  return {[](double J) { return J; }, [](double) { return 1.0; }, [=](double J)
          { return bulk / 2 * ((J * J - 1) / 2 - std::log(J)); }, [=](double J) { return bulk / 2 * (J - 1 / J); }};
}
} // namespace impact_reference
