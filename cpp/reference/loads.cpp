// SPDX-License-Identifier: MIT
#include "element.h"
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace impact_reference
{
namespace
{
void check_load(const Vector& load, int gdim, const char* what)
{
  if (load.size() != gdim and load.size() != 1)
    throw std::invalid_argument(std::string(what) + " needs " + std::to_string(gdim) + " components, but " +
                                std::to_string(load.size()) + " were given");
  if (not load.allFinite())
    throw std::invalid_argument(std::string(what) + " holds a value that is NaN or infinite");
}

double circumference(bool axisymmetric, double radius)
{
  return axisymmetric ? 2 * std::numbers::pi * radius : 1;
}
} // namespace

Vector body_force(const Sampler& sampler, const Matrix& X, const Vector& f, std::int64_t cell)
{
  check_load(f, sampler.gdim(), "the body force");
  const int k = int(f.size());
  Vector result = Vector::Zero(k * sampler.num_nodes());
  for (int q = 0; q < sampler.num_points(); ++q)
  {
    const Sample s = sampler.at(X, q, cell);
    for (int i = 0; i < sampler.num_nodes(); ++i)
      result.segment(k * i, k) += s.weight * s.N(i) * f;
  }
  return result;
}

Matrix poisson(const Sampler& sampler, const Matrix& X, double k, std::int64_t cell)
{
  if (not std::isfinite(k))
    throw std::invalid_argument("the conductivity is NaN or infinite");
  Matrix result = Matrix::Zero(sampler.num_nodes(), sampler.num_nodes());
  for (int q = 0; q < sampler.num_points(); ++q)
  {
    const Sample s = sampler.at(X, q, cell);
    result += (k * s.weight) * s.dN.lazyProduct(s.dN.transpose());
  }
  return result;
}

Vector traction(const FacetSampler& sampler, const Matrix& X, int facet, const Vector& t)
{
  check_load(t, tdim(sampler.cell()), "the traction");
  const std::vector<int> nodes = facet_nodes(sampler.cell(), sampler.degree(), facet);
  const int k = int(t.size());
  Vector result = Vector::Zero(k * node_vertices(sampler.cell(), sampler.degree()).size());
  for (int q = 0; q < sampler.num_points(); ++q)
  {
    const FacetSample s = sampler.at(X, facet, q);
    const double area = s.weight * area_vector(s.tangent).norm() * circumference(sampler.axisymmetric(), s.radius);
    for (std::size_t i = 0; i < nodes.size(); ++i)
      result.segment(k * nodes[i], k) += area * s.N(i) * t;
  }
  return result;
}

Matrix foundation(const FacetSampler& sampler, const Matrix& X, int facet, const Vector& k)
{
  const int d = tdim(sampler.cell());
  check_load(k, d, "the foundation");
  if (k.minCoeff() < 0)
    throw std::invalid_argument("the foundation has a negative stiffness or damping");
  const std::vector<int> nodes = facet_nodes(sampler.cell(), sampler.degree(), facet);
  const auto size = Eigen::Index(d * node_vertices(sampler.cell(), sampler.degree()).size());
  Matrix result = Matrix::Zero(size, size);
  for (int q = 0; q < sampler.num_points(); ++q)
  {
    const FacetSample s = sampler.at(X, facet, q);
    const Vector area = area_vector(s.tangent);
    // The columns of N^T are where a displacement of the surface goes in the cell.
    Eigen::MatrixXd N = Eigen::MatrixXd::Zero(d, size);
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (int c = 0; c < d; ++c)
        N(c, d * nodes[i] + c) = s.N(Eigen::Index(i));
    Eigen::MatrixXd D = k.size() == 1 and d > 1 ? Eigen::MatrixXd(k(0) * area * area.transpose() / area.squaredNorm())
                                                : Eigen::MatrixXd(k.asDiagonal());
    D *= s.weight * area.norm() * circumference(sampler.axisymmetric(), s.radius);
    const Eigen::MatrixXd DN = D.lazyProduct(N);
    result += N.transpose().lazyProduct(DN);
  }
  return result;
}

Follower follower_pressure(const FacetSampler& sampler, const Matrix& X, const Vector& u, int facet, double p)
{
  const int d = tdim(sampler.cell()), n = int(node_vertices(sampler.cell(), sampler.degree()).size());
  if (u.size() != d * n)
    throw std::invalid_argument("the element has " + std::to_string(d * n) + " degrees of freedom, but " +
                                std::to_string(u.size()) + " values were given");
  if (not u.allFinite() or not std::isfinite(p))
    throw std::invalid_argument("the displacement or the pressure holds a value that is NaN or infinite");
  const std::vector<int> nodes = facet_nodes(sampler.cell(), sampler.degree(), facet);
  const Matrix U = Eigen::Map<const Matrix>(u.data(), n, d)(nodes, Eigen::all);
  Follower result{Vector::Zero(d * n), Matrix::Zero(d * n, d * n)};
  for (int q = 0; q < sampler.num_points(); ++q)
  {
    const FacetSample s = sampler.at(X, facet, q);
    const Matrix tangent = s.tangent + U.transpose().lazyProduct(s.dN);
    const Vector normal = area_vector(tangent);
    const double radius = s.radius + (sampler.axisymmetric() ? U.col(0).dot(s.N) : 0);
    const double around = circumference(sampler.axisymmetric(), radius);
    for (std::size_t j = 0; j < nodes.size(); ++j)
      for (int c = 0; c < d; ++c)
      {
        // Derivative of the area vector: replace one tangent at a time by N_j,xi e_c.
        Vector change = Vector::Zero(d);
        for (int b = 0; b < d - 1; ++b)
        {
          Matrix varied = tangent;
          varied.col(b) = s.dN(j, b) * Vector::Unit(d, c);
          change += area_vector(varied);
        }
        change *= around;
        if (sampler.axisymmetric() and c == 0)
          change += 2 * std::numbers::pi * s.N(j) * normal;
        for (std::size_t i = 0; i < nodes.size(); ++i)
          result.tangent.col(d * nodes[j] + c).segment(d * nodes[i], d) -= s.weight * p * s.N(i) * change;
      }
    for (std::size_t i = 0; i < nodes.size(); ++i)
      result.force.segment(d * nodes[i], d) -= s.weight * p * s.N(i) * around * normal;
  }
  return result;
}
} // namespace impact_reference
