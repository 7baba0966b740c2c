// SPDX-License-Identifier: MIT
#pragma once
#include <petscmat.h>
#include <vector>

namespace dolfinx_impact::rolling
{
/// Matrices of small vibrations of bodies in the ALE frame: (s^2 M + s G + K - W) x = 0; seed (3.54), corrected.
struct VibrationMatrices
{
  Mat K = nullptr;     ///< tangent stiffness minus W, with ones on the diagonal of supports [F/L]
  Mat G = nullptr;     ///< gyroscopic matrix, zero at supports [M/T]
  Mat M = nullptr;     ///< mass matrix, zero at supports [M]
  Mat along = nullptr; ///< of the derivative along the flow without the turn of vectors, zero at supports [M/T]
};

struct Frequencies
{
  std::vector<double> values; ///< signed, sorted by modulus [1/T]
  int growing = 0;            ///< number of modes found that grow
};

/// Frequencies of smallest modulus. Collective.
///
/// A mode x exp(i omega t) with omega > 0 is a wave: forward if its phase travels with the flow of the material,
/// backward, and then given with a minus sign, if it travels against it. With x ~ exp(-i n theta) the form `along` is
/// -i n times the mass, so that the sign is that of minus its imaginary part.
/// @param[in] count number of frequencies
/// @param[in] least below it a mode's derivative along the flow, over its amplitude, is none: half the angular velocity
/// of a body, as waves have a whole number of lengths around it; zero without a spin [1/T]
/// @param[in] tolerance relative tolerance of an eigenvalue
/// @throws common::Failure if the solver found fewer than asked for
Frequencies frequencies(const VibrationMatrices& matrices, int count, double least, double tolerance);
} // namespace dolfinx_impact::rolling
