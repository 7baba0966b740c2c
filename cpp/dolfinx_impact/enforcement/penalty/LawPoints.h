// SPDX-License-Identifier: MIT
#pragma once
#include "../../gap/points.h"
#include "../../state/State.h"
#include "../ContactStatus.h"
#include "../interface/InterfaceLaw.h"
#include "variation.h"
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// A law of the interface at the quadrature points of a contact, in increments: what the points remember of the last
/// converged state, and what the law returns in the present one.
class LawPoints
{
public:
  LawPoints(std::shared_ptr<const InterfaceLaw> law, std::size_t num_points);

  const InterfaceLaw& law() const { return *_law; }
  /// Length of the increment in time; zero in static problems [T].
  double time_step = 0.0;

  /// Displacements of slave against master since the last converged state, and total slips, at the points.
  struct Motion
  {
    std::span<const double> offset;    ///< added to the gaps [L]
    std::span<const double> slip;      ///< of the last converged state, [q*gdim + c] [L]
    std::span<const double> increment; ///< [q*gdim + c] [L]
  };
  /// Values of the law's fields at the points, [field][q].
  typedef std::vector<std::vector<double>> Fields;

  /// Evaluate the law at the points within its reach.
  void evaluate(const gap::Points& points, const Motion& motion, const Fields& slave, const Fields& master);

  /// Was the law asked at a point, and has it a traction or a stiffness there?
  bool acts(std::size_t q) const { return _acts[q] != 0; }
  ContactStatus status(std::size_t q) const;
  double pressure(std::size_t q) const { return _place[q] < 0 ? 0.0 : _tractions.pressure[_place[q]]; }
  /// Traction on the slave along the surface; null where the law was not asked.
  const double* shear(std::size_t q) const { return _place[q] < 0 ? nullptr : _shear.data() + _place[q] * _gdim; }
  /// Slip at the end of the increment; null where the law was not asked.
  const double* slip(std::size_t q) const { return _place[q] < 0 ? nullptr : _points.slip.data() + _place[q] * _gdim; }
  /// Minus the derivative of the pressure by the gap, with that by its rate [F/L^3].
  double stiffness(std::size_t q) const;
  /// Largest derivative of pressure and shear traction by gap and slip of this rank's points [F/L^3].
  double largest_stiffness() const;
  /// Points of this rank whose local equations were not solved in the last evaluation.
  std::int64_t num_unsolved() const { return _tractions.num_unsolved; }

  /// Derivative of the traction pressure*normal + shear of a point that acts, as a linear map: gdim x v.num.
  /// @param[in] n,increment normal and increment of the point
  /// @param[in] d_increment derivative of the increment, gdim x v.num
  /// @param[out] dz gdim x v.num
  void traction_derivative(std::size_t q, const Variation& v, const double* n, const double* increment,
                           const double* d_increment, double* dz) const;

  /// Is there a last converged state?
  bool has_begun() const { return _begun != 0.0; }
  /// The state of the last evaluation is that of the start, without work.
  void begin();
  /// Energy stored at the points, weighted: this rank's part [F L].
  double energy(std::span<const double> weight) const;
  /// The state of the last evaluation becomes the last converged one.
  /// @param[in] weight of the points [L^2]
  /// @returns energy that was dissipated in the increment, this rank's part [F L]
  double accept(std::span<const double> weight);

  /// After a restart: the tractions are those of the last converged state.
  void resume();

  /// Names of the fields of `add_to`.
  std::vector<std::string> names() const;
  /// Add what points remember to the state of a contact.
  /// @param[in,out] out rows at facets
  void add_to(state::State& out, std::size_t per_facet);

private:
  /// Work done on the law per area in the increment, by the trapezoidal rule [F/L].
  struct Work
  {
    double normal = 0.0, shear = 0.0;
  };
  Work work(std::size_t q) const;
  double stored(std::size_t q) const;
  void keep(std::size_t q, double stored);

  std::shared_ptr<const InterfaceLaw> _law;
  int _gdim;
  // Of the last converged state. An infinite gap: the law was not asked.
  std::vector<double> _last_gap, _last_pressure, _last_shear, _last_stored, _last_shear_stored;
  InterfaceHistory _history;
  // Of the last evaluation, by point in reach.
  std::vector<std::int32_t> _place; ///< of each point among those that the law was asked at; -1: it was not
  std::vector<std::int8_t> _acts;
  InterfacePoints _points;
  InterfaceTractions _tractions;
  std::vector<double> _shear;     ///< along the surface [F/L^2]
  std::vector<double> _increment; ///< [L]
  std::vector<double> _slip_before,
      _slip_turned;                    ///< slip of the last converged state, and in the present tangent plane
  std::vector<std::int8_t> _knows_gap; ///< does the rate of the gap follow from the last gap?
  double _begun = 0.0;                 ///< one after `begin`; a number, as it is saved
  bool _accepted = true;               ///< is the last evaluation the last converged state?
};
} // namespace dolfinx_impact::enforcement
