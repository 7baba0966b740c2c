// SPDX-License-Identifier: MIT
#pragma once
#include "../operators/CooMatrix.h"
#include "../search/closest_point/PairSearch.h"
#include "mortar.h"
#include <memory>
#include <unordered_map>

namespace dolfinx_impact::gap
{
/// Owned nodes of a slave surface that multipliers may live at.
struct MultiplierNodes
{
  std::vector<std::int32_t> nodes; ///< owned blocks of V
  std::vector<double> share;       ///< integral of the node's function over the whole facets [L, L^2]
  std::vector<double> area;        ///< of the facets around it [L, L^2]
  std::unordered_map<std::int64_t, double> facet_area; ///< of this rank's facets by their numbers (Facets::id) [L, L^2]

  /// Areas of the facets around each node that count there. Collective.
  /// @param[in] map of the facets' nodes, whose first are those of V
  /// @param[in] counts of `counting`
  std::vector<double> counted_area(const std::shared_ptr<const dolfinx::common::IndexMap>& map,
                                   const surface::Facets& slave, std::span<const std::int8_t> counts) const;
};

/// Numbers (Facets::id) of facets that do not count at one of their nodes.
std::vector<std::int64_t> aside(const surface::Facets& slave, std::span<const std::int8_t> counts);

/// Part of the area of its facets that the integral of a node's function must exceed.
inline constexpr double least_share = 1e-2;

/// Nodes that carry multipliers. Collective.
/// @param[in] slave this rank's facets, numbered as V
/// @param[in] rule on the reference facet
MultiplierNodes multiplier_nodes(const surface::FunctionSpace& V, const surface::Facets& slave, const SegmentRule& rule,
                                 Multipliers basis, bool axisymmetric);

/// Rows of D^-1 M, D the diagonal: what some slave nodes face.
struct MasterRows
{
  std::vector<std::int64_t> pointers; ///< of each node and the end
  std::vector<std::int64_t> columns;  ///< global nodes: the master's, and slave nodes without a multiplier
  std::vector<double> values;
};

/// Mortar integrals of two deformable surfaces in one state of displacements, D and M as PETSc matrices. Arrays are by
/// the multiplier nodes, n of them. Several states may share one search: the last update has moved it.
class MortarIntegrals
{
public:
  /// @param[in] rule on the reference segment; copied
  MortarIntegrals(std::shared_ptr<const surface::FunctionSpace> V, std::shared_ptr<search::PairSearch> search,
                  MultiplierNodes nodes, const SegmentRule& rule, Multipliers basis, bool axisymmetric);

  /// Search, segments, `around` and normals: what comes before `integrate`. Collective.
  /// @param[in] u, start displacements now and when the step began, owned and ghosts [L]
  void update_cover(std::span<const double> u, std::span<const double> start);
  /// Integrals where these nodes carry the multipliers: after `update_cover`. Collective.
  /// @param[in] carriers mask of the n nodes
  void integrate(std::span<const std::int8_t> carriers);
  /// Nodes of which enough is covered, mask of the n nodes.
  std::vector<std::int8_t> covered() const;
  /// Unit normals and gaps from the integrals; gaps are means over the cover, infinite without master.
  /// @param[in] locked components, [i*gdim + c], along which facets may not tilt a normal by a little (planes of
  /// symmetry, docs/contact.md); empty: none
  /// @param[in] symmetry largest part of a unit normal that is such a tilt
  void update_gap(std::span<const std::int8_t> locked = {}, double symmetry = 0.0);
  /// Areas of the facets that count around the n nodes [L, L^2].
  const std::vector<double>& area() const { return _area; }
  /// Numbers (Facets::id) of the facets that lie round a sharp edge and take no part.
  std::vector<std::int64_t> aside() const { return gap::aside(_search->slave(), _counts); }
  /// Sums of facet normals at the n nodes, [i*gdim + c].
  std::vector<double> sums_at_nodes() const;
  /// Replaces them, where other surfaces continue this one. Collective.
  void set_sums(std::span<const double> sums);

  const MultiplierNodes& nodes() const { return _nodes; }
  std::vector<std::int8_t> participates; ///< nodes that carry a multiplier here
  std::vector<double> weight;            ///< diagonal of D: force per multiplier [L, L^2]
  std::vector<double> cover;             ///< integral of the function over the part that faces a master [L, L^2]
  std::vector<double> normal;            ///< [i*gdim + c], out of the master
  std::vector<double> gap;               ///< [L]
  std::vector<double> weighted_gap;      ///< gap times cover, zero without a multiplier [L^2, L^3]
  std::vector<double> around;            ///< integral of the node's function over the cover, carrier or not [L, L^2]
  double least_cover = gap::least_cover; ///< covered part of a facet below which it counts as not covered

  const Segments& segments() const { return _segments; }
  const Mortar& entries() const { return _mortar; }
  /// Sums of facet normals by nodes of the map, complete, [node*gdim + c].
  const std::vector<double>& normal_sums() const { return _sums; }
  std::shared_ptr<const dolfinx::common::IndexMap> map() const { return _map; }
  const search::PairSearch& search() const { return *_search; }

  /// M, rows and columns are nodes; slave nodes beside the diagonal of D stand among the master's. Borrowed.
  Mat M() const { return _mortar_matrix.matrix(); }
  /// D - M: weighted displacements of slave against master. Borrowed, valid until the next call. Collective.
  Mat jump_matrix();
  /// Integrals of the displacement of slave against master, [i*gdim + c] [L^2, L^3]; over the cover they are its means.
  /// Collective.
  /// @param[in] moved increments, owned entries of V [L]
  std::vector<double> weighted_jump(std::span<const double> moved) const;
  /// M times nodal values of `block` components (owned), of the multiplier nodes. Collective.
  std::vector<double> over_master(std::span<const double> values, int block) const;
  /// Nodal forces D^T z on the slave and -M^T z on the master, owned entries [F]. Collective.
  /// @param[in] traction [i*gdim + c] [F/L^2]
  std::vector<double> contact_forces(std::span<const double> traction) const;
  /// Rows of D^-1 M of some of the n nodes.
  MasterRows master_rows(std::span<const std::int32_t> rows) const { return master_rows(rows, weight); }
  /// Rows of M over other weights.
  /// @param[in] weights of all n nodes
  MasterRows master_rows(std::span<const std::int32_t> rows, std::span<const double> weights) const;
  /// Points slide over the master, normals turn: derivative of minus the contact force at given multipliers and
  /// tractions; null where there are none. Borrowed, valid until the next call. Collective.
  /// @param[in] multiplier [i] [F/L^2]
  /// @param[in] traction [i*gdim + c] [F/L^2]
  /// @param[in] active [i]
  Mat tangent(std::span<const double> multiplier, std::span<const double> traction,
              std::span<const std::int8_t> active);

private:
  MPI_Comm comm() const; ///< for matrices
  std::vector<double> summed(std::vector<double> values, int block, bool forward_only = false) const;

  std::shared_ptr<const surface::FunctionSpace> _space;
  std::shared_ptr<search::PairSearch> _search;
  MultiplierNodes _nodes;
  std::vector<double> _points, _weights; ///< of the rule
  Multipliers _basis;
  bool _axisymmetric;
  std::shared_ptr<const dolfinx::common::IndexMap> _map;
  Segments _segments;
  Mortar _mortar;
  std::vector<double> _sums, _gamma, _area;
  std::vector<std::int8_t> _counts; ///< which facets count at which of their nodes, [facet*num_nodes + i]
  operators::CooMatrix _mortar_matrix, _jump, _sliding, _turning, _facing;
  std::shared_ptr<_p_Mat> _tangent;
};

/// Matrix of springs between nodes and what they face on the master. Collective.
/// @param[in] map of V's nodes. @param[in] nodes owned blocks
/// @param[in] rows of these nodes; empty for rigid masters
/// @param[in] blocks stiffness, [(i*gdim + a)*gdim + b] [F/L]
void assign_springs(const dolfinx::common::IndexMap& map, int gdim, std::span<const std::int32_t> nodes,
                    const MasterRows& rows, std::span<const double> blocks, operators::CooMatrix& out);
} // namespace dolfinx_impact::gap
