// SPDX-License-Identifier: MIT
#include "ContactTotals.h"
#include <algorithm>
#include <cmath>
#include <limits>

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

void ContactTotals::add_to(state::State& saved, int gdim) const
{
  const auto first = [this](const std::array<double, 3>& vector, int n)
  {
    return known ? std::vector<double>(vector.begin(), vector.begin() + n)
                 : std::vector<double>(n, std::numeric_limits<double>::quiet_NaN());
  };
  saved.add_own("force", state::Place::all, first(force, gdim));
  saved.add_own("moment", state::Place::all, first(moment, gdim == 2 ? 1 : 3));
  saved.add_own("area", state::Place::all, std::vector<double>{area, dissipated});
}

void ContactTotals::resume(const state::State& saved, std::vector<double> counted)
{
  const auto f = saved.values<double>("force"), m = saved.values<double>("moment"), a = saved.values<double>("area");
  known = std::ranges::none_of(f, [](double component) { return std::isnan(component); });
  if (known)
  {
    force = moment = {};
    std::ranges::copy(f, force.begin());
    std::ranges::copy(m, moment.begin());
  }
  area = a[0];
  dissipated = a[1];
  slip = std::move(counted);
}
} // namespace dolfinx_impact::enforcement
