// SPDX-License-Identifier: MIT
#pragma once
#include "BodyResponse.h"
#include "TorqueControl.h"
#include <optional>

namespace dolfinx_impact::rolling
{
/// Contact and friction of a rolling problem, reduced to the nodes that touch or may touch soon. Keeps the factors of
/// the bodies and the compliance of the candidates from solve to solve; the compliance may be that of an earlier
/// geometry: who uses it corrects what it leaves.
class ReducedContacts
{
public:
  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] fixed mask of prescribed degrees of freedom, owned
  ReducedContacts(const surface::FunctionSpace& V, std::vector<std::int8_t> fixed);

  /// Responses of the bodies.
  BodyResponse& response() { return _response; }
  /// Make factors and compliance again, when they are used next. Collective.
  void renew() { _response.forget_factors(); }

  /// The contacts at given multipliers, of which all else is a linear function; by contact, vectors [i*gdim + c].
  struct States
  {
    Candidates::ByContact forces; ///< multipliers as nodal forces [F]
    Candidates::ByContact gaps;   ///< [L]
    Candidates::ByContact slips;  ///< velocities of slave against master [L/T]
  };
  struct Solution
  {
    Candidates::ByContact forces; ///< multipliers as nodal forces [F]
    double change = 0.0;          ///< of the spin [1/T]
    std::string fault;            ///< what went wrong; empty if nothing did
  };
  /// Multipliers that obey contact and friction. Collective.
  /// @param[in] operators of the contacts, whose bodies `response` has been told
  /// @param[in] near masks of nodes that touch or may touch
  /// @param[in] torque to be reached by a change of spin; null: the spin is given
  Solution forces(const ContactOperators& operators, const std::vector<std::vector<std::int8_t>>& near,
                  const States& at, const ReducedTorque* torque);

private:
  void update(const ContactOperators& operators, const std::vector<std::vector<std::int8_t>>& near);

  MPI_Comm _comm;
  BodyResponse _response;
  std::vector<std::vector<std::int8_t>> _chosen;
  std::optional<Candidates> _candidates;
  Compliance _compliance;
  double _speed = 0.0; ///< with which the compliance of velocities was made, sum over the contacts [L/T]
  int _factors = 0;    ///< number of those that the compliance was made with
};
} // namespace dolfinx_impact::rolling
