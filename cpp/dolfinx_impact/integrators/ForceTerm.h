// SPDX-License-Identifier: MIT
#pragma once
#include "../operators/InternalForce.h"
#include "NodalFields.h"
#include "energy.h"
#include <array>
#include <memory>
#include <string>
#include <vector>

namespace dolfinx_impact::integrators
{
using operators::InternalForce;

/// Forces of a form, by what a step may do meanwhile: early ones are computed while the ghosts' displacements arrive,
/// late ones while forces on ghosts go to their owners. Neither touches a ghost node; the outer ones do.
struct FormForces
{
  std::shared_ptr<InternalForce> early, outer, late; ///< none is null; an operator may have no cells
  /// Names of the coefficients that the integrator provides; empty: none. The velocity is that half a step before.
  std::string displacement, velocity;

  std::array<InternalForce*, 3> parts() const { return {early.get(), outer.get(), late.get()}; }
  /// @throws std::invalid_argument for an operator that is null, a name that no kernel has
  void check() const;
  /// Nodes that the outer cells reach, for facets between cells those of ghost cells as well.
  std::vector<std::int32_t> outer_nodes() const;
  /// Have the materials internal variables?
  bool has_history() const;
  /// Elastic energy of this rank's cells in the last evaluation, of materials with internal variables and of those
  /// beside them [F L].
  double elastic_energy() const;
  /// Number of points of this rank whose local equations the last evaluation has not solved.
  std::size_t num_unsolved() const;
  /// The internal variables of the last evaluation are what the next one starts from.
  void commit() const;
  /// Let the kernels read the fields' displacements and velocities.
  void read(const NodalFields& fields) const;
  /// Let the kernels read the nodes' positions from there.
  void read_positions(const operators::NodePositions& positions) const;
};

/// Add an operator's forces to an array of the fields' layout.
void assemble(const InternalForce& operation, const NodalFields& fields, AlignedVector& values);

/// A force of a form whose work counts to an energy of its own. A form on a small surface costs what its facets cost:
/// nothing then is done for all degrees of freedom.
class ForceTerm
{
public:
  /// @throws std::invalid_argument as FormForces::check; for contact, which has no form
  ForceTerm(FormForces forms, WorkKind kind, const NodalFields& fields);

  WorkKind kind() const { return _kind; }
  void read_positions(const operators::NodePositions& positions) const { _forms.read_positions(positions); }
  /// The fields have other ghosts.
  void resize(const NodalFields& fields);
  /// Start from zero.
  void reset();
  /// Forces at the present time level, added to the residual.
  /// @param[in] dt step that led here [T]
  void evaluate(NodalFields& fields, double dt);
  /// The forces of the last time level do work in the step since. To be called before `evaluate`.
  void work_of_step(const NodalFields& fields, double dt);

  /// Sum over ranks: work up to the present time level [F L].
  Work work;
  /// Sum over ranks: displacement times force, with the sign that it has in the residual [F L].
  double signed_position() const { return _sign * _position; }

  /// For checkpoints: this rank's owned entries, with the ghosts' contributions. Collective.
  std::vector<double> saved_force(NodalFields& fields);
  void restore(const NodalFields& fields, std::span<const double> force, const Work& work, double position);
  double position() const { return _position; }

private:
  double power(const NodalFields& fields) const { return sum_with(fields.own_entries, fields.v.data()); }
  double sum_with(std::size_t own, const double* values) const;

  FormForces _forms;
  WorkKind _kind;
  double _sign;                       ///< in the residual
  std::vector<std::int32_t> _entries; ///< of the fields' arrays that the forms reach, increasing
  bool _few = false;                  ///< are they few of all?
  bool _gathered = false;             ///< the force has contributions of other ranks, beyond `_entries`
  AlignedVector _force;
  double _position = 0.0;
};

/// Sum of a[i] b[i], by four sums: additions do not wait for each other.
double sum_of_products(std::size_t size, const double* a, const double* b);
} // namespace dolfinx_impact::integrators
