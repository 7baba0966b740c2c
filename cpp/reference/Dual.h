// SPDX-License-Identifier: MIT
#pragma once
#include <cmath>

namespace impact_reference
{
/// A number with its derivatives by N variables (forward automatic differentiation; Griewank & Walther 2008, ch. 3).
/// Contact is coded once, on a scalar type T: with T = double it gives values, with T = Dual<N> exact tangents.
/// Comparisons look at the value alone, so that derivatives are those of the branch taken.
template <int N>
struct Dual
{
  /// Derivatives; plain loops, which compile in a fraction of the time of Eigen's expressions.
  struct Gradient
  {
    double c[N] = {};
    double& operator()(int i) { return c[i]; }
    double operator()(int i) const { return c[i]; }
  };
  double v = 0; ///< value
  Gradient d;   ///< derivatives

  Dual() = default;
  Dual(double value) : v(value) {}

  /// Variable number i.
  static Dual variable(double value, int i)
  {
    Dual x(value);
    x.d(i) = 1;
    return x;
  }

  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  friend Dual operator-(const Dual& a)
  {
    return of(-a.v, [&](int i) { return -a.d(i); });
  }
  friend Dual operator+(const Dual& a, const Dual& b)
  {
    return of(a.v + b.v, [&](int i) { return a.d(i) + b.d(i); });
  }
  friend Dual operator-(const Dual& a, const Dual& b)
  {
    return of(a.v - b.v, [&](int i) { return a.d(i) - b.d(i); });
  }
  friend Dual operator*(const Dual& a, const Dual& b)
  {
    return of(a.v * b.v, [&](int i) { return a.v * b.d(i) + b.v * a.d(i); });
  }
  friend Dual operator/(const Dual& a, const Dual& b)
  {
    const double q = a.v / b.v;
    return of(q, [&](int i) { return (a.d(i) - q * b.d(i)) / b.v; });
  }
  friend Dual operator*(double a, const Dual& b)
  {
    return of(a * b.v, [&](int i) { return a * b.d(i); });
  }
  friend Dual operator*(const Dual& a, double b) { return b * a; }
  friend Dual operator/(const Dual& a, double b)
  {
    return of(a.v / b, [&](int i) { return a.d(i) / b; });
  }
  friend Dual operator+(const Dual& a, double b) { return with_value(a, a.v + b); }
  friend Dual operator+(double a, const Dual& b) { return b + a; }
  friend Dual operator-(const Dual& a, double b) { return with_value(a, a.v - b); }
  friend Dual operator-(double a, const Dual& b)
  {
    return of(a - b.v, [&](int i) { return -b.d(i); });
  }

  /// A value, and its derivatives by number.
  template <typename Derivative>
  static Dual of(double value, Derivative derivative)
  {
    Dual x(value);
    for (int i = 0; i < N; ++i)
      x.d(i) = derivative(i);
    return x;
  }

private:
  static Dual with_value(Dual x, double value)
  {
    x.v = value;
    return x;
  }
};

inline double value(double a)
{
  return a;
}
template <int N>
double value(const Dual<N>& a)
{
  return a.v;
}

inline double root(double a)
{
  return std::sqrt(a);
}
template <int N>
Dual<N> root(const Dual<N>& a)
{
  const double r = std::sqrt(a.v);
  return Dual<N>::of(r, [&](int i) { return a.d(i) / (2 * r); });
}

/// Vector of three components; in the plane the third is zero.
template <typename T>
struct Vec
{
  T c[3] = {T(0), T(0), T(0)};
  T& operator[](int i) { return c[i]; }
  const T& operator[](int i) const { return c[i]; }
  friend Vec operator+(const Vec& a, const Vec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
  friend Vec operator-(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
  friend Vec operator*(const T& s, const Vec& a) { return {s * a[0], s * a[1], s * a[2]}; }
  friend T dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
  friend T norm(const Vec& a) { return root(dot(a, a)); }
  friend Vec cross(const Vec& a, const Vec& b)
  {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }
  friend Vec unit(const Vec& a) { return (1.0 / norm(a)) * a; }
};

/// Values as numbers of another type, without derivatives.
template <typename T>
Vec<T> constant(const Vec<double>& a)
{
  return {T(a[0]), T(a[1]), T(a[2])};
}
template <typename T>
Vec<double> values(const Vec<T>& a)
{
  return {value(a[0]), value(a[1]), value(a[2])};
}
} // namespace impact_reference
