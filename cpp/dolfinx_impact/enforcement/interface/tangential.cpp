// SPDX-License-Identifier: MIT
#include "tangential.h"
#include "../../common/vectors.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::enforcement
{
void turn(int gdim, const double* n, const double* last, double* out)
{
  const double along = dot(n, last, gdim);
  double left = 0.0;
  for (int c = 0; c < gdim; ++c)
  {
    out[c] = last[c] - along * n[c];
    left += out[c] * out[c];
  }
  const double scale = left > 0.0 ? std::sqrt(dot(last, last, gdim) / left) : 0.0;
  for (int c = 0; c < gdim; ++c)
    out[c] *= scale;
}

void turn_derivative(int gdim, const double* n, const double* last, const double* turned, int num,
                     const double* d_normal, double* d_turned)
{
  // With p = last - (n . last) n and L = |last|, out = L p/|p|: d out = L/|p| (I - e e) dp, e = p/|p|.
  const double length = std::sqrt(dot(last, last, gdim)), along = dot(n, last, gdim);
  const double left = std::sqrt(std::max(length * length - along * along, 0.0));
  if (!(left > 0.0))
  {
    std::fill_n(d_turned, gdim * num, 0.0);
    return;
  }
  for (int j = 0; j < num; ++j)
  {
    double dp[3], with_last = 0.0, radial = 0.0;
    for (int c = 0; c < gdim; ++c)
      with_last += d_normal[c * num + j] * last[c];
    for (int c = 0; c < gdim; ++c)
    {
      dp[c] = -along * d_normal[c * num + j] - with_last * n[c];
      radial += dp[c] * turned[c];
    }
    for (int c = 0; c < gdim; ++c)
      d_turned[c * num + j] = length / left * (dp[c] - turned[c] * radial / (length * length));
  }
}
} // namespace dolfinx_impact::enforcement
