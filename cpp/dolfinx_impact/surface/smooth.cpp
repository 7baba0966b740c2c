// SPDX-License-Identifier: MIT
#include "smooth.h"
#include "../common/dolfinx_api.h"
#include "../common/vectors.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <dolfinx/common/MPI.h>
#include <map>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::surface
{
namespace
{
/// Components beyond the dimension are zero.
struct Vector
{
  double v[3] = {0.0, 0.0, 0.0};
  double operator[](int c) const { return v[c]; }
  double& operator[](int c) { return v[c]; }
};

Vector operator+(const Vector& a, const Vector& b)
{
  return {{a[0] + b[0], a[1] + b[1], a[2] + b[2]}};
}
Vector operator-(const Vector& a, const Vector& b)
{
  return {{a[0] - b[0], a[1] - b[1], a[2] - b[2]}};
}
Vector operator*(double s, const Vector& a)
{
  return {{s * a[0], s * a[1], s * a[2]}};
}
double inner(const Vector& a, const Vector& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vector vector_product(const Vector& a, const Vector& b)
{
  Vector out;
  dolfinx_impact::cross(a.v, b.v, out.v);
  return out;
}
double length(const Vector& a)
{
  return std::sqrt(inner(a, a));
}
Vector unit(const Vector& a)
{
  return 1.0 / length(a) * a;
}

constexpr double inward = -0.5;    ///< a given normal whose product with the facet's is less points into the body
constexpr double undecided = 0.05; ///< least eigenvalue of the equations of a normal, below which more are wanted
constexpr double weak = 1e-6;      ///< weight of the mean normal against these equations

/// The surface of all ranks, facets sorted by id.
class SmoothSurface
{
public:
  SmoothSurface(const FunctionSpace& V, const Facets& facets, const SmoothOptions& options)
      : _gdim(facets.gdim), _element(facets.displacement), _corners(facets.displacement.num_corners()),
        _least(std::cos(options.crease))
  {
    gather(V, facets, options.normals);
    find_edges();
    find_fans();
    find_normals();
    find_offsets();
  }

  /// Geometry nodes of the facet with this id: the corners as they are, the others from the offsets.
  void append(std::int64_t id, const double* corners, std::vector<double>& X) const
  {
    const std::size_t f = std::lower_bound(_id.begin(), _id.end(), id) - _id.begin();
    const FacetElement geometry{_element.shape, 2};
    Vector sum;
    X.insert(X.end(), corners, corners + _corners * _gdim);
    for (int e = 0; e < _edges; ++e)
      sum = sum + _offsets[f * _edges + e];
    for (int i = _corners; i < geometry.num_nodes(); ++i)
    {
      // The centre of a quadrilateral: half the sum of the edges' middles less a quarter of that of the corners.
      const Vector offset = i - _corners < _edges ? _offsets[f * _edges + i - _corners] : 0.5 * sum;
      double phi[FacetElement::max_nodes];
      _element.values(geometry.node(i).data(), phi);
      Vector x = offset;
      for (int j = 0; j < _corners; ++j)
        x = x + phi[j] * position(corners + j * _gdim);
      X.insert(X.end(), x.v, x.v + _gdim);
    }
  }

private:
  /// An edge of a fan: from the node to another one.
  struct Spoke
  {
    std::int64_t to;
    Vector e;
    int far = -1, count = 0; ///< fan at the other end; facets of the fan that have this edge
  };
  /// Facets at a node that go into each other without a crease. Each has one normal there.
  struct Fan
  {
    std::vector<int> corners; ///< facet*num_corners + corner, ascending
    std::vector<Spoke> spokes;
    Vector mean, normal;
    bool known = false;
  };

  Vector X(int corner) const { return _positions[corner]; }
  Vector position(const double* x) const { return {{x[0], x[1], _gdim == 3 ? x[2] : 0.0}}; }
  int at(int corner, int step) const { return corner - corner % _corners + step; }

  void gather(const FunctionSpace& V, const Facets& facets, std::span<const double> normals)
  {
    const MPI_Comm comm = V.mesh()->comm();
    const int n = _corners, reals_per = n * 6, integers_per = n + 2;
    std::vector<std::int64_t> nodes(facets.nodes.size()), integers;
    V.dofmap()->index_map->local_to_global(facets.nodes, nodes);
    std::vector<double> reals;
    for (std::size_t f = 0; f < facets.size(); ++f)
    {
      integers.insert(integers.end(), {facets.id[f], facets.orientation[f]});
      integers.insert(integers.end(), nodes.begin() + f * n, nodes.begin() + (f + 1) * n);
      for (int i = 0; i < n; ++i)
        for (int c = 0; c < 3; ++c)
        {
          const std::size_t k = (f * n + i) * _gdim + c;
          reals.push_back(c < _gdim ? facets.X[k] : 0.0);
          reals.push_back(c >= _gdim ? 0.0 : normals.empty() ? std::nan("") : normals[k]);
        }
    }
    const std::vector<std::int64_t> all_integers = gather_rows(comm, integers);
    const std::vector<double> all_reals = gather_rows(comm, reals);
    const std::size_t size = all_integers.size() / integers_per;
    std::vector<std::size_t> order(size);
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b)
              { return all_integers[a * integers_per] < all_integers[b * integers_per]; });
    for (std::size_t r : order)
    {
      const std::int64_t* row = all_integers.data() + r * integers_per;
      _id.push_back(row[0]);
      _sign.push_back(double(row[1]));
      _nodes.insert(_nodes.end(), row + 2, row + integers_per);
      for (int i = 0; i < n; ++i)
      {
        Vector x, given;
        for (int c = 0; c < 3; ++c)
        {
          const double* pair = all_reals.data() + r * reals_per + 2 * (3 * i + c);
          x[c] = pair[0];
          given[c] = pair[1];
        }
        _positions.push_back(x);
        _given.push_back(given);
      }
    }
    for (std::size_t f = 0; f < size; ++f)
    {
      // By the diagonals of a quadrilateral: its normal at the centre, whichever its corners.
      const Vector* x = _positions.data() + f * n;
      const Vector a = n == 4 ? x[3] - x[0] : x[1] - x[0], b = n == 4 ? x[2] - x[1] : n == 3 ? x[2] - x[0] : up();
      _normals.push_back(_sign[f] * unit(vector_product(a, b)));
    }
  }

  template <typename T>
  static std::vector<T> gather_rows(MPI_Comm comm, const std::vector<T>& mine)
  {
    using dolfinx::MPI::check_error;
    std::vector<int> counts(dolfinx::MPI::size(comm)), first(counts.size() + 1, 0);
    const int count = int(mine.size());
    check_error(comm, MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm));
    std::partial_sum(counts.begin(), counts.end(), first.begin() + 1);
    std::vector<T> out(first.back());
    check_error(comm, MPI_Allgatherv(mine.data(), count, common::mpi_type<T>(), out.data(), counts.data(), first.data(),
                                     common::mpi_type<T>(), comm));
    return out;
  }

  /// The direction across the plane.
  static Vector up() { return {{0.0, 0.0, 1.0}}; }

  /// Corners at the ends of edge e of facet f.
  std::array<int, 2> ends(std::size_t f, int e) const
  {
    const int* k = edge_corners(_element.shape, e);
    return {int(f) * _corners + k[0], int(f) * _corners + k[1]};
  }

  bool continues(std::size_t f, std::size_t g) const { return inner(_normals[f], _normals[g]) >= _least; }

  /// Facets that share an edge (in the plane: a node), and whether they go into each other smoothly: then their
  /// corners there belong together.
  void find_edges()
  {
    _edges = _element.tdim() == 1 ? 1 : _corners;
    _together.resize(_nodes.size());
    std::iota(_together.begin(), _together.end(), 0);
    std::map<std::pair<std::int64_t, std::int64_t>, std::vector<int>> shared;
    if (_element.tdim() == 1)
    {
      for (int k = 0; k < int(_nodes.size()); ++k)
        shared[{_nodes[k], _nodes[k]}].push_back(k);
      for (const auto& [key, corners] : shared)
        if (corners.size() == 2 && continues(corners[0] / _corners, corners[1] / _corners))
          unite(corners[0], corners[1]);
      return;
    }
    for (std::size_t f = 0; f < _id.size(); ++f)
      for (int e = 0; e < _edges; ++e)
      {
        const auto [a, b] = ends(f, e);
        shared[std::minmax(_nodes[a], _nodes[b])].push_back(int(f) * _edges + e);
      }
    _partner.assign(_id.size() * _edges, -1);
    for (const auto& [key, edges] : shared)
    {
      if (edges.size() != 2)
        continue;
      _partner[edges[0]] = edges[1];
      _partner[edges[1]] = edges[0];
      const std::size_t f = edges[0] / _edges, g = edges[1] / _edges;
      if (!continues(f, g))
        continue;
      for (int a : ends(f, edges[0] % _edges))
        for (int b : ends(g, edges[1] % _edges))
          if (_nodes[a] == _nodes[b])
            unite(a, b);
    }
  }

  int root(int corner) const
  {
    while (_together[corner] != corner)
      corner = _together[corner];
    return corner;
  }
  void unite(int a, int b)
  {
    a = root(a);
    b = root(b);
    _together[std::max(a, b)] = std::min(a, b);
  }

  void find_fans()
  {
    // The ends of the two edges at a corner, so that their product points as the facet's own normal.
    constexpr int to[3][4][2] = {{{1, 1}, {0, 0}}, {{1, 2}, {2, 0}, {0, 1}}, {{1, 2}, {3, 0}, {0, 3}, {2, 1}}};
    _fan.assign(_nodes.size(), -1);
    for (int k = 0; k < int(_nodes.size()); ++k)
    {
      const int first = root(k);
      if (_fan[first] < 0)
      {
        _fan[first] = int(_fans.size());
        _fans.emplace_back();
      }
      _fan[k] = _fan[first];
      _fans[_fan[k]].corners.push_back(k);
    }
    for (Fan& fan : _fans)
    {
      for (int k : fan.corners)
      {
        Vector e[2];
        for (int s = 0; s < (_element.tdim() == 1 ? 1 : 2); ++s)
        {
          const int other = at(k, to[int(_element.shape)][k % _corners][s]);
          e[s] = X(other) - X(k);
          const auto same = std::find_if(fan.spokes.begin(), fan.spokes.end(),
                                         [&](const Spoke& spoke) { return spoke.to == _nodes[other]; });
          if (same == fan.spokes.end())
            fan.spokes.push_back({_nodes[other], e[s], _fan[other], 1});
          else
            ++same->count;
        }
        // Weights by which the sum is exact on spheres: Max, Journal of Graphics Tools 4 (1999), 1.
        double sign = _sign[k / _corners];
        if (_element.tdim() == 1)
        {
          e[1] = up();
          sign = k % _corners ? -sign : sign;
        }
        fan.mean = fan.mean + sign / (inner(e[0], e[0]) * inner(e[1], e[1])) * vector_product(e[0], e[1]);
      }
      fan.mean = length(fan.mean) > 0.0 ? unit(fan.mean) : _normals[fan.corners.front() / _corners];
      fan.normal = fan.mean;
      fan.known = _element.tdim() == 1 ? fan.corners.size() == 2
                                       : std::all_of(fan.spokes.begin(), fan.spokes.end(),
                                                     [](const Spoke& spoke) { return spoke.count == 2; });
    }
  }

  /// Where facets are missing on one side, the mean of the others is one-sided: the normal there follows from the
  /// edges. Along an edge the surface is taken for a parabola, (n_0 + n_1) . e = 0; along the boundary, for one through
  /// three nodes.
  /// @param[in] last take what there is
  /// @returns whether there were enough equations
  bool solve(Fan& fan, bool last) const
  {
    const Vector m = fan.mean, e = fan.spokes.front().e;
    Vector t[2];
    t[0] = unit(e - inner(e, m) * m);
    t[1] = vector_product(m, t[0]);
    double a[3] = {0.0, 0.0, 0.0}, b[2] = {0.0, 0.0}; // symmetric: 00, 11, 01
    const auto add = [&](const Vector& direction, double value)
    {
      const double x = inner(direction, t[0]), y = inner(direction, t[1]), right = value - inner(direction, m);
      a[0] += x * x;
      a[1] += y * y;
      a[2] += x * y;
      b[0] += x * right;
      b[1] += y * right;
    };
    std::vector<const Spoke*> rim;
    for (const Spoke& spoke : fan.spokes)
    {
      if (_fans[spoke.far].known)
      {
        const Vector along = unit(spoke.e);
        add(along, -inner(along, _fans[spoke.far].normal));
      }
      if (spoke.count == 1)
        rim.push_back(&spoke);
    }
    if (_element.tdim() == 2 && rim.size() == 2 && -inner(unit(rim[0]->e), unit(rim[1]->e)) >= _least)
    {
      const Vector &c = rim[0]->e, &d = rim[1]->e;
      add(unit(1.0 / inner(c, c) * c - 1.0 / inner(d, d) * d), 0.0);
    }
    const double half = 0.5 * (a[0] + a[1]);
    const double least = _element.tdim() == 1 ? a[0] : half - std::hypot(0.5 * (a[0] - a[1]), a[2]);
    if (least < undecided && !last)
      return false;
    a[0] += weak;
    a[1] += weak;
    const double determinant = a[0] * a[1] - a[2] * a[2];
    const Vector n =
        unit(m + (a[1] * b[0] - a[2] * b[1]) / determinant * t[0] + (a[0] * b[1] - a[2] * b[0]) / determinant * t[1]);
    fan.normal = inner(n, m) >= _least ? n : m;
    return true;
  }

  void find_normals()
  {
    for (bool last = false;;)
    {
      std::vector<int> solved;
      for (std::size_t k = 0; k < _fans.size(); ++k)
        if (!_fans[k].known && solve(_fans[k], last))
          solved.push_back(int(k));
      for (int k : solved)
        _fans[k].known = true;
      if (last)
        break;
      last = solved.empty();
    }
    _corner_normals.resize(_nodes.size());
    for (std::size_t k = 0; k < _nodes.size(); ++k)
    {
      _corner_normals[k] = _fans[_fan[k]].normal;
      const double size = length(_given[k]);
      if (!std::isfinite(size) || size == 0.0)
        continue;
      const Vector given = 1.0 / size * _given[k];
      const double along = inner(given, _normals[k / _corners]);
      if (along < inward)
        throw std::invalid_argument("a normal given for a smooth surface points into the body, at (" +
                                    std::to_string(X(int(k))[0]) + ", " + std::to_string(X(int(k))[1]) +
                                    (_gdim == 3 ? ", " + std::to_string(X(int(k))[2]) : "") + ")");
      if (along >= _least)
        _corner_normals[k] = given;
    }
  }

  /// Normal in the middle of an edge, and the distance along it from the middle of the chord to the curve.
  std::pair<Vector, double> bulge(std::size_t f, int e) const
  {
    auto [a, b] = ends(f, e);
    if (_nodes[a] > _nodes[b])
      std::swap(a, b);
    const Vector &n = _corner_normals[a], &o = _corner_normals[b], middle = unit(n + o);
    const Vector chord = X(b) - X(a);
    const double size = length(chord);
    // Slope of the curve at its ends: for Nagata's parabola four times the height over the chord. The height of the
    // arc of a circle with these slopes is a better one.
    const double slope = -0.5 * inner(n - o, chord) / (inner(n, middle) * size);
    return {middle, 0.5 * size * slope / (1.0 + std::sqrt(1.0 + slope * slope))};
  }

  void find_offsets()
  {
    for (std::size_t f = 0; f < _id.size(); ++f)
      for (int e = 0; e < _edges; ++e)
      {
        const auto [m, height] = bulge(f, e);
        Vector offset = height * m;
        const int partner = _element.tdim() == 2 ? _partner[f * _edges + e] : -1;
        if (partner >= 0 && !continues(f, partner / _edges))
        {
          // A sharp edge is one curve, too: its height above each of the two facets is that facet's.
          const auto [o, other] = bulge(partner / _edges, partner % _edges);
          const double along = inner(m, o), rest = 1.0 - along * along;
          if (rest > 0.01)
            offset = (height - along * other) / rest * m + (other - along * height) / rest * o;
        }
        _offsets.push_back(offset);
      }
  }

  int _gdim;
  FacetElement _element;
  int _corners, _edges = 0;
  double _least; ///< cosine of the crease
  std::vector<std::int64_t> _id, _nodes;
  std::vector<double> _sign;
  std::vector<Vector> _positions, _given, _corner_normals; ///< by corner
  std::vector<Vector> _normals;                            ///< by facet
  std::vector<int> _together, _fan, _partner;
  std::vector<Fan> _fans;
  std::vector<Vector> _offsets; ///< by facet and edge
};
} // namespace

Facets make_smooth(const FunctionSpace& V, const Facets& facets, const SmoothOptions& options)
{
  if (facets.displacement.degree != 1 || facets.geometry.degree != 1)
    throw std::invalid_argument("smooth surfaces are laid through facets of degree 1: a mesh or displacements of "
                                "degree 2 are curved themselves");
  if (!(options.crease >= 0.0 && options.crease <= std::numbers::pi))
    throw std::invalid_argument("a crease is an angle between 0 and 180 degrees");
  const bool wrong = !options.normals.empty() && options.normals.size() != facets.X.size();
  int any = wrong;
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, V.mesh()->comm());
  if (any)
    throw std::invalid_argument("normals of a smooth surface have gdim components for each corner of the facets");
  const SmoothSurface surface(V, facets, options);
  Facets out = facets;
  out.smooth = true;
  out.geometry.degree = 2;
  out.X.clear();
  for (std::size_t f = 0; f < facets.size(); ++f)
    surface.append(facets.id[f], facets.X_of(f), out.X);
  out.x = out.X;
  return out;
}

Facets flat(const Facets& facets)
{
  if (!facets.smooth)
    return facets;
  Facets out = facets;
  out.smooth = false;
  out.geometry.degree = 1;
  const std::size_t gdim = facets.gdim, corners = gdim * out.geometry.num_nodes();
  out.X.clear();
  out.x.clear();
  for (std::size_t f = 0; f < facets.size(); ++f)
  {
    out.X.insert(out.X.end(), facets.X_of(f), facets.X_of(f) + corners);
    out.x.insert(out.x.end(), facets.x_of(f), facets.x_of(f) + corners);
  }
  return out;
}
} // namespace dolfinx_impact::surface
