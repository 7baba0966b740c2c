// SPDX-License-Identifier: MIT
#pragma once
#include "contact_explicit.h"

namespace impact_reference
{
/// Contact without pairs as docs/explicit/general_contact.md states it: every node against every facet and every edge
/// against every edge, in every step.
class GeneralContact : public ExplicitContact
{
public:
  /// @param outside all outer facets, of degree 1
  /// @param stiffness of the surface's nodes (nodal_stiffness) [F/L]
  /// @param mass lumped (num_dofs) [M]
  /// @throws std::invalid_argument for facets of degree 2
  GeneralContact(const Model& model, Surface outside, NodalStiffness stiffness, const Vector& mass, double friction);

  void before(const ContactStep& step) override;
  bool kinematic() const override { return false; }
  std::vector<std::int64_t> nodes() const override { return nodes_; }
  Vec<double> master_moved(int) const override { return {}; }

private:
  using Share = std::pair<std::int64_t, double>; // a node and its weight
  using Push = std::pair<std::int64_t, Vec<double>>;
  // What a spring keeps of the step before.
  struct Spring
  {
    bool closed = false;
    double gap = 0, offset = 0;       // without and with what is added to it [L]
    double normal = 0, stiffness = 1; // [F], [F/L]
    double e = 0, q = 0;              // as in NodalPenalty [F L]
    Vec<double> n, t, slip;           // normal, friction's force, slip [1], [F], [L]
    std::vector<Share> shares;        // of the last force: positive at the first point, negative at the second
    std::vector<Push> turning;        // moment correction of the last force [F]
  };
  // Two points that may touch.
  struct Meeting
  {
    double gap = std::numeric_limits<double>::infinity(); // [L]
    Vec<double> n, first, second;                         // outward from the second body; the points [1], [L]
    std::vector<Share> shares;
    std::vector<std::int64_t> turning; // nodes that take the moment
    double stiffness = 0;              // [F/L]
    bool follows = false;              // another pair bore the force before
  };
  struct Closest
  {
    double distance = std::numeric_limits<double>::infinity(); // [L]
    Vec<double> away, n;         // from the closest point to the other one; normal of the facet there
    std::vector<double> weights; // of the corners
    bool flat = false;           // inside of a flat piece
    std::vector<int> ends;       // corners that span the side or are the corner it lies on; none: inside
  };
  struct Edge
  {
    std::int64_t nodes[2];
    int facets[2], sides[2];
    int goes_on[2] = {-1, -1}; // as which edge, at each end
  };
  struct Crossing
  {
    bool valid = false;
    double at[2] = {0, 0}, gap = 0;
    Vec<double> n, points[2];
  };
  // A facet that a node may touch, as far as it ends there or beyond its end.
  struct Candidate
  {
    int facet = -1, slot = -1;
    bool beyond = false, inside = false;
    double gap = 0, height = 0;  // [L]
    Vec<double> n, facet_n;      // direction of a force; of the facet where it is closest
    Vec<double> second, excess;  // the other point; of it from the closest point of the facet [L]
    std::vector<double> weights; // of the corners
  };
  static constexpr int springs_per_node = 3;
  using NodeSprings = std::array<Spring, springs_per_node>;
  using Corners = std::vector<Vec<double>>;

  Vec<double> at(const Vector& field, std::int64_t node) const;
  Corners corners(int facet, const Vector& u) const;
  Vec<double> side_normal(int facet, int side, const Vector& u) const;
  Closest closest(int facet, const Vec<double>& x, const Vector& u) const;
  bool inside(int facet, const Closest& found, const Vec<double>& x, const Vector& u) const;
  bool faces(std::int64_t node, const Vec<double>& n, const Vector& u) const;
  bool far_side(std::int64_t node, int facet) const;
  double compliance(std::int64_t node, double dt) const;
  std::vector<Candidate> candidates(std::int64_t node, const ContactStep& step) const;
  void go_on(Candidate& c, const Closest& found, const Vec<double>& x, const Vector& u) const;
  bool may_begin(const Candidate& c, std::int64_t node, const ContactStep& step) const;
  bool in_corner(const Candidate& a, const Candidate& b, const Vec<double>& x, const Vector& u) const;
  bool pick(int slot, bool beyond, std::int64_t node, const NodeSprings& springs, const std::vector<Candidate>& all,
            const ContactStep& step, std::vector<Candidate>& chosen) const;
  std::vector<Candidate> choose(std::int64_t node, const NodeSprings& springs, const ContactStep& step) const;
  Meeting meet(std::int64_t node, const Candidate& c, const ContactStep& step) const;
  void advance(std::int64_t node, std::int64_t place, const ContactStep& step);
  Crossing cross_edges(const Edge& a, const Edge& b, const Vector& u, bool lines = false) const;
  Crossing cross_beyond(const Edge& a, const Edge& b, const Vector& u) const;
  std::vector<std::pair<const Edge*, const Edge*>> beside(const Edge& a, const Edge& b, const Crossing& now) const;
  Meeting meet(const Edge& a, const Edge& b, const Spring& spring, const ContactStep& step) const;
  ContactStatus advance(Spring& spring, const Meeting& m, const ContactStep& step);
  void clear();
  void find_edges();
  void find_bodies();

  const Model& model_;
  Surface outside_;
  NodalStiffness stiffness_;
  Vector mass_;
  double friction_;
  double fastest_ = 0, longest_ = 0;       // largest motion of a node against the mean in the step; of facets [L]
  std::vector<std::int64_t> nodes_, body_; // body of each node of the field
  std::map<std::int64_t, double> areas_, height_;   // by node [L^2], [L]
  std::map<std::int64_t, std::vector<int>> facets_; // at a node
  std::map<std::int64_t, Vec<double>> rest_;        // position of a node [L]
  std::vector<Edge> edges_;
  std::map<std::int64_t, NodeSprings> springs_;
  std::map<std::pair<std::size_t, std::size_t>, Spring> edge_springs_;
};
} // namespace impact_reference
