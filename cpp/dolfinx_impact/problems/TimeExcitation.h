// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/StaticContact.h"
#include "../integrators/newmark/Excitation.h"
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
                 const std::vector<ImplicitContact>& contacts);

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
  std::vector<int> _columns;                                   ///< of the amplitudes of all loads; -1: one
  std::vector<std::pair<std::array<double, 3>, int>> _masters; ///< where rigid masters are, and their motions' columns
};
} // namespace dolfinx_impact::problems
