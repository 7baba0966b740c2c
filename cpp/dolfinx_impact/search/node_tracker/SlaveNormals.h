// SPDX-License-Identifier: MIT
#pragma once
#include "../../common/vectors.h"
#include "Configuration.h"
#include "NodeNormals.h"
#include "NormalRotation.h"
#include "RelativeMotion.h"
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace dolfinx_impact::search
{
/// Normals of the slave at its nodes, and whether a facet faces a node. It owns, for each node, the normal as it was
/// evaluated last, with an upper bound on its rotation rate. A normal is evaluated again only where the bound of its
/// rotation since then leaves room for another answer.
class SlaveNormals
{
public:
  SlaveNormals() = default;
  explicit SlaveNormals(int gdim, std::size_t num_nodes) : _gdim(gdim), _stored(num_nodes) {}
  /// @param[in] facets all slave facets at the nodes, numbered as the displacements
  /// @param[in] nodes their numbers
  void reset(surface::Facets facets, std::span<const std::int32_t> nodes) { _evaluate.reset(std::move(facets), nodes); }
  /// Nodes of the facets that are not among `nodes`, ascending.
  std::span<const std::int32_t> others() const { return _evaluate.others(); }
  /// Deformations are counted anew (RelativeMotion::renew): all normals have to be evaluated.
  void renew();

  /// The stored normal of node i: a unit vector out of the slave.
  const double* stored(std::size_t i) const { return _stored[i].normal; }
  /// Upper bound on its change since it was evaluated. Beyond NormalRotation::most nothing is known.
  double rotation(std::size_t i, const RelativeMotion& motion) const
  {
    return _stored[i].rate * (motion.slave_deformation() + _stored[i].deformation);
  }
  /// Upper bound on the change of the stored normal per deformation [1/L].
  double rate(std::size_t i) const { return _stored[i].rate; }
  /// Evaluate and store the normal of node i if there is none since the last renewal.
  void require(std::size_t i, const double* u, RelativeMotion& motion)
  {
    double space[3];
    if (!std::isfinite(_stored[i].deformation))
      present(i, u, motion, space);
  }
  /// Normal of node i in the present configuration. It is stored if that is nearer to the configuration of the last
  /// renewal: then its bound holds for longer.
  /// @param[out] space may be used for the result
  const double* present(std::size_t i, const double* u, RelativeMotion& motion, double* space);
  /// Does a facet with this normal face node i in the present configuration?
  bool faces(std::size_t i, const double* normal, const double* u, RelativeMotion& motion)
  {
    const double along = dot(normal, stored(i), _gdim), change = rotation(i, motion);
    if (change <= NormalRotation::most && std::abs(along + right_angle) > change)
      return along < -right_angle;
    double space[3];
    return dot(normal, present(i, u, motion, space), _gdim) < -right_angle;
  }
  /// Normal of node i in any configuration.
  void evaluate(std::size_t i, Configuration configuration, double* normal) const
  {
    _evaluate.evaluate(i, configuration, normal);
  }

  /// Number of evaluations in the present configuration so far.
  std::int64_t evaluations() const { return _evaluations; }
  /// For tests of tests: nodes keep the normals of the first step after `reset`.
  void keep(bool keep) { _keep = keep; }
  bool kept() const { return _keep; }

private:
  struct Stored
  {
    double normal[3] = {};
    double deformation = std::numeric_limits<double>::infinity(); ///< of the slave when it was evaluated; infinite: not
    double rate = 1.0;
  };
  int _gdim = 3;
  NodeNormals _evaluate;
  std::vector<Stored> _stored;
  bool _keep = false;
  std::int64_t _evaluations = 0;
};
} // namespace dolfinx_impact::search
