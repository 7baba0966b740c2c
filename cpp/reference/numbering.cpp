// SPDX-License-Identifier: MIT
#include "numbering.h"
#include "shape.h"
#include <algorithm>
#include <map>
#include <stdexcept>

namespace impact_reference
{
namespace
{
using Key = std::vector<std::int64_t>;

std::string text(std::int64_t number)
{
  return std::to_string(number);
}
} // namespace

Geometry geometry(const impact_plain::Mesh& mesh)
{
  const CellType cell = cell_type(mesh.cell_type);
  if (cell == CellType::interval)
    throw std::invalid_argument("a model needs plane or solid cells, not intervals");
  const auto nodes = std::int64_t(node_vertices(cell, mesh.degree).size());
  if (mesh.gdim != tdim(cell))
    throw std::invalid_argument(mesh.cell_type + " cells need points with " + text(tdim(cell)) +
                                " coordinates, but the points have " + text(mesh.gdim) +
                                ": shells and membranes are not covered");
  const auto num_points = std::int64_t(mesh.points.size()) / mesh.gdim;
  if (mesh.cells.empty() or std::int64_t(mesh.cells.size()) % nodes != 0)
    throw std::invalid_argument("a " + mesh.cell_type + " of geometry degree " + text(mesh.degree) + " has " +
                                text(nodes) + " nodes; the cells array of " + text(mesh.cells.size()) +
                                " numbers does not fit");
  Geometry g{cell, mesh.degree, Eigen::Map<const Matrix>(mesh.points.data(), num_points, mesh.gdim),
             Eigen::Map<const Cells>(mesh.cells.data(), mesh.cells.size() / nodes, nodes)};
  std::vector<bool> used(num_points);
  for (std::int64_t c = 0; c < g.cells.rows(); ++c)
  {
    for (std::int64_t node : g.cells.row(c))
    {
      if (node < 0 or node >= num_points)
        throw std::invalid_argument("cell " + text(c) + " names node " + text(node) +
                                    ", but the points are numbered 0 to " + text(num_points - 1));
      used[node] = true;
    }
    Key sorted(g.cells.row(c).begin(), g.cells.row(c).end());
    std::sort(sorted.begin(), sorted.end());
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (twice != sorted.end())
      throw std::invalid_argument("cell " + text(c) + " names node " + text(*twice) + " twice, so it has no volume");
  }
  for (std::int64_t i = 0; i < num_points; ++i)
  {
    if (not g.points.row(i).allFinite())
      throw std::invalid_argument("point " + text(i) + " has a coordinate that is NaN or infinite");
    if (not used[i])
      throw std::invalid_argument("point " + text(i) +
                                  " belongs to no cell: remove unused points, they would make the stiffness singular");
  }
  return g;
}

Field number_field(const Geometry& g, int degree)
{
  if (degree == g.degree)
    return {degree, g.points, g.cells};
  const auto& nodes = node_vertices(g.cell, degree);
  const Matrix N = shape_functions(g.cell, g.degree, reference_nodes(g.cell, degree)).N;
  std::map<Key, std::int64_t> numbers; // vertices of an entity -> node
  std::int64_t count = 0;
  const auto entity = [&](std::int64_t c, std::size_t i)
  {
    Key key;
    for (int v : nodes[i])
      key.push_back(g.cells(c, v));
    std::sort(key.begin(), key.end());
    return key;
  };
  for (std::size_t size : {1, 2, 4, 8})
  {
    for (std::int64_t c = 0; c < g.cells.rows(); ++c)
      for (std::size_t i = 0; i < nodes.size(); ++i)
        if (nodes[i].size() == size and numbers.try_emplace(entity(c, i), count).second)
          ++count;
    if (size == 1) // a map of single vertices is sorted by geometry number
    {
      count = 0;
      for (auto& [key, number] : numbers)
        number = count++;
    }
  }
  Field field{degree, Matrix(count, g.points.cols()), Cells(g.cells.rows(), nodes.size())};
  for (std::int64_t c = 0; c < g.cells.rows(); ++c)
  {
    const Key own(g.cells.row(c).begin(), g.cells.row(c).end());
    const Matrix vertices = g.points(own, Eigen::all), x = N.lazyProduct(vertices);
    for (std::size_t i = 0; i < nodes.size(); ++i)
    {
      field.cells(c, i) = numbers.at(entity(c, i));
      field.points.row(field.cells(c, i)) = x.row(i);
    }
  }
  return field;
}

std::size_t FacetIndex::Hash::operator()(const Key& key) const
{
  std::size_t h = 1469598103934665603ull;
  for (std::int64_t i : key)
    h = (h ^ std::size_t(i)) * 1099511628211ull;
  return h;
}

FacetIndex::FacetIndex(const Geometry& g) : num_points_(g.points.rows()), is_vertex_(g.points.rows())
{
  const auto& list = facets(g.cell);
  for (std::int64_t c = 0; c < g.cells.rows(); ++c)
    for (std::size_t f = 0; f < list.size(); ++f)
    {
      Key key;
      for (int v : list[f])
      {
        key.push_back(g.cells(c, v));
        is_vertex_[key.back()] = true;
      }
      std::sort(key.begin(), key.end());
      ++places_.try_emplace(key, FacetPlace{c, int(f), 0}).first->second.num_cells;
    }
}

FacetPlace FacetIndex::find(const Key& nodes) const
{
  Key key;
  std::string listed;
  for (std::int64_t node : nodes)
  {
    listed += " " + text(node);
    if (node < 0 or node >= num_points_)
      throw std::invalid_argument("a facet names node " + text(node) + ", but the points are numbered 0 to " +
                                  text(num_points_ - 1));
    if (is_vertex_[node])
      key.push_back(node);
  }
  std::sort(key.begin(), key.end());
  const auto place = places_.find(key);
  if (place == places_.end())
    throw std::invalid_argument("no cell has a facet with the nodes" + listed +
                                ": give geometry node numbers of whole facets");
  return place->second;
}
} // namespace impact_reference
