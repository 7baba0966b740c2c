// SPDX-License-Identifier: MIT
#pragma once
#include "PlasticBody.h"

namespace impact_reference
{
/// Forces of bodies as functions of their displacements, which loads and contact forces balance.
class BodyForces
{
public:
  virtual ~BodyForces() = default;

  virtual Vector force(const Vector& u) const = 0; ///< [F]
  virtual Csr tangent(const Vector& u) const = 0;  ///< derivative of the force, on the pattern of the model [F/L]
  /// Stiffness in Rayleigh's damping [F/L].
  virtual Csr damping_stiffness(const Vector& u) const { return tangent(u); }
  /// Dashpots to the ground, on the pattern of the model; null: there are none [F T/L].
  virtual const Csr* dashpots() const { return nullptr; }
  /// Size of the terms that `force` is the sum of: what its round-off is relative to [F].
  virtual double size(const Vector& /*u*/, const Vector& force) const { return force.norm(); }
  /// Size of forces of strains of 1: strains made of F = 1 + grad u have their round-off. Zero where they are not [F].
  virtual double unit_size() const { return 0; }
};

/// Internal forces of elastic bodies.
class ElasticForces : public BodyForces
{
public:
  /// @param model must outlive this object
  ElasticForces(const Model& model, Rule rule);

  /// Of linear bodies K u, which is exact for small displacements, too.
  Vector force(const Vector& u) const override;
  Csr tangent(const Vector& u) const override;
  Csr damping_stiffness(const Vector& u) const override; ///< without springs to the ground
  const Csr* dashpots() const override { return &model_.dashpots(); }
  double unit_size() const override;

private:
  const Model& model_;
  Rule rule_;
  Csr elastic_, stiffness_; ///< at rest, without springs to the ground and with them
};

/// Internal forces of a plastic body: trials from its committed history. It is damped with its elastic stiffness, in
/// small strain only.
class PlasticForces : public BodyForces
{
public:
  /// @param body must outlive this object
  PlasticForces(const PlasticBody& body, Rule rule) : body_(body), rule_(std::move(rule)) {}

  Vector force(const Vector& u) const override;
  Csr tangent(const Vector& u) const override;
  const Csr* dashpots() const override { return &body_.model().dashpots(); }
  /// @throws std::invalid_argument in finite strain
  Csr damping_stiffness(const Vector& u) const override;
  double unit_size() const override;

private:
  const PlasticBody& body_;
  Rule rule_;
};
} // namespace impact_reference
