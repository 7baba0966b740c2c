// SPDX-License-Identifier: MIT
#pragma once
#include <functional>
#include <petscmat.h>
#include <petscvec.h>
#include <vector>

namespace dolfinx_impact::integrators
{
/// Nodal forces that depend on displacement and velocity, positive where they resist: damping beside that of the mass.
class VelocityForce
{
public:
  virtual ~VelocityForce() = default;

  /// At the present displacement and velocity, owned [F]. Collective.
  virtual std::vector<double> forces() = 0;
  /// Derivative with respect to the displacement at the end of a step, as matrices whose sum it is, borrowed until the
  /// next call [F/L]. Collective.
  /// @param[in] factors derivative of the velocity by the displacement, by degree of freedom [1/T]
  virtual std::vector<Mat> tangent(Vec factors) = 0;
  /// Whether the derivative is the same in all steps of one size.
  virtual bool linear() const = 0;
};

/// Forces that are functions of one's own, for example assembled by DOLFINx from forms.
class FunctionVelocityForce : public VelocityForce
{
public:
  FunctionVelocityForce(std::function<std::vector<double>()> forces, std::function<std::vector<Mat>(Vec)> tangent,
                        bool linear)
      : _forces(std::move(forces)), _tangent(std::move(tangent)), _linear(linear)
  {
  }
  std::vector<double> forces() override { return _forces(); }
  std::vector<Mat> tangent(Vec factors) override { return _tangent(factors); }
  bool linear() const override { return _linear; }

private:
  std::function<std::vector<double>()> _forces;
  std::function<std::vector<Mat>(Vec)> _tangent;
  bool _linear;
};
} // namespace dolfinx_impact::integrators
