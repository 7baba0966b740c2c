// SPDX-License-Identifier: MIT
#pragma once
#include "TrackedSurface.h"

namespace dolfinx_impact::search
{
/// How far a slave node and the surface may move against each other before the node can have a negative gap, and by how
/// much normals may rotate until then. Facets are taken into account one after the other.
class SkipBound
{
public:
  /// @param[in] u displacements [L]
  /// @param[in] x position of the node [L]
  /// @param[in] slave_normal its stored normal, rotation: upper bound on the error of that
  /// @param[in] radius facets beyond it do not count [L]
  /// @param[in] path upper bound of the result [L]
  SkipBound(const TrackedSurface& surface, const double* u, const double* x, const double* slave_normal,
            double rotation, double radius, double path)
      : _surface(&surface), _u(u), _x(x), _slave_normal(slave_normal), _rotation(rotation), _distance(radius),
        _path(path)
  {
  }

  /// The nearest facet that faces the node, with its closest point. To be called before `add`.
  /// @returns false if that facet may soon turn away from the node: nothing can be said
  bool set_nearest(const Projection& at);
  /// Another facet.
  void add(std::int32_t facet);
  /// The result is no larger than this [L].
  void limit(double path);

  /// Upper bound of the path until the node has to be evaluated [L].
  double path() const { return _path; }
  /// Distance of the nearest facet; without one the radius [L].
  double distance() const { return _distance; }
  /// Do normals matter? Then deformations are limited as well.
  bool rotates() const { return _rotates; }
  /// Deformation of both sides together until the node has to be evaluated [L].
  /// @param[in] slave_rate upper bound on the change of the slave's normal per deformation [1/L]
  double deformation(double slave_rate) const;

private:
  void must_not_rotate(double margin, double rate);

  const TrackedSurface* _surface;
  const double *_u, *_x, *_slave_normal;
  double _rotation, _distance, _path;
  double _margin = 1.0; ///< least |slave normal . facet's normal| of the products that must keep their sign
  double _rate = 0.0;   ///< largest rotation rate of these facets' normals [1/L]
  bool _nearest = false, _rotates = false;
};
} // namespace dolfinx_impact::search
