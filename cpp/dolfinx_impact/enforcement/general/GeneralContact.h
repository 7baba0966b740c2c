// SPDX-License-Identifier: MIT
#pragma once
#include "../../search/general/FacetLoops.h"
#include "../../search/general/NamedPair.h"
#include "../../search/general/SurfaceNodes.h"
#include "../../search/general/beyond_end.h"
#include "../../search/general/closest_on_loop.h"
#include "../../search/general/crossed_edges.h"
#include "../ContactStatus.h"
#include "../node_to_surface/NodalContact.h"
#include "../node_to_surface/NodeCandidates.h"
#include "PairSpring.h"
#include <array>
#include <limits>
#include <map>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace dolfinx_impact::enforcement
{
struct GeneralContactOptions
{
  double friction = 0.0;     ///< coefficient [1]
  bool axisymmetric = false; ///< areas are multiplied by 2 pi R; facets on the axis are none of the surface
};

using search::NamedPair;

/// Results of the last step at the surface nodes that this rank owns. Vectors: [i*gdim + c].
struct GeneralResults
{
  std::vector<ContactStatus> status; ///< of the node's own spring; of several, that with the largest force
  std::vector<double> gap;           ///< of this spring; infinite while it is open [L]
  std::vector<double> slip;          ///< accumulated since this spring closed [L]
};

/// Explicit contact of all facets of a surface with each other, by penalty; docs/explicit/general_contact.md. No side
/// is a master: each surface node has a spring to the facet that it has come through, in a corner up to three, and each
/// two sharp edges that have crossed have one between the points where they cross.
class GeneralContact : public NodalContact, public SpringForces
{
public:
  /// Collective.
  /// @param[in] V displacement space of degree 1
  /// @param[in] facets this rank's facets of the surface (make_surface), straight ones
  /// @param[in] named pairs of surfaces that are left to others
  /// @throws std::invalid_argument on all ranks for options out of range, facets that are not straight, too many pairs
  GeneralContact(const surface::FunctionSpace& V, const surface::Facets& facets,
                 const GeneralContactOptions& options = {}, std::span<const NamedPair> named = {});

  void search(std::span<const double> u, std::span<const double> du) override;
  std::span<const std::int64_t> remote_nodes() const override { return _candidates.remote_nodes(); }
  std::span<const int> remote_owners() const override { return _candidates.remote_owners(); }
  std::span<const std::int32_t> required_nodes(operators::Halo& all) override;
  void assign_numbers(operators::Halo& halo, std::span<const std::int32_t> numbers,
                      std::span<const double> mass) override;
  double largest_position() const override { return 0.0; }
  void set_obstacle(const gap::RigidMotion&) override {}
  double increment_used(const NodalState& state) const override { return _candidates.increment_used(state); }
  void forget_search() override { _candidates.forget(); }
  void update_gaps(std::span<const double>) override {}
  void add_forces(const NodalState& state, std::span<double> f) override;
  ContactEnergy energy() const override { return _energy; }
  Passage passage() const override { return _passage; }
  /// Zero: all forces act between nodes of the surface.
  const std::array<double, 3>& force() const override { return _no_force; }
  state::State saved_state() const override;
  void resume(const state::State& saved) override;
  void reset() override;

  const GeneralContactOptions& options() const { return _options; }
  const NodeCandidates& candidates() const { return _candidates; }
  const surface::Facets& facets() const { return _candidates.slave(); }
  const GeneralResults& results() const { return _results; }
  /// Compliances that the bodies offer to springs at the nodes that this rank owns (nodal_compliances), zero: unknown.
  /// @throws std::invalid_argument for another number of nodes, negative or infinite values
  void set_nodal_compliances(std::vector<double> compliances);
  bool lacks_compliances() const { return _known.empty(); }
  /// Forces of the last step on the surface nodes that this rank owns, as node of a spring, as corner of a facet and as
  /// end of an edge, [i*gdim + c]. Collective [F].
  std::vector<double> nodal_forces() const;
  /// Mean outward normals of the surface at the nodes that this rank owns, at the last step, unit, [i*gdim + c] [1].
  std::vector<double> normals() const;
  /// Number of nodes and edges of this rank that were met for the first time deep inside another body.
  std::int64_t implausible() const { return _num_implausible; }
  /// Number of springs of this rank: of nodes, and of crossed edges.
  std::pair<std::int64_t, std::int64_t> num_springs() const;
  /// Deepest penetration of this rank's springs in the last step, zero without any [L].
  double deepest() const { return _deepest; }
  /// What the present lists hold on this rank: pairs of nodes and facets, pairs of edges.
  std::pair<std::int64_t, std::int64_t> num_candidates() const
  {
    return {std::int64_t(_list.size()), std::int64_t(_edge_pairs.size())};
  }

private:
  /// Spring of two edges, and where its last force acts.
  struct EdgeSpring
  {
    PairSpring spring;
    double weights[4] = {}; ///< of the ends in the last step, while it is closed; zero: not known
    double turn[12] = {};   ///< moment correction of the last force at the ends [F]
  };
  /// Two edges near each other; `first` has the smaller id.
  struct EdgePair : EdgeSpring
  {
    std::int32_t first = -1, second = -1;
    double next = 0.0; ///< motion from which they have to be looked at again [L]
  };
  /// Edges that go on as others: does a pair wait while another one bears, or follow it?
  enum class Following
  {
    no,
    waits,
    follows
  };
  /// A facet that a node touches.
  struct Touch
  {
    std::size_t facet = 0;
    double weights[4], normal[3];
    double gap = std::numeric_limits<double>::infinity(); ///< infinite: none [L]
    int slot = -1;                                        ///< of the node's springs
  };
  struct Touches;
  /// A facet that ends beside a node.
  template <int D>
  struct FacetEnd
  {
    Touch touch;
    search::loop::BeyondEnd<D> at;
    double slack; ///< [L]
  };
  /// Where the force of the last step on a node acts.
  struct LastTouch
  {
    std::int64_t facet = -1;        ///< id; -1: not known
    std::int32_t corners[4] = {-1}; ///< numbers; -1: not known
    double weights[4] = {};
    double turn[12] = {}; ///< moment correction at the corners [F]
  };
  /// Spring of a node to a facet, and what its last step was.
  struct NodeSpring
  {
    PairSpring spring;
    LastTouch last;
    double slip[3] = {}; ///< accumulated since it closed [L]
    ContactStatus status = ContactStatus::open;
  };
  /// Is the first spring open, or has it less force?
  static bool is_weaker(const NodeSpring& first, const NodeSpring& second)
  {
    const PairSpring &a = first.spring, &b = second.spring;
    return a.closed != b.closed ? b.closed : a.spring.force < b.spring.force;
  }
  /// Springs that a node may have, to facets whose normals differ.
  static constexpr int springs_per_node = 3;
  typedef std::pair<std::int64_t, std::int64_t> EdgeKey;

  template <int D>
  void corners_at(std::size_t f, const double* x, const double* minus, double (&out)[4][D]) const;
  template <int D>
  bool faces(std::int32_t node, const double* normal) const;
  template <int D>
  search::loop::Closest<D> closest(std::size_t f, const double (&corners)[4][D], const double* x) const;
  bool corrects_moments() const { return _options.friction > 0.0 && !_options.axisymmetric; }
  template <int D>
  bool behind_neighbours(std::size_t f, const double* x, const search::loop::Closest<D>& at) const;
  template <int D>
  void find(std::size_t i, const NodalState& state, Touches& touches);
  template <int D>
  bool look(std::size_t i, int slot, const NodalState& state, Touches& touches);
  template <int D>
  bool look_beyond(std::size_t i, int slot, const NodalState& state, Touches& touches);
  template <int D>
  bool may_begin(std::size_t i, std::size_t f, double gap, const NodalState& state, bool inside);
  template <int D>
  bool in_corner(const double* x, const Touch& first, const Touch& second) const;
  bool belongs(std::size_t i, int slot, const double* normal, const Touches& touches) const;
  template <int D>
  void add_node(std::size_t i, const NodalState& state);
  template <int D>
  void update_results(std::size_t i, const Touches& touches);
  double height_of(std::size_t f) const;
  NodeSpring* springs_of(std::size_t i) { return _springs.data() + i * springs_per_node; }
  const NodeSpring* springs_of(std::size_t i) const { return _springs.data() + i * springs_per_node; }
  void add_springs(state::State& out, int slot) const;
  void resume_springs(const state::State& saved, int slot);
  void count_closed(std::size_t i);
  void add_edges(EdgePair& pair, const NodalState& state);
  search::loop::Crossing cross_beyond(std::int32_t first, std::int32_t second, const double* minus) const;
  Following follows(const EdgePair& pair, const search::loop::Crossing& now, const NodalState& state) const;
  bool goes_on_elsewhere(const EdgePair& pair, const search::loop::Crossing& now) const;
  void continue_edges();
  template <int D>
  void add_all(const NodalState& state, std::span<double> f);
  void update_positions(const NodalState& state);
  void forget_distances();
  void update_compliances(double dt);
  template <int D>
  void list_facets(const std::vector<double>& x);
  void list_edges(const std::vector<double>& x);
  template <int D>
  void add_normals(std::vector<double>& out) const;
  void keep_edges();
  bool named(std::int32_t node, std::size_t facet) const;
  std::size_t num_nodes() const { return _num_closed.size(); }

  GeneralContactOptions _options;
  int _gdim;
  search::SurfaceNodes _surface;
  NodeCandidates _candidates;
  std::vector<double> _known;  ///< compliances of owned nodes of the space [L/F]
  std::vector<double> _shared; ///< the same over the nodes of the Halo of `required_nodes`
  std::vector<std::int32_t> _needed;
  surface::Facets _found; ///< candidate facets, numbered by the Halo of `required_nodes`
  operators::Halo* _halo = nullptr;

  // By number.
  std::vector<double> _X, _x, _forces;               ///< [node*gdim + c]
  std::vector<double> _inverse_mass, _area, _height; ///< [1/M], [L^2], [L]
  std::vector<double> _surface_compliance;           ///< known one, then that of the present step [L/F]
  std::vector<double> _compliance;
  std::vector<std::int64_t> _group;
  std::vector<std::int32_t> _body;
  double _compliance_step = 0.0;

  search::FacetLoops _loops;
  std::vector<std::int32_t> _starts, _list; ///< facets near each node: _list[_starts[i] ... _starts[i+1]-1]
  std::vector<std::int8_t> _has_corners;    ///< by node: could two of its facets make a corner?
  /// Distances of listed facets when they were computed last, plus twice `_moved` of then: no facet has come nearer
  /// than what this has more than twice `_moved` of now. Minus infinity: not known [L].
  std::vector<double> _distances;
  /// Of the node that is looked at; kept, as a time step allocates nothing.
  std::tuple<std::vector<FacetEnd<2>>, std::vector<FacetEnd<3>>> _ends;
  std::vector<double> _next; ///< by node, as in EdgePair
  std::vector<EdgePair> _edge_pairs;
  std::vector<std::array<std::int32_t, 2>> _continuations; ///< edge that goes on at each end of an edge; -1: none
  std::map<EdgeKey, EdgeSpring> _kept_edges;               ///< histories until edges are listed again
  std::map<EdgeKey, std::int32_t> _kept_owners;            ///< of those that `resume` brought: position among the nodes
  double _moved = 0.0;          ///< sum of the largest increments since the lists were made [L]
  double _largest_step = 0.0;   ///< largest increment of a node in this step [L]
  double _largest_height = 0.0; ///< of the cells at the nodes [L]

  std::vector<NodeSpring> _springs;     ///< [node*springs_per_node + slot]
  std::vector<std::int8_t> _num_closed; ///< springs of each node
  bool _first = true;                   ///< no forces were computed yet
  GeneralResults _results;
  ContactEnergy _energy;
  Passage _passage;
  double _deepest = 0.0;
  std::int64_t _num_implausible = 0;
  std::array<double, 3> _no_force{};
};

/// Positions of the corners of a facet, less some increments.
template <int D>
void GeneralContact::corners_at(std::size_t f, const double* x, const double* minus, double (&out)[4][D]) const
{
  for (int k = 0; k < _loops.num_corners(); ++k)
    for (int c = 0; c < D; ++c)
    {
      const std::size_t at = std::size_t(_loops.corners(f)[k]) * D + c;
      out[k][c] = x[at] - (minus ? minus[at] : 0.0);
    }
}
} // namespace dolfinx_impact::enforcement
