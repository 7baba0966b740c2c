// SPDX-License-Identifier: MIT
#pragma once
#include <Eigen/Dense>
#include <array>
#include <string>
#include <vector>

/// The hand-written solver: classical finite elements on Eigen matrices, independent of the FEniCS side on purpose.
namespace impact_reference
{
/// Matrices of cells and facets are small: their products are written with lazyProduct, entry by entry. Eigen's product
/// for large matrices works in blocks, which takes the compiler several seconds in every source.
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Vector = Eigen::VectorXd;

/// Reference cells: simplices have their vertices at the origin and at 1 on each axis, tensor cells fill [-1, 1]^d.
/// The interval is the facet of the plane cells and fills [-1, 1].
enum class CellType
{
  interval,
  triangle,
  quadrilateral,
  tetrahedron,
  hexahedron
};

/// Cell type of a name.
/// @throws std::invalid_argument for an unknown name
CellType cell_type(const std::string& name);

/// Name of a cell type.
const char* to_string(CellType cell);

/// Topological dimension.
int tdim(CellType cell);

/// Number of vertices.
int num_vertices(CellType cell);

/// True for triangle and tetrahedron.
bool is_simplex(CellType cell);

/// THE NODE ORDER, written down here only. Node i of the element of degree 1 or 2 is the barycentre of the vertices
/// node_vertices(cell, degree)[i]: vertices (counter-clockwise, bottom face before top face), mid-edges, mid-faces,
/// centre.
///   triangle       0 1 2 | 01 12 20
///   quadrilateral  0 1 2 3 | 01 12 23 30 | centre
///   tetrahedron    0 1 2 3 | 01 12 20 03 13 23
///   hexahedron     0 1 2 3 (z = -1) 4 5 6 7 (z = +1) | 01 12 23 30 45 56 67 74 04 15 26 37 |
///                  faces x- x+ y- y+ z- z+ | centre
///   interval       0 1 | 01
/// @throws std::invalid_argument if the degree is neither 1 nor 2
const std::vector<std::vector<int>>& node_vertices(CellType cell, int degree);

/// Reference coordinates of the nodes, shape (num_nodes, tdim).
Matrix reference_nodes(CellType cell, int degree);

/// Type of the facets.
CellType facet_type(CellType cell);

/// Vertices of every facet, ordered so that the facet's own normal (tangent turned clockwise in the plane, x_xi cross
/// x_eta in space) points out of the cell. Facets: triangle and quadrilateral as their edges above; tetrahedron 021 013
/// 123 032; hexahedron x- x+ y- y+ z- z+.
const std::vector<std::vector<int>>& facets(CellType cell);

/// Local nodes of a facet, in the order of the facet's own element.
/// @throws std::invalid_argument if the facet does not exist
std::vector<int> facet_nodes(CellType cell, int degree, int facet);

/// Own number of the facet that has these local nodes (any order; only vertices count).
/// @throws std::invalid_argument if no facet has exactly these vertices
int find_facet(CellType cell, const std::vector<int>& nodes);
} // namespace impact_reference
