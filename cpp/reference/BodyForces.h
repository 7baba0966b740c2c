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
  /// Size of the terms that `force` is the sum of: what its round-off is relative to [F].
  virtual double size(const Vector& /*u*/, const Vector& force) const { return force.norm(); }
};

/// Internal forces of elastic bodies.
class ElasticForces : public BodyForces
{
public:
  /// @param model must outlive this object
  ElasticForces(const Model& model, Rule rule) : model_(model), rule_(std::move(rule)) {}

  Vector force(const Vector& u) const override { return model_.internal_force(rule_, u); }
  Csr tangent(const Vector& u) const override;

private:
  const Model& model_;
  Rule rule_;
};

/// Internal forces of a plastic body: trials from its committed history.
class PlasticForces : public BodyForces
{
public:
  /// @param body must outlive this object
  explicit PlasticForces(const PlasticBody& body) : body_(body) {}

  Vector force(const Vector& u) const override { return body_.evaluate(u, false).force; }
  Csr tangent(const Vector& u) const override { return body_.evaluate(u, true).tangent; }

private:
  const PlasticBody& body_;
};
} // namespace impact_reference
