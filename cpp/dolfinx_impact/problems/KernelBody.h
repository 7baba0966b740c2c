// SPDX-License-Identifier: MIT
#pragma once
#include "../operators/InternalForce.h"
#include "../operators/Tangent.h"
#include "../solve/Body.h"
#include <dolfinx/la/Vector.h>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace dolfinx_impact::problems
{
/// A material as the table of kernels has it: NAME.force and NAME.tangent (kernels::find).
struct KernelMaterial
{
  std::string name;                                     ///< "linear_elastic", "neo_hooke", or a law of one's own
  std::map<std::string, std::vector<double>> constants; ///< by name, for example E and nu
  std::string hypothesis = "";                          ///< "3d", "plane_strain", ...; empty: the only one
};

/// Bodies of one material without internal variables: internal forces and tangent by kernels, nodal external forces.
class KernelBody : public solve::Body
{
public:
  /// @param[in] u displacement; the kernels' coefficient of this name
  /// @throws std::runtime_error if there are no kernels for this mesh and degree
  /// @throws std::invalid_argument if a constant is missing
  KernelBody(std::shared_ptr<dolfinx::fem::Function<double>> u, const KernelMaterial& material);
  ~KernelBody() override;
  KernelBody(const KernelBody&) = delete;
  KernelBody& operator=(const KernelBody&) = delete;

  Vec residual() override;
  Mat tangent() override;
  bool linear() const override { return _linear; }
  bool rounds_positions() const override { return true; }

  /// External forces at owned and ghost degrees of freedom, zero at first; ghosts are not read [F].
  std::vector<double>& loads() { return _loads; }

private:
  std::shared_ptr<dolfinx::fem::Function<double>> _u;
  std::unique_ptr<operators::InternalForce> _force;
  std::unique_ptr<operators::Tangent> _tangent;
  bool _linear = true;
  std::vector<double> _loads;
  dolfinx::la::Vector<double> _values;
  Vec _residual = nullptr; ///< has the entries of `_values`
};
} // namespace dolfinx_impact::problems
