// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/StaticContact.h"
#include "../integrators/newmark/Excitation.h"
#include "../integrators/newmark/ImplicitRigidBody.h"
#include "BodyLoads.h"
#include "LoadedBody.h"
#include "TransientProblem.h"
#include <array>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace dolfinx_impact::problems
{
/// A contact of implicit steps, made with prescribed_dofs of the same supports.
struct ImplicitContact
{
  std::shared_ptr<enforcement::StaticContact> contact;
  /// Displacement of a rigid master, beside that which it has at the start; nothing: it stays there [L].
  std::optional<FunctionOfTime> motion = std::nullopt;
  /// Displacement of a rigid master at the start; nothing: where the contact has it [L].
  std::optional<std::array<double, 3>> start = std::nullopt;
  /// Rotation vector of a rigid master about its centre; nothing: it does not turn, or is a body that moves [1].
  std::optional<FunctionOfTime> rotation = std::nullopt;
};

/// A rigid body that moves by forces, in implicit steps.
struct ImplicitBodyInTime
{
  std::shared_ptr<integrators::ImplicitRigidBody> body;
  std::vector<std::size_t> contacts;                   ///< numbers of those whose master it is
  std::optional<FunctionOfTime> force = std::nullopt;  ///< external, at the centre; nothing: none [F]
  std::optional<FunctionOfTime> torque = std::nullopt; ///< external, about the centre [F L]
};

/// Loads, supports and rigid masters of an implicit problem at a time. Prescribed motion is differentiated by central
/// differences over a small part of a step.
class TimeExcitation : public integrators::Excitation
{
public:
  /// @param[in] functions of the problem; those of `forces` and of rigid masters are added. Must stay valid, as must
  /// `supports`
  /// @param[in] loads of the residual, whose amplitudes have the first columns of `functions`
  /// @param[in] body that has the nodal forces
  /// @throws std::invalid_argument on this rank, for what does not fit
  TimeExcitation(MPI_Comm comm, FunctionsOfTime& functions, const Supports& supports, BodyLoads loads,
                 std::shared_ptr<LoadedBody> body, std::vector<LoadInTime> forces,
                 const std::vector<ImplicitContact>& contacts, const std::vector<ImplicitBodyInTime>& bodies = {});

  integrators::TimeValues sample(std::optional<double> step, double time) override;
  void scale(std::span<const double> factors) override;
  void unscale() override;
  std::vector<double> external_forces() override;

private:
  MPI_Comm _comm;
  const FunctionsOfTime& _functions;
  const Supports& _supports;
  BodyLoads _loads;
  std::vector<std::vector<double>> _given; ///< values of their constants while they are scaled
  std::shared_ptr<LoadedBody> _body;
  std::vector<LoadInTime> _forces;
  std::vector<int> _columns; ///< of the amplitudes of all loads; -1: one
  struct Master
  {
    std::array<double, 3> start; ///< where it is
    int motion, rotation;        ///< first columns; -1: none
  };
  std::vector<Master> _masters;
  std::vector<std::array<int, 2>> _bodies; ///< first columns of force and torque on rigid bodies; -1: none
};
} // namespace dolfinx_impact::problems
