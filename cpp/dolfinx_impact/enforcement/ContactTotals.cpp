// SPDX-License-Identifier: MIT
#include "ContactTotals.h"
#include <algorithm>

namespace dolfinx_impact::enforcement
{
void ContactTotals::update(MPI_Comm comm, const ContactPoints& p)
{
  const int gdim = p.gdim;
  slip.resize(p.slip.size(), 0.0);
  std::array<double, 8> sums{}; // force, moment, area, work
  for (std::size_t i = 0; i < p.weight.size(); ++i)
  {
    sums[6] += p.weight[i] * p.covered[i];
    if (p.status[i] == ContactStatus::open)
      continue;
    double x[3] = {}, f[3] = {};
    for (int c = 0; c < gdim; ++c)
    {
      x[c] = p.x[i * gdim + c];
      f[c] = p.weight[i] * p.traction[i * gdim + c];
      sums[c] += f[c];
      sums[7] -= f[c] * (p.slip[i * gdim + c] - slip[i * gdim + c]);
    }
    for (int c = 0; c < 3; ++c)
      sums[3 + c] += x[(c + 1) % 3] * f[(c + 2) % 3] - x[(c + 2) % 3] * f[(c + 1) % 3];
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), int(sums.size()), MPI_DOUBLE, MPI_SUM, comm);
  known = true;
  std::copy_n(sums.begin(), 3, force.begin());
  moment = gdim == 2 ? std::array{sums[5], 0.0, 0.0} : std::array{sums[3], sums[4], sums[5]};
  area = sums[6];
  dissipated += sums[7];
  std::ranges::copy(p.slip, slip.begin());
}
} // namespace dolfinx_impact::enforcement
