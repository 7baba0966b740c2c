// SPDX-License-Identifier: MIT
#pragma once
#include "TrackedSurface.h"
#include <span>
#include <vector>

namespace dolfinx_impact::search
{
/// Bounds on the motion of slave nodes and master surface against each other, updated step by step. It owns the
/// positions of the slave nodes.
///
/// The path of a node is the sum, over the steps, of its own motion and of the largest motion of a node of the master,
/// a common translation left out: no distance between the node and the surface changes by more than its path grows.
/// The deformation of a side is no less than the largest motion of one of its nodes since the last renewal, the side's
/// mean translation left out: it bounds how far normals of the side can have rotated (NormalRotation). Where nodes were
/// at the last renewal is looked at only once their steps since the last look add up to something.
class RelativeMotion
{
public:
  RelativeMotion() = default;
  /// @param[in] X reference positions of the slave nodes, gdim each [L]
  RelativeMotion(int gdim, const std::vector<double>& X);
  /// Other numbers and another master; the next step starts anew.
  /// @param[in] nodes numbers of the slave nodes in the arrays of displacements
  /// @param[in] others further nodes of the slave facets, which count for the slave's deformation
  void reset(std::span<const std::int32_t> nodes, std::span<const std::int32_t> others, const TrackedSurface& master);
  /// Add a step; stores the master nodes' positions and increments.
  /// @param[in] u displacements [L]
  /// @param[in] du their increments since the last step [L]
  void advance(const double* u, const double* du, TrackedSurface& master);
  /// Was the last step the first one after `reset`? Then paths are zero, and `renew` and `fit` are to be called.
  bool restarted() const { return _restarted; }

  std::size_t size() const { return _points.size(); }
  /// Number of slave node i in the arrays of displacements.
  std::int32_t node(std::size_t i) const { return _points[i].node; }
  /// Its reference position, and that of the last step [L].
  const double* X(std::size_t i) const { return _points[i].X; }
  const double* x(std::size_t i) const { return _points[i].x; }

  /// Length of the path of slave node i and the surface against each other since `reset` [L].
  double path(std::size_t i) const { return _points[i].path; }
  /// Upper bound on the motion of nodes and surface against each other in the last step [L].
  double step() const { return _step; }

  /// Motion of the surface since the last `fit`, the translation `shift` left out [L].
  double since_fit() const { return _surface_path - _fitted; }
  const double* shift() const { return _shift; }
  /// Part of `shift` that belongs to the last step [L].
  const double* step_shift() const { return _step_shift; }
  /// The master's tree has been fitted to the present configuration.
  void fit();

  /// Deformations of the sides since the last `renew` [L].
  double slave_deformation() const { return _slave.deformation(); }
  double master_deformation() const { return _master.deformation(); }
  double deformation() const { return slave_deformation() + master_deformation(); }
  /// Ask for `renew` in the next step. Ignored while deformations are small: the normals of some facets may rotate
  /// with the least motion, which must not ask for renewals that are ever more frequent.
  void request_renewal()
  {
    _renewal_due = _renewal_due || deformation() - 2.0 * (_slave.since_look + _master.since_look) > _least_deformation;
    _look_due = true; // who asks again is judged by what has deformed indeed
  }
  bool renewal_due() const { return _renewal_due; }
  /// Deformations are counted from the present configuration on.
  /// @param[in] u displacements [L]
  void renew(const double* u, const TrackedSurface& master);

private:
  /// A slave node: what a step needs of it lies in one line of the cache.
  struct alignas(64) Point
  {
    double X[3] = {}, x[3] = {}; ///< position in the reference configuration and at the last step
    double path = 0.0;
    std::int32_t node = -1;
  };
  struct Side
  {
    std::vector<double> from;              ///< positions at the last renewal
    double seen = 0.0;                     ///< deformation since then when it was looked at last
    double since_look = 0.0;               ///< sum of the largest motions of the steps since that look
    double shift[3] = {0.0, 0.0, 0.0};     ///< translation since the last renewal
    double left_out[3] = {0.0, 0.0, 0.0};  ///< the same, as it was predicted for the last step: what is left out
    double mean_step[3] = {0.0, 0.0, 0.0}; ///< mean motion in the last step
    double deformation() const { return seen + since_look; }
  };
  template <int D>
  void add_step(const double* u, const double* du, TrackedSurface& master);
  template <int D>
  void look(const double* u, const TrackedSurface& master);
  void restart(const double* du, const TrackedSurface& master);

  int _gdim = 3;
  std::vector<std::int32_t> _others;
  std::vector<Point> _points;
  double _surface_path = 0.0, _fitted = 0.0, _step = 0.0; ///< _fitted: path of the surface when the tree was fitted
  double _shift[3] = {}, _step_shift[3] = {}, _mean_step[3] = {};
  Side _slave, _master;
  std::vector<double> _others_from; ///< displacements of the other nodes at the last renewal
  double _least_deformation = 0.0, _most_unseen = 0.0;
  bool _first = true, _restarted = false, _renewal_due = false, _look_due = false;
};
} // namespace dolfinx_impact::search
