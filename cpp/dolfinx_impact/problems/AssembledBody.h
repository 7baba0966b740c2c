// SPDX-License-Identifier: MIT
#pragma once
#include "../operators/KernelTangent.h"
#include "../operators/saved_history.h"
#include "../solve/Body.h"
#include "KernelForce.h"
#include <dolfinx/la/Vector.h>
#include <memory>
#include <optional>
#include <vector>

namespace dolfinx_impact::problems
{
typedef std::shared_ptr<const dolfinx::fem::Form<double>> Form;

/// What is assembled by kernels.
struct BodyKernels
{
  std::vector<KernelForce> forces = {};   ///< residual; those of laws with internal variables keep them
  std::vector<KernelForce> energies = {}; ///< of laws without internal variables, and springs
  bool energy_is_known = false;           ///< nothing else stores energy but laws with internal variables
  std::vector<KernelForce> loads = {};    ///< external forces, which are subtracted from the residual
  std::vector<Constants> tangent_constants = {};
  /// Functions that kernels read: their ghosts are updated before every call.
  std::vector<std::shared_ptr<dolfinx::fem::Function<double>>> functions = {};
};

/// Bodies that are assembled by kernels of this project, by forms of DOLFINx, or both: sums of them.
class AssembledBody : public solve::Body
{
public:
  /// @param[in] u displacement
  /// @param[in] residual form of rank 1 of the residual, or of what is added to that of the kernels; null: nothing
  /// @param[in] tangent its derivative, with that of the kernels
  AssembledBody(std::shared_ptr<dolfinx::fem::Function<double>> u, Form residual,
                std::shared_ptr<operators::KernelTangent> tangent, solve::BodyProperties properties,
                BodyKernels kernels = {});
  ~AssembledBody() override;
  AssembledBody(const AssembledBody&) = delete;
  AssembledBody& operator=(const AssembledBody&) = delete;

  Vec residual() override;
  Mat tangent() override;
  std::string fault() override;
  void accept_step() override;
  state::State state() override;
  state::State saved_state() override;
  void resume(const state::State& saved) override;
  /// Energy of laws without internal variables at the present displacement, and elastic energy of the others.
  std::optional<double> stored_energy() override;

  /// Say what stores energy beside laws with internal variables: with these, all energy is known.
  /// @param[in] functions that they read, whose ghosts are updated before every call
  void set_energies(std::vector<KernelForce> energies,
                    const std::vector<std::shared_ptr<dolfinx::fem::Function<double>>>& functions = {});
  /// External forces at owned and ghost degrees of freedom, zero at first; ghosts are not read [F].
  std::vector<double>& loads() { return _loads; }
  /// Operators of the residual by kernels, which keep the internal variables.
  const std::vector<KernelForce>& forces() const { return _kernels.forces; }
  /// The matrix of `tangent`, as it was assembled last, borrowed [F/L].
  Mat matrix() const { return _tangent->matrix(); }

private:
  void update_ghosts();
  operators::Histories histories() const;

  std::shared_ptr<dolfinx::fem::Function<double>> _u;
  Form _form;
  std::shared_ptr<operators::KernelTangent> _tangent;
  BodyKernels _kernels;
  dolfinx::la::Vector<double> _values;
  std::vector<double> _loads;
  Vec _residual = nullptr; ///< has the entries of `_values`
};
} // namespace dolfinx_impact::problems
