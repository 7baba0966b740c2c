// SPDX-License-Identifier: MIT
#include "HeightField.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace dolfinx_impact::gap
{
namespace
{
/// Four cubic B-splines that do not vanish at a place, with two derivatives; beyond the grid each goes on straight.
struct Basis
{
  int first;
  double value[4], slope[4], bend[4];

  Basis(double a, double low, double spacing, int cells)
  {
    const double end = low + spacing * cells, inside = std::clamp(a, low, end), beyond = a - inside;
    const double cell = (inside - low) / spacing;
    first = cell > 0.0 ? std::min(int(cell), cells - 1) : 0; // 0 where it is not a number, in runs that break
    const double t = (inside - low) / spacing - first, s = 1.0 - t;
    const double values[4] = {s * s * s / 6, (4 - 6 * t * t + 3 * t * t * t) / 6, (4 - 6 * s * s + 3 * s * s * s) / 6,
                              t * t * t / 6};
    const double slopes[4] = {-s * s / 2, (3 * t * t - 4 * t) / 2, -(3 * s * s - 4 * s) / 2, t * t / 2};
    const double bends[4] = {s, 3 * t - 2, 3 * s - 2, t};
    for (int k = 0; k < 4; ++k)
    {
      slope[k] = slopes[k] / spacing;
      value[k] = values[k] + beyond * slope[k];
      bend[k] = beyond == 0.0 ? bends[k] / (spacing * spacing) : 0.0;
    }
  }
};
} // namespace

HeightField::HeightField(int gdim, const std::array<double, 3>& origin,
                         const std::array<std::array<double, 3>, 3>& axes, const Grid& grid,
                         std::vector<double> coefficients)
    : _gdim(gdim), _origin(origin), _axes(axes), _grid(grid), _coefficients(std::move(coefficients))
{
  std::size_t size = 1;
  for (int c = 0; c < gdim - 1; ++c)
  {
    if (grid.cells[c] < 1 || !(grid.spacing[c] > 0.0))
      throw std::invalid_argument("the grid of a height field needs cells of positive size");
    size *= grid.cells[c] + 3;
  }
  if ((gdim != 2 && gdim != 3) || _coefficients.size() != size)
    throw std::invalid_argument("a height field of " + std::to_string(size) + " splines has " +
                                std::to_string(_coefficients.size()) + " coefficients");
}

double HeightField::largest_coordinate() const
{
  // Splines lie in the hull of their coefficients: the corners of the grid's box bound all points.
  double reach = 0.0;
  for (double z : _coefficients)
    reach = std::max(reach, std::abs(z));
  for (int c = 0; c < _gdim - 1; ++c)
    reach += std::max(std::abs(_grid.low[c]), std::abs(_grid.low[c] + _grid.spacing[c] * _grid.cells[c]));
  double largest = 0.0;
  for (double x : _origin)
    largest = std::max(largest, std::abs(x));
  return largest + reach;
}

HeightField::Height HeightField::height(const double* a) const
{
  Height out{};
  const Basis one(a[0], _grid.low[0], _grid.spacing[0], _grid.cells[0]);
  if (_gdim == 2)
  {
    for (int i = 0; i < 4; ++i)
    {
      const double c = _coefficients[one.first + i];
      out.value += c * one.value[i];
      out.slope[0] += c * one.slope[i];
      out.bend[0] += c * one.bend[i];
    }
    return out;
  }
  const Basis two(a[1], _grid.low[1], _grid.spacing[1], _grid.cells[1]);
  const std::size_t row = _grid.cells[1] + 3;
  for (int i = 0; i < 4; ++i)
  {
    double value = 0.0, slope = 0.0, bend = 0.0;
    const double* c = _coefficients.data() + (one.first + i) * row + two.first;
    for (int j = 0; j < 4; ++j)
    {
      value += c[j] * two.value[j];
      slope += c[j] * two.slope[j];
      bend += c[j] * two.bend[j];
    }
    out.value += one.value[i] * value;
    out.slope[0] += one.slope[i] * value;
    out.slope[1] += one.value[i] * slope;
    out.bend[0] += one.bend[i] * value;
    out.bend[1] += one.slope[i] * slope;
    out.bend[2] += one.value[i] * bend;
  }
  return out;
}

RigidPoint HeightField::closest(std::span<const double> x) const
{
  const int tdim = _gdim == 2 ? 1 : 2;
  double at[2] = {}, z = 0.0;
  for (int c = 0; c < _gdim; ++c)
  {
    const double d = x[c] - _origin[c];
    for (int k = 0; k < tdim; ++k)
      at[k] += d * _axes[k][c];
    z += d * _axes[tdim][c];
  }
  // Newton's method for half the squared distance, from the foot of z; where that is not convex without its curvature.
  double a[2] = {at[0], at[1]};
  Height h = height(a);
  const auto half_square = [&](const double* b, const Height& g)
  {
    double sum = (z - g.value) * (z - g.value);
    for (int k = 0; k < tdim; ++k)
      sum += (at[k] - b[k]) * (at[k] - b[k]);
    return 0.5 * sum;
  };
  double now = half_square(a, h);
  for (int iteration = 0; iteration < 50; ++iteration)
  {
    double r[2] = {}, H[3] = {1.0, 0.0, 1.0};
    for (int k = 0; k < tdim; ++k)
      r[k] = (at[k] - a[k]) + (z - h.value) * h.slope[k];
    const double full[3] = {1.0 + h.slope[0] * h.slope[0], h.slope[0] * h.slope[1], 1.0 + h.slope[1] * h.slope[1]};
    for (int k = 0; k < 3; ++k)
      H[k] = full[k] - (z - h.value) * h.bend[k];
    if (!(H[0] > 0.0) || !(H[0] * H[2] - H[1] * H[1] > 0.0))
      std::copy_n(full, 3, H);
    const double det = H[0] * H[2] - H[1] * H[1];
    double step[2] = {(H[2] * r[0] - H[1] * r[1]) / det, (H[0] * r[1] - H[1] * r[0]) / det};
    const double decrease = step[0] * r[0] + step[1] * r[1];
    const double size =
        std::max(std::abs(step[0]) / _grid.spacing[0], tdim == 2 ? std::abs(step[1]) / _grid.spacing[1] : 0.0);
    double b[2] = {};
    Height g = h;
    double there = now;
    double part = 1.0;
    for (int halvings = 0; halvings < 20; ++halvings, part *= 0.5)
    {
      for (int k = 0; k < tdim; ++k)
        b[k] = a[k] + part * step[k];
      g = height(b);
      there = half_square(b, g);
      if (there <= now - 0.1 * part * decrease || size < 1e-6)
        break;
    }
    std::copy_n(b, 2, a);
    h = g;
    now = there;
    if (size < 1e-9) // of a cell; the gap's error is of second order
      break;
  }
  RigidPoint out{};
  const double w = std::sqrt(1.0 + h.slope[0] * h.slope[0] + h.slope[1] * h.slope[1]);
  double tangent[2][3] = {}, normal[3] = {};
  for (int c = 0; c < _gdim; ++c)
  {
    normal[c] = _axes[tdim][c];
    for (int k = 0; k < tdim; ++k)
    {
      normal[c] -= h.slope[k] * _axes[k][c];
      tangent[k][c] = _axes[k][c] + h.slope[k] * _axes[tdim][c];
    }
  }
  double gap = z - h.value;
  for (int k = 0; k < tdim; ++k)
    gap -= h.slope[k] * (at[k] - a[k]);
  out.gap = gap / w;
  for (int c = 0; c < _gdim; ++c)
    out.normal[c] = normal[c] / w;
  // dn/dx = - sum p^k [b (G - gap b)^-1]_ki p_i, p_i the tangents, G their products, b the second fundamental form.
  const double G[3] = {1.0 + h.slope[0] * h.slope[0], h.slope[0] * h.slope[1], 1.0 + h.slope[1] * h.slope[1]};
  const double b[3] = {h.bend[0] / w, h.bend[1] / w, h.bend[2] / w};
  double M[3];
  for (int k = 0; k < 3; ++k)
    M[k] = G[k] - out.gap * b[k];
  const double det = M[0] * M[2] - M[1] * M[1], det_G = G[0] * G[2] - G[1] * G[1];
  if (!(std::abs(det) > 1e-12 * det_G))
    return out; // the centre of curvature
  const double I[3] = {M[2] / det, -M[1] / det, M[0] / det};
  const double A[2][2] = {{b[0] * I[0] + b[1] * I[1], b[0] * I[1] + b[1] * I[2]},
                          {b[1] * I[0] + b[2] * I[1], b[1] * I[1] + b[2] * I[2]}};
  double dual[2][3];
  for (int c = 0; c < 3; ++c)
  {
    dual[0][c] = (G[2] * tangent[0][c] - G[1] * tangent[1][c]) / det_G;
    dual[1][c] = (G[0] * tangent[1][c] - G[1] * tangent[0][c]) / det_G;
  }
  for (int c = 0; c < _gdim; ++c)
    for (int d = 0; d < _gdim; ++d)
      for (int k = 0; k < tdim; ++k)
        for (int i = 0; i < tdim; ++i)
          out.hessian[3 * c + d] -= dual[k][c] * A[k][i] * tangent[i][d];
  return out;
}
} // namespace dolfinx_impact::gap
