// SPDX-License-Identifier: MIT
#include "update.h"
#include "../common/clones.h"

namespace dolfinx_impact::integrators
{
namespace
{
/// Sums are split by the vector's lanes (omp simd), always in the same order. The mass is read: to divide by its
/// inverse takes three quarters of the time.
template <bool loaded>
IMPACT_INLINED Sums update_all(std::size_t n, double* __restrict r, const double* __restrict load,
                               const double* __restrict inverse_mass, const double* __restrict mass,
                               const Coefficients& c, double* __restrict u, double* __restrict v)
{
  const double keep = c.keep, push = c.push, dt = c.dt;
  double momentum = 0.0, speed = 0.0, old_speed = 0.0, position = 0.0, before = 0.0, after = 0.0;
  double load_before = 0.0, load_after = 0.0;
#pragma omp simd reduction(+ : momentum, speed, old_speed, position, before, after, load_before, load_after)
  for (std::size_t i = 0; i < n; ++i)
  {
    const double im = inverse_mass[i], ri = r[i], vo = v[i], ui = u[i];
    const double li = loaded ? load[i] : 0.0;
    const double m = im > 0.0 ? mass[i] : 0.0;
    const double vn = loaded ? keep * vo + push * im * (li - ri) : keep * vo - push * im * ri;
    v[i] = vn;
    u[i] = ui + dt * vn;
    r[i] = 0.0;
    momentum += m * vo * vn;
    speed += m * vn * vn;
    old_speed += m * vo * vo;
    position += ui * ri;
    before += ri * vo;
    after += ri * vn;
    if constexpr (loaded)
    {
      load_before += li * vo;
      load_after += li * vn;
    }
  }
  return {momentum, speed, old_speed, position, before, after, load_before, load_after};
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
