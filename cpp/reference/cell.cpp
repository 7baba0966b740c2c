// SPDX-License-Identifier: MIT
#include "Cell.h"
#include <algorithm>
#include <stdexcept>

namespace impact_reference
{
namespace
{
using Lists = std::vector<std::vector<int>>;

const Lists& edges(CellType cell)
{
  static const Lists interval{{0, 1}}, triangle{{0, 1}, {1, 2}, {2, 0}}, quadrilateral{{0, 1}, {1, 2}, {2, 3}, {3, 0}};
  static const Lists tetrahedron{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  static const Lists hexahedron{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
  switch (cell)
  {
  case CellType::interval:
    return interval;
  case CellType::triangle:
    return triangle;
  case CellType::quadrilateral:
    return quadrilateral;
  case CellType::tetrahedron:
    return tetrahedron;
  default:
    return hexahedron;
  }
}

Lists make_nodes(CellType cell, int degree)
{
  Lists nodes;
  for (int v = 0; v < num_vertices(cell); ++v)
    nodes.push_back({v});
  if (degree == 1)
    return nodes;
  nodes.insert(nodes.end(), edges(cell).begin(), edges(cell).end());
  if (cell == CellType::quadrilateral)
    nodes.push_back({0, 1, 2, 3});
  if (cell == CellType::hexahedron)
  {
    nodes.insert(nodes.end(), facets(cell).begin(), facets(cell).end());
    nodes.push_back({0, 1, 2, 3, 4, 5, 6, 7});
  }
  return nodes;
}

std::vector<int> sorted(std::vector<int> list)
{
  std::sort(list.begin(), list.end());
  return list;
}

Matrix vertices(CellType cell)
{
  Matrix x(num_vertices(cell), tdim(cell));
  switch (cell)
  {
  case CellType::interval:
    x << -1, 1;
    break;
  case CellType::triangle:
    x << 0, 0, 1, 0, 0, 1;
    break;
  case CellType::quadrilateral:
    x << -1, -1, 1, -1, 1, 1, -1, 1;
    break;
  case CellType::tetrahedron:
    x << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
    break;
  case CellType::hexahedron:
    x << -1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1;
    break;
  }
  return x;
}
} // namespace

CellType cell_type(const std::string& name)
{
  for (CellType cell :
       {CellType::interval, CellType::triangle, CellType::quadrilateral, CellType::tetrahedron, CellType::hexahedron})
    if (name == to_string(cell))
      return cell;
  throw std::invalid_argument("unknown cell type '" + name +
                              "': use triangle, quadrilateral, tetrahedron or hexahedron");
}

const char* to_string(CellType cell)
{
  static const std::array names{"interval", "triangle", "quadrilateral", "tetrahedron", "hexahedron"};
  return names[static_cast<int>(cell)];
}

int tdim(CellType cell)
{
  return std::array{1, 2, 2, 3, 3}[static_cast<int>(cell)];
}

int num_vertices(CellType cell)
{
  return std::array{2, 3, 4, 4, 8}[static_cast<int>(cell)];
}

bool is_simplex(CellType cell)
{
  return cell == CellType::triangle or cell == CellType::tetrahedron;
}

const Lists& node_vertices(CellType cell, int degree)
{
  if (degree != 1 and degree != 2)
    throw std::invalid_argument("degree is " + std::to_string(degree) +
                                ": the hand-written elements have degree 1 or 2");
  static const std::vector<Lists> table = []
  {
    std::vector<Lists> t;
    for (int c = 0; c < 5; ++c)
      for (int p : {1, 2})
        t.push_back(make_nodes(static_cast<CellType>(c), p));
    return t;
  }();
  return table[2 * static_cast<int>(cell) + degree - 1];
}

Matrix reference_nodes(CellType cell, int degree)
{
  const Lists& nodes = node_vertices(cell, degree);
  const Matrix corner = vertices(cell);
  Matrix x = Matrix::Zero(nodes.size(), tdim(cell));
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (int v : nodes[i])
      x.row(i) += corner.row(v) / double(nodes[i].size());
  return x;
}

CellType facet_type(CellType cell)
{
  switch (cell)
  {
  case CellType::tetrahedron:
    return CellType::triangle;
  case CellType::hexahedron:
    return CellType::quadrilateral;
  case CellType::interval:
    throw std::invalid_argument("an interval has no facets here: use a plane or solid cell");
  default:
    return CellType::interval;
  }
}

const Lists& facets(CellType cell)
{
  static const Lists tetrahedron{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  static const Lists hexahedron{{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}};
  if (cell == CellType::tetrahedron)
    return tetrahedron;
  return cell == CellType::hexahedron ? hexahedron : edges(cell);
}

std::vector<int> facet_nodes(CellType cell, int degree, int facet)
{
  const CellType type = facet_type(cell);
  if (facet < 0 or facet >= int(facets(cell).size()))
    throw std::invalid_argument("facet " + std::to_string(facet) + " does not exist: a " + to_string(cell) +
                                " has facets 0 to " + std::to_string(facets(cell).size() - 1));
  const Lists& nodes = node_vertices(cell, degree);
  std::vector<int> result;
  for (std::vector<int> entity : node_vertices(type, degree))
  {
    for (int& v : entity)
      v = facets(cell)[facet][v];
    const auto same = [key = sorted(entity)](const std::vector<int>& node) { return sorted(node) == key; };
    result.push_back(int(std::find_if(nodes.begin(), nodes.end(), same) - nodes.begin()));
  }
  return result;
}

int find_facet(CellType cell, const std::vector<int>& nodes)
{
  std::vector<int> key;
  for (int node : sorted(nodes))
    if (node < num_vertices(cell))
      key.push_back(node);
  for (std::size_t f = 0; f < facets(cell).size(); ++f)
    if (sorted(facets(cell)[f]) == key)
      return int(f);
  throw std::invalid_argument(std::string("no facet of the ") + to_string(cell) + " has the given local nodes");
}
} // namespace impact_reference
