// SPDX-License-Identifier: MIT
#pragma once
// What a Newton loop in C++ asks of a static contact: the interface of python/dolfinx_impact/contact/protocol.py as far
// as loops in C++ (demos/cpp/penalty_friction.cpp, demos/cpp/hertz_multipliers.cpp) call it. Displacements are over
// owned and ghost degrees of freedom [L], residuals and forces over owned ones [F]. All calls are collective.
#include "mortar/Constraints.h"
#include <concepts>
#include <petscmat.h>
#include <span>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// Gaps follow the displacements `u`; the step began at `start`. Contact forces on both bodies can be had.
template <typename C>
concept StaticContact =
    requires(C contact, const C& converged, std::span<const double> u, std::span<const double> start) {
      contact.update_gap(u, start);
      { converged.contact_forces() } -> std::same_as<std::vector<double>>;
    };

/// A static contact whose tractions are functions of the displacements (penalty): forces go into the residual `b`,
/// their derivative is added to the stiffness, a converged step becomes history.
template <typename C>
concept RegularisedContact =
    StaticContact<C> && requires(C contact, const C& evaluated, std::span<const double> increment, Vec b) {
      contact.evaluate(increment);
      evaluated.add_residual(b);
      { contact.tangent() } -> std::same_as<Mat>;
      contact.accept_step();
    };

/// A static contact whose normal tractions are unknowns: multipliers from the residual, an active set whose changes are
/// counted over all ranks, and constraints to be condensed (Condensation) or kept (SaddlePoint).
template <typename C>
concept MultiplierContact =
    StaticContact<C> && requires(C contact, const C& settled, std::span<const double> residual, bool first) {
      contact.update_multipliers(residual);
      { contact.update_active_set(first) } -> std::same_as<int>;
      { settled.constraints() } -> std::same_as<Constraints>;
    };
} // namespace dolfinx_impact::enforcement
