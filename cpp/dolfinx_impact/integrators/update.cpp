// SPDX-License-Identifier: MIT
#include "update.h"
#include "../common/clones.h"

namespace dolfinx_impact::integrators
{
namespace
{
/// Four entries at once: what a node of three components takes. Compilers keep the sums of `omp simd reduction` in
/// memory, where each step of the loop waits for the last one's stores.
typedef double Lanes __attribute__((vector_size(4 * sizeof(double)), may_alias));
constexpr std::size_t width = sizeof(Lanes) / sizeof(double);

/// Sums of the entries that one lane, or one of four, has seen.
template <typename T>
struct PartialSums
{
  T momentum{}, speed{}, old_speed{}, position{}, before{}, after{}, load_before{}, load_after{};
};

/// All sums.
IMPACT_INLINED Sums total(const PartialSums<Lanes>& lanes, const PartialSums<double>& rest)
{
  const auto of = [&](auto member_of_lanes, double more)
  {
    const Lanes& a = lanes.*member_of_lanes;
    return (a[0] + a[1]) + (a[2] + a[3]) + more;
  };
  typedef PartialSums<Lanes> P;
  return {.momentum = of(&P::momentum, rest.momentum),
          .speed = of(&P::speed, rest.speed),
          .old_speed = of(&P::old_speed, rest.old_speed),
          .position = of(&P::position, rest.position),
          .before = of(&P::before, rest.before),
          .after = of(&P::after, rest.after),
          .load_before = of(&P::load_before, rest.load_before),
          .load_after = of(&P::load_after, rest.load_after)};
}

/// The mass is read: to divide by its inverse takes three quarters of the time.
template <bool loaded, typename T>
IMPACT_INLINED void update_entry(T& r, const T* load, const T& inverse_mass, const T& mass, const Coefficients& c, T& u,
                                 T& v, PartialSums<T>& sums)
{
  const T none{}, ri = r, vo = v, ui = u;
  const T m = inverse_mass > none ? mass : none;
  T force = -ri;
  if constexpr (loaded)
    force += *load;
  const T vn = c.keep * vo + c.push * inverse_mass * force;
  v = vn;
  u = ui + c.dt * vn;
  r = none;
  const T old = m * vo;
  sums.momentum += old * vn;
  sums.speed += m * vn * vn;
  sums.old_speed += old * vo;
  sums.position += ui * ri;
  sums.before += ri * vo;
  sums.after += ri * vn;
  if constexpr (loaded)
  {
    sums.load_before += *load * vo;
    sums.load_after += *load * vn;
  }
}

/// Sums are split by lanes, always in the same order.
template <bool loaded>
IMPACT_INLINED Sums update_all(std::size_t n, double* __restrict r, const double* __restrict load,
                               const double* __restrict inverse_mass, const double* __restrict mass,
                               const Coefficients& coefficients, double* __restrict u, double* __restrict v)
{
  const Coefficients c = coefficients; // a copy: stores of doubles might change what is read by reference
  const std::size_t whole = n - n % width;
  PartialSums<Lanes> lanes;
  for (std::size_t i = 0; i < whole; i += width)
    update_entry<loaded>(*reinterpret_cast<Lanes*>(r + i), loaded ? reinterpret_cast<const Lanes*>(load + i) : nullptr,
                         *reinterpret_cast<const Lanes*>(inverse_mass + i), *reinterpret_cast<const Lanes*>(mass + i),
                         c, *reinterpret_cast<Lanes*>(u + i), *reinterpret_cast<Lanes*>(v + i), lanes);
  PartialSums<double> rest;
  for (std::size_t i = whole; i < n; ++i)
    update_entry<loaded>(r[i], loaded ? load + i : nullptr, inverse_mass[i], mass[i], c, u[i], v[i], rest);
  return total(lanes, rest);
}

/// One and zero where the component of that bit is free and where it is not; the fourth entry is padding.
alignas(Lanes) constexpr double free_components[8][width] = {{0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {1, 1, 0, 0},
                                                             {0, 0, 1, 0}, {1, 0, 1, 0}, {0, 1, 1, 0}, {1, 1, 1, 0}};

/// The same by node. Entries are those of `update_all`, in its order: so are the sums, to the last bit.
template <bool loaded>
IMPACT_INLINED Sums update_nodes(std::size_t num_nodes, double* __restrict r, const double* __restrict load,
                                 const double* __restrict inverse_mass, const double* __restrict mass,
                                 const std::uint8_t* __restrict free, const Coefficients& coefficients,
                                 double* __restrict u, double* __restrict v)
{
  const Coefficients c = coefficients;
  PartialSums<Lanes> lanes;
  for (std::size_t k = 0; k < num_nodes; ++k)
  {
    const std::size_t i = width * k;
    const Lanes& is_free = *reinterpret_cast<const Lanes*>(free_components[free[k]]);
    update_entry<loaded>(*reinterpret_cast<Lanes*>(r + i), loaded ? reinterpret_cast<const Lanes*>(load + i) : nullptr,
                         Lanes(inverse_mass[k] * is_free), Lanes(mass[k] * is_free), c,
                         *reinterpret_cast<Lanes*>(u + i), *reinterpret_cast<Lanes*>(v + i), lanes);
  }
  return total(lanes, PartialSums<double>{});
}

IMPACT_CLONES Sums update_free_nodes(std::size_t num_nodes, double* r, const double* inverse_mass, const double* mass,
                                     const std::uint8_t* free, const Coefficients& c, double* u, double* v)
{
  return update_nodes<false>(num_nodes, r, nullptr, inverse_mass, mass, free, c, u, v);
}

IMPACT_CLONES Sums update_loaded_nodes(std::size_t num_nodes, double* r, const double* load, const double* inverse_mass,
                                       const double* mass, const std::uint8_t* free, const Coefficients& c, double* u,
                                       double* v)
{
  return update_nodes<true>(num_nodes, r, load, inverse_mass, mass, free, c, u, v);
}

IMPACT_CLONES Sums update_free(std::size_t n, double* r, const double* inverse_mass, const double* mass,
                               const Coefficients& c, double* u, double* v)
{
  return update_all<false>(n, r, nullptr, inverse_mass, mass, c, u, v);
}

IMPACT_CLONES Sums update_loaded(std::size_t n, double* r, const double* load, const double* inverse_mass,
                                 const double* mass, const Coefficients& c, double* u, double* v)
{
  return update_all<true>(n, r, load, inverse_mass, mass, c, u, v);
}
} // namespace

Sums update(std::size_t n, double* r, const double* load, const double* inverse_mass, const double* mass,
            const Coefficients& c, double* u, double* v)
{
  return load ? update_loaded(n, r, load, inverse_mass, mass, c, u, v) : update_free(n, r, inverse_mass, mass, c, u, v);
}

Sums update(std::size_t num_nodes, double* r, const double* load, const NodeMasses& masses, const Coefficients& c,
            double* u, double* v)
{
  return load ? update_loaded_nodes(num_nodes, r, load, masses.inverse(), masses.mass(), masses.free(), c, u, v)
              : update_free_nodes(num_nodes, r, masses.inverse(), masses.mass(), masses.free(), c, u, v);
}

Sums measure(std::size_t n, const double* r, const double* load, const double* inverse_mass, const double* mass,
             const Coefficients& c, const double* u, const double* v)
{
  Sums s;
  for (std::size_t i = 0; i < n; ++i)
  {
    const double im = inverse_mass[i], l = load ? load[i] : 0.0, vo = v[i];
    const double m = im > 0.0 ? mass[i] : 0.0;
    const double vn = c.keep * vo + c.push * im * (l - r[i]);
    s.momentum += m * vo * vn;
    s.speed += m * vn * vn;
    s.old_speed += m * vo * vo;
    s.position += u[i] * r[i];
    s.before += r[i] * vo;
    s.after += r[i] * vn;
    s.load_before += l * vo;
    s.load_after += l * vn;
  }
  return s;
}
} // namespace dolfinx_impact::integrators
