// SPDX-License-Identifier: MIT
#include "search_distance.h"
#include "../common/gather.h"
#include "../common/text.h"
#include <algorithm>
#include <stdexcept>

namespace dolfinx_impact::gap
{
double search_distance(MPI_Comm comm, const surface::Facets& slave, const surface::Facets* master, double given,
                       double layers)
{
  if (!(layers > 0.0) || !master)
    return given;
  if (given > 0.0)
  {
    if (!(given > layers))
      throw std::invalid_argument("the search distance " + common::text("%.4g", given) +
                                  " is not larger than the offset " + common::text("%.4g", layers) +
                                  ", within which the surfaces touch: give a larger one");
    return given;
  }
  double facet = 0.0;
  for (const surface::Facets* side : {&slave, master})
    for (std::size_t f = 0; f < side->size(); ++f)
      facet = std::max(facet, surface::diameter(*side, f));
  return layers + 2.0 * common::largest(comm, facet);
}
} // namespace dolfinx_impact::gap
