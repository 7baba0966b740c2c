// SPDX-License-Identifier: MIT
#include "pairs.h"
#include "BoxTree.h"
#include "boxes.h"

namespace dolfinx_impact::search
{
Pairs near_facets(const surface::Facets& slave, const surface::Facets& master, double reach)
{
  std::vector<double> boxes, own;
  bounding_boxes(master, boxes);
  bounding_boxes(slave, own);
  const BoxTree tree(slave.gdim, boxes);
  Pairs out;
  out.offsets.push_back(0);
  std::vector<std::int32_t> found;
  for (std::size_t f = 0; f < slave.size(); ++f)
  {
    double* box = own.data() + 2 * slave.gdim * f;
    for (int c = 0; c < slave.gdim; ++c)
    {
      box[c] -= reach;
      box[slave.gdim + c] += reach;
    }
    tree.overlapping(box, found);
    out.pairs.insert(out.pairs.end(), found.begin(), found.end());
    out.offsets.push_back(std::int32_t(out.pairs.size()));
  }
  return out;
}
} // namespace dolfinx_impact::search
