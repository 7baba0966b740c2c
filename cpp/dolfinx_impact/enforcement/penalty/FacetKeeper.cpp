// SPDX-License-Identifier: MIT
#include "FacetKeeper.h"
#include <algorithm>

namespace dolfinx_impact::enforcement
{
namespace
{
/// Iterations in which points may change facets freely after convergence; at a kink the changes may never end.
constexpr int free_iterations = 10;
/// Number of iterations whose facets are remembered: the last one, and earlier ones that the present is compared with.
constexpr std::size_t memory = 4;
} // namespace

void FacetKeeper::begin(std::span<double> margins, double given)
{
  _stay = true;
  _free = free_iterations;
  _facets.clear();
  std::ranges::fill(margins, given);
}

int FacetKeeper::watch(std::span<const std::int32_t> facets, bool kept, std::span<double> margins)
{
  if (!kept) // a new search numbers the facets anew
    _facets.clear();
  int moved = 0, returned = 0;
  for (std::size_t i = 0; i < facets.size() && !_facets.empty(); ++i)
  {
    const std::int32_t before = _facets.back()[i];
    if (facets[i] == before || facets[i] < 0 || before < 0)
      continue;
    ++moved;
    if (std::none_of(_facets.begin(), _facets.end() - 1, [&](const auto& earlier) { return earlier[i] == facets[i]; }))
      continue;
    ++returned;
    if (_stay)
      margins[i] = std::min(2.0 * margins[i], widest);
  }
  if (_facets.size() == memory)
    _facets.pop_front();
  _facets.emplace_back(facets.begin(), facets.end());
  MPI_Allreduce(MPI_IN_PLACE, &returned, 1, MPI_INT, MPI_SUM, _comm);
  if (!_stay)
    _stay = --_free == 0 || returned > 0;
  return moved;
}

bool FacetKeeper::leave()
{
  if (!_stay || _free < free_iterations)
    return false;
  _stay = false;
  return true;
}
} // namespace dolfinx_impact::enforcement
