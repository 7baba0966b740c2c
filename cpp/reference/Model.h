// SPDX-License-Identifier: MIT
#pragma once
#include "Csr.h"
#include "element.h"
#include "ordering.h"
#include <map>

namespace impact_reference
{
/// A body (or several) of hand-written elements. Vectors of degrees of freedom are node-major over field().points with
/// the component fastest. Integration rules are arguments: whoever calls decides.
class Model
{
public:
  /// @param mesh cells in own node order (see node_vertices), cell_tags one per cell if there are several materials
  /// @param materials by tag; a single entry serves all cells when the mesh has no tags
  /// @param degree polynomial degree of the field, 1 or 2
  /// @throws std::invalid_argument for anything geometry(), check() or the element routines refuse, for a tag without a
  /// material and for materials of different hypotheses
  Model(const impact_plain::Mesh& mesh, const std::map<int, Material>& materials, int degree);

  const Geometry& geometry() const { return geometry_; }
  const Field& field() const { return field_; }
  Hypothesis hypothesis() const { return hypothesis_; }
  bool linear() const { return linear_; } ///< true if every material is linear elastic
  std::vector<std::int64_t> elimination_order() const { return dissection(field_, pattern_); }
  int gdim() const { return int(geometry_.points.cols()); }
  std::int64_t num_dofs() const { return gdim() * field_.points.rows(); }
  std::int64_t num_cells() const { return geometry_.cells.rows(); }
  const Material& material(std::int64_t cell) const { return materials_[material_of_cell_[cell]]; }
  int tag(std::int64_t cell) const { return tags_[material_of_cell_[cell]]; }

  /// For those who integrate over cells themselves.
  Sampler sampler(const Rule& rule) const;
  const Pattern& pattern() const { return pattern_; }
  Matrix cell_points(std::int64_t cell) const;                   ///< geometry nodes (num_geometry_nodes, gdim) [L]
  std::vector<std::int64_t> cell_nodes(std::int64_t cell) const; ///< of the field
  Vector gather(const Vector& u, std::int64_t cell) const;
  void scatter(Vector& global, int block, std::int64_t cell, const Vector& element) const;
  void check_vector(const Vector& u) const; ///< @throws std::invalid_argument for a wrong size or NaN

  Csr stiffness(const Rule& rule) const;                                                 ///< seed (3.26) [F/L]
  Csr mass(const Rule& rule) const;                                                      ///< consistent [M]
  Vector lumped_mass(const Rule& rule, const std::string& scheme) const;                 ///< diagonal [M]
  Csr damping(const Rule& rule, const Rule& mass_rule, double alpha, double beta) const; ///< alpha M + beta K, (3.67)
  double energy(const Rule& rule, const Vector& u) const;                                ///< [F L]
  Vector internal_force(const Rule& rule, const Vector& u) const;                        ///< [F]
  Csr tangent(const Rule& rule, const Vector& u) const;                                  ///< [F/L]
  Csr elastic_tangent(const Rule& rule, const Vector& u) const;                          ///< without springs [F/L]
  /// Let `energy` and `internal_force` have pressures averaged at the nodes from now on (NodalPressure.h): that of
  /// lambda (tr eps)^2 / 2 or lambda (ln J)^2 / 2. There is no tangent then.
  /// @throws std::invalid_argument for cells, hypotheses and laws that this is not for
  void average_pressure();
  /// The same, and a share of 0.6 of the other part of the energy with strains averaged at the nodes (NodalStrain.h).
  void average_strain();
  /// Stress at the points of every cell, rows cell-major, and the positions of these points.
  std::array<Matrix, 2> stress(const Rule& rule, const Vector& u) const;

  Vector body_force(const Rule& rule, const Vector& f) const; ///< [F]
  /// @param facets geometry nodes, one facet per row; vertices suffice
  Vector traction(const Rule& facet_rule, const Cells& facets, const Vector& t) const; ///< [F]
  /// Force and tangent of a pressure that follows the facets, which must lie on the boundary.
  std::pair<Vector, Csr> follower_pressure(const Rule& facet_rule, const Cells& facets, const Vector& u,
                                           double p) const;

  /// Matrix of springs (or dashpots) between boundary facets and the ground, see `foundation` [F/L] ([F T/L]).
  Csr foundation(const Rule& facet_rule, const Cells& facets, const Vector& k) const;
  /// Let springs and dashpots from now on be part of all analyses: `internal_force`, `tangent` and `energy` have the
  /// springs, `stiffness` and `elastic_tangent` do not.
  /// @throws std::invalid_argument for a matrix of another model
  void add_foundation(const Csr& springs, const Csr& dashpots);
  /// Let mass on facets be part of `mass`, `lumped_mass` (by its row sums) and all analyses.
  /// @param mass of `foundation` with the mass per area along each coordinate [M]
  /// @throws std::invalid_argument for a matrix of another model
  void add_mass(const Csr& mass) { added_mass_.add(mass); }
  const Csr& added_mass() const { return added_mass_; } ///< on the pattern of the model [M]
  const Csr& springs() const { return springs_; }       ///< on the pattern of the model [F/L]
  const Csr& dashpots() const { return dashpots_; }     ///< likewise [F T/L]
  bool on_foundation() const { return on_foundation_; }

  Csr gyroscopic(const Rule& rule, const Vector& spin, const Vector& centre) const;  ///< seed (3.56) [M/T]
  Csr ale_inertia(const Rule& rule, const Vector& spin, const Vector& centre) const; ///< seed (3.57) [M/T^2]
  Vector ale_load(const Rule& rule, const Vector& spin, const Vector& centre) const; ///< [F]
  Csr poisson(const Rule& rule, double k) const;                                     ///< scalar field on the same nodes
  Vector scalar_load(const Rule& rule, double f) const;                          ///< int f N_i dV of the scalar field
  Vector flux_load(const Rule& facet_rule, const Cells& facets, double q) const; ///< int q N_i dS of the scalar field

  /// Force of the bulk viscosity's pressure q at displacements u and velocities v, int B^T q dV [F]
  /// (docs/explicit/scheme.md).
  /// @param deformed of the deformed body; always so where the material's own law knows finite strain
  Vector viscous_force(const Rule& rule, const Vector& u, const Vector& v, double b1, double b2,
                       bool deformed = false) const;
  /// Highest frequency of a cell alone, with its own part of the lumped mass and the stiffness at rest [1/T].
  double cell_frequency(const Rule& rule, const Rule& mass_rule, const std::string& scheme) const;
  /// Shortest time in which a dilatational wave runs along an edge (half of one at degree 2), (3.79), (3.80) [T].
  double passage() const;

  /// Displacements that cost no energy: columns; 3 in the plane, 6 in space, 1 (along z) if axisymmetric. Rotations are
  /// about the centre of all nodes.
  Matrix rigid_modes() const;

private:
  /// Material of a cell, without what is averaged at the nodes.
  Material own_material(std::int64_t cell) const;
  FacetSampler facet_sampler(const Rule& rule) const;
  FacetPlace locate(const Cells& facets, std::int64_t row) const;
  template <typename F>
  Csr assemble(int block, F&& element) const;
  template <typename F>
  Vector assemble_vector(int block, F&& element) const;

  Geometry geometry_;
  Field field_;
  Pattern pattern_;
  FacetIndex facets_;
  std::vector<Material> materials_;
  std::vector<int> tags_, material_of_cell_; // tags of the materials
  Hypothesis hypothesis_;
  bool linear_, on_foundation_ = false, averages_pressure_ = false, averages_strain_ = false;
  Csr springs_, dashpots_, added_mass_;
};
} // namespace impact_reference
