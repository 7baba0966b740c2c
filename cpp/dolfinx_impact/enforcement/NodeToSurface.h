#pragma once
#include "../gap/Rigid.h"
#include "Couple.h"
#include "NodalContact.h"
#include "NodeCandidates.h"
#include "Penalty.h"
#include "spring.h"
#include <array>
#include <memory>
#include <span>
#include <vector>

namespace impact::enforcement
{
struct NodeToSurfaceOptions
{
  double friction = 0.0;        ///< coefficient [1]
  double penalty = 0.0;         ///< pressure per penetration; 0: stiffness from masses and step [F/L^3]
  double kappa = 0.5;           ///< what contact may add to the square of the highest frequency, times dt^2 [1]
  bool balanced = false;        ///< penalty in both directions, each with half the stiffness
  bool kinematic = false;       ///< kinematic contact instead of penalty
  int sweeps = 3;               ///< of kinematic contact
  double search_distance = 0.0; ///< 0: the largest facet's diameter [L]
  bool axisymmetric = false;    ///< nodal areas times 2 pi R
};

/// The slave nodes this rank owns, in the last step. Vectors per node: [i*gdim + c].
struct NodalResults
{
  std::vector<ContactStatus> status;
  std::vector<double> gap;      ///< of open nodes: when they were last looked at; infinite without master [L]
  std::vector<double> normal;   ///< out of the master
  std::vector<double> pressure; ///< normal force per area of the node [F/L^2]
  std::vector<double> traction; ///< force on the slave per area [F/L^2]
  std::vector<double> slip;     ///< since the node closed [L]
};

/// What a checkpoint needs, by owned slave node, for the run to go on bit for bit.
struct NodalHistory
{
  std::vector<double> tangential;  ///< forces [i*gdim + c] [F]
  std::vector<double> slip;        ///< [i*gdim + c] [L]
  std::vector<double> springs;     ///< penalty: force, compliance, gap, surpluses of Spring [5*i + k]
  std::vector<std::int8_t> closed; ///< 1: in contact; -1: below the surface, beside the rim or found there; else 0
  std::vector<std::int64_t> facet; ///< id of the master's facet it was held by, or -1
  std::vector<double> xi;          ///< reference coordinates there, [2*i + alpha]
  std::vector<double> taken;       ///< energy that kinematic contact has taken since the node closed [F L]
  std::vector<double> pulse;       ///< impulse of its last normal forces, fading [F T]
};

/// Springs of given stiffness of all slave nodes that have a master, closed or not.
struct NodalSprings
{
  int num_masters = 0;
  std::vector<std::int32_t> nodes;   ///< numbers of the slave nodes, and `num_masters` of the master for each
  std::vector<std::int32_t> masters; ///< [s*num_masters + j]
  std::vector<double> phi;           ///< shape functions there, as `masters`
  std::vector<double> normal;        ///< [s*gdim + c]
  std::vector<double> stiffness;     ///< [F/L]
};

/// Explicit contact of the slave's nodes with the master's surface or a rigid obstacle (docs/explicit/penalty.md).
class NodeToSurface : public NodalContact
{
public:
  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] slave, master this rank's facets (make_surface)
  /// @throws std::invalid_argument on all ranks for options out of range, facets of another space
  NodeToSurface(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets& master,
                const NodeToSurfaceOptions& options);
  NodeToSurface(const surface::FunctionSpace& V, const surface::Facets& slave, const gap::Rigid& master,
                const NodeToSurfaceOptions& options);

  void search(std::span<const double> u, std::span<const double> du) override;
  std::span<const std::int64_t> remote_nodes() const override;
  std::span<const int> remote_owners() const override;
  std::span<const std::int32_t> needs(operators::Halo& all) override;
  void number(operators::Halo& halo, std::span<const std::int32_t> numbers, const double* mass) override;
  double used(const NodalState& state) const override;
  void forget() override;
  void add_forces(const NodalState& state, double* f) override;
  void correct(double* u, const double* du, const double* before, const double* inverse_mass, double h, double dt,
               double share, double* f) override;
  bool kinematic() const override { return _options.kinematic; }
  void look(const double* u) override;
  ContactEnergy energy() const override;
  Passage passage() const override;
  const double* force() const override { return _force.data(); }

  /// Where a rigid master is now, and how far it has moved since the last step [L].
  void set_obstacle(const std::array<double, 3>& displacement, const std::array<double, 3>& increment) override;
  const NodeToSurfaceOptions& options() const { return _options; }
  const NodeCandidates& candidates() const { return _candidates; }
  const NodalResults& results() const { return _results; }
  const search::NodeTracking& tracking() const { return _tracking; }
  /// How many nodes were left open because they were first seen too deep inside the master.
  std::int64_t implausible() const { return _implausible; }
  /// Contact stiffness of each owned slave node in the last step; zero where open [F/L].
  const std::vector<double>& stiffness() const { return _stiffness; }
  NodalHistory history() const;
  /// @throws std::invalid_argument for arrays of wrong sizes
  void set_history(const NodalHistory& history);
  /// The springs in a configuration, after `number`, instead of a step. Not those of the other direction.
  /// @param[in] u displacements of the Halo's nodes [L]
  /// @throws std::invalid_argument without a given penalty
  NodalSprings springs(const double* u);
  /// Energies of this direction alone, for checkpoints.
  const ContactEnergy& own_energy() const { return _energy; }
  void set_energy(const ContactEnergy& energy) { _energy = energy; }
  /// For tests of tests: facing is judged by the normals of the last search.
  void keep_normals(bool keep);
  /// The other direction of balanced contact, or null.
  NodeToSurface* other() { return _other.get(); }

private:
  /// A slave node and what it touches.
  struct Touch
  {
    std::size_t i;
    std::int32_t node;
    int num = 0;                           ///< master nodes
    const std::int32_t* masters = nullptr; ///< numbers
    const std::int32_t* corners = nullptr; ///< positions in NodeTracking's list of them
    double phi[surface::FacetElement::max_nodes];
    search::Projection at;
  };
  /// A node that kinematic contact acts on in this step; shape functions are in `_phi`.
  struct alignas(64) Closed
  {
    const std::int32_t *masters, *corners; ///< as of Touch
    double normal[3], overlap;             ///< [L]
    std::uint32_t i;
    std::int32_t node;
    bool releases; ///< it leaves the master in this step: its force is known beforehand
  };

  NodeToSurface(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets* master,
                const gap::Rigid* rigid, const NodeToSurfaceOptions& options);
  /// Looks for the master of node i. @returns whether it is nearer than `reach`; else it is open
  bool meets(std::size_t i, const double* u, const double* du, double reach, Touch& touch);
  /// A node below the surface that did not come through it: from beside the rim, or found deep inside.
  bool barred(const Touch& touch, const double* u, const double* du);
  /// Closest point in the configuration u - back*du.
  search::Projection point_before(std::size_t i, const double* u, const double* du, double back) const;
  /// Motion of the step relative to the master's point.
  void relative_motion(std::size_t i, const search::Projection& at, const double* du, double* motion) const;
  /// Follows a node along its way in the step. @returns whether it went through too fast to be held back
  bool passes(Touch& touch, const double* u, const double* du);
  search::Projection rigid_point(std::size_t i, const double* u, const double* du = nullptr, double back = 0.0) const;
  void open(std::size_t i, const search::Projection& at, const double* u);
  double compliance(const Touch& touch, double dt) const;
  template <int D>
  void leave(std::size_t i, const double* n, double change, const double* motion);
  template <int D>
  void add_node(Touch& touch, const NodalState& state, double* f);
  template <int D>
  void add_all(const NodalState& state, double* f);
  // Kinematic contact.
  template <int D>
  void relative(std::size_t q, const double* values, double* out) const;
  void number_kinematic(operators::Halo& halo);
  /// Do contact forces need a moment given back?
  bool turns() const { return !_rigid && !_options.axisymmetric; }
  template <int D>
  void predict(const double* u, const double* du, const double* before);
  template <int D>
  void reaction(std::size_t q, double* out) const;
  template <int D>
  void add_masses(const double* inverse_mass);
  template <int D>
  void release(const double* du, const double* inverse_mass, double h, double dt, double share);
  template <int D>
  void solve_forces(double h, double factor);
  template <int D>
  void apply(const double* inverse_mass, double h);
  template <int D>
  void record(double h, double dt);
  template <int D>
  void correct_all(double* u, const double* du, const double* before, const double* inverse_mass, double h, double dt,
                   double share, double* f);

  NodeToSurfaceOptions _options;
  int _gdim;
  bool _rigid = false;
  gap::Rigid _obstacle;
  std::array<double, 3> _obstacle_increment{}, _obstacle_before{};
  NodeCandidates _candidates;
  search::NodeTracking _tracking;
  std::unique_ptr<NodeToSurface> _other;
  std::vector<std::int64_t> _all_remote; ///< of both directions
  std::vector<int> _all_owners;
  // By the numbers of the Halo that `needs` was given: nodes, candidates, areas of master nodes.
  std::vector<std::int32_t> _needed;
  surface::Facets _facets, _around; ///< candidates; slave facets at the nodes
  std::vector<double> _areas;
  double _share = 1.0; ///< of the stiffness: half when balanced

  operators::Halo* _halo = nullptr;
  std::vector<double> _inverse_mass, _per_area; ///< of slave nodes: reciprocals of masses and areas
  /// What is kept with NodeTracking's master nodes.
  static double inverse_mass(const search::MasterNode& master) { return master.du[3]; }
  static double area_per_mass(const search::MasterNode& master) { return master.x[3]; }
  static void keep(search::MasterNode& master, double mass, double area)
  {
    master.du[3] = 1.0 / mass;
    master.x[3] = area / mass;
  }
  struct alignas(32) Sum
  {
    double force[4] = {};
  };
  std::vector<Sum> _master_force; ///< on them

  NodalResults _results;
  std::vector<double> _tangential, _stiffness;
  std::vector<Spring> _springs;
  static constexpr std::int8_t came_in = -1; ///< of `_closed`: open until its gap is positive
  std::vector<std::int8_t> _closed;
  ContactEnergy _energy;
  std::array<double, 3> _force{};
  std::int64_t _implausible = 0;
  Passage _passage;

  // Kinematic contact: closed nodes of the step, and values at the Halo's nodes. `_sum` is summed over ranks: it is
  // zero at all ghosts but those in `_touched`, and never sent forward.
  std::vector<Closed> _closed_now;
  std::size_t _num_closed = 0;
  int _num_masters = 0;               ///< nodes of a master's facet; 0: rigid
  std::vector<double> _taken, _pulse; ///< as in NodalHistory
  std::vector<double> _phi, _motion, _nodal_force, _along, _across;
  std::vector<Couple> _couples;
  std::vector<double> _arms; ///< of couples
  std::vector<std::int32_t> _touched;
  std::vector<double> _weight, _sum, _moved, _before;
};
} // namespace impact::enforcement
