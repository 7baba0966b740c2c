// SPDX-License-Identifier: MIT
#include "SteadySlip.h"
#include <stdexcept>

namespace impact_reference
{
SteadySlip::SteadySlip(Vector flow, Csr along, Vec<double> obstacle, int gdim)
    : flow_(std::move(flow)), along_(std::move(along)), obstacle_(obstacle), gdim_(gdim)
{
  if (flow_.size() != gdim_ * along_.size or not flow_.allFinite())
    throw std::invalid_argument("a steady flow needs " + std::to_string(gdim_ * along_.size) + " finite values");
}

Vector SteadySlip::way(const Vector& u) const
{
  Vector result = flow_;
  for (std::int64_t i = 0; i < along_.size; ++i)
    for (std::int64_t k = along_.indptr[i]; k < along_.indptr[i + 1]; ++k)
      result.segment(gdim_ * i, gdim_) += along_.data[k] * u.segment(gdim_ * along_.indices[k], gdim_);
  return result;
}

void SteadySlip::set_back(const ContactPair& pair, const Vector& u, ContactHistory& history) const
{
  history.u = u - way(u);
  if (pair.rigid)
    history.place.displacement = pair.rigid->place.displacement - obstacle_;
}

void SteadySlip::differentiate(Mortar& mortar) const
{
  for (const auto& [list, sign] : {std::pair{&mortar.D, 1.0}, std::pair{&mortar.M, -1.0}})
    for (const auto& e : *list)
    {
      Slope& slope = mortar.nodes.at(e.row()).moved.slope;
      const auto add = [&](std::int64_t node, double value)
      {
        for (int c = 0; c < gdim_; ++c)
        {
          Vec<double> s;
          s[c] = sign * e.value() * value;
          slope.emplace_back(gdim_ * node + c, s);
        }
      };
      add(e.col(), -1.0); // the history moves with u
      for (std::int64_t k = along_.indptr[e.col()]; k < along_.indptr[e.col() + 1]; ++k)
        add(along_.indices[k], along_.data[k]);
    }
}
} // namespace impact_reference
