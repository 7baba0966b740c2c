# SPDX-License-Identifier: MIT
"""Isotropic laws under four hypotheses, in UFL.

A law is a small object: parameters E, nu (numbers, UFL constants or coefficients) and a hypothesis; it gives energy
density, stress and the stress's derivative as UFL expressions of the displacement. Hypotheses: "3d"; "plane_strain" and
"plane_stress" per unit thickness; "axisymmetric", where x[0] is the radius, x[1] the axis, and every integral carries
the weight 2 pi r, so that forces and masses are totals over the circumference.
"""

import ufl

HYPOTHESES = ("3d", "plane_strain", "plane_stress", "axisymmetric")


def lame(E, nu):
    """Lame's constants (lambda, mu) of Young's modulus E [F/L^2] and Poisson's ratio nu [1]."""
    return E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))


def plane_stress_lambda(lmbda, mu):
    """Lame's first constant after sigma_zz = 0 has been solved for eps_zz: 2 lambda mu / (lambda + 2 mu)."""
    return 2 * lmbda * mu / (lmbda + 2 * mu)


def check_hypothesis(hypothesis, gdim):
    """Raise ValueError unless the hypothesis is known and fits the geometric dimension."""
    if hypothesis not in HYPOTHESES:
        raise ValueError(f"hypothesis {hypothesis!r} is unknown: use one of {', '.join(HYPOTHESES)}")
    if (hypothesis == "3d") != (gdim == 3):
        raise ValueError(f"hypothesis {hypothesis!r} does not fit a mesh of geometric dimension {gdim}")


def weight(mesh, hypothesis):
    """Weight of every integral: 2 pi r for axisymmetric bodies, otherwise 1."""
    return 2 * ufl.pi * ufl.SpatialCoordinate(mesh)[0] if hypothesis == "axisymmetric" else 1


def gradient(u, hypothesis):
    """Displacement gradient as a 3 x 3 tensor (2 x 2 for plane stress, where the third direction is condensed)."""
    g, hoop = ufl.grad(u), 0
    if hypothesis == "axisymmetric":
        hoop = u[0] / ufl.SpatialCoordinate(ufl.domain.extract_unique_domain(g))[0]
    return in_space(g, hypothesis, hoop)


def in_space(g, hypothesis, hoop=0):
    """A gradient of the hypothesis's plane as the tensor that `gradient` returns, with the hoop strain at [2, 2]."""
    if hypothesis in ("3d", "plane_stress"):
        return g
    return ufl.as_tensor([[g[0, 0], g[0, 1], 0], [g[1, 0], g[1, 1], 0], [0, 0, hoop]])


def stress_components(gdim):
    """Components of the stress that are stored: xx, yy, zz, xy, and in space yz, xz."""
    plane = ((0, 0), (1, 1), (2, 2), (0, 1))
    return plane if gdim == 2 else (*plane, (1, 2), (0, 2))


def von_mises_square(xx, yy, zz, *shear):
    """Square of von Mises' equivalent stress of the components of a stress: numbers, arrays or UFL [F^2/L^4]."""
    return ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * sum(s**2 for s in shear)


def von_mises(stress):
    """Von Mises' equivalent stress of a symmetric 3 x 3 tensor in UFL [F/L^2]."""
    normal, shear = ((0, 0), (1, 1), (2, 2)), ((0, 1), (1, 2), (0, 2))
    return ufl.sqrt(von_mises_square(*(stress[i] for i in normal), *(stress[i] for i in shear)))


class Law:
    """Base of the laws. Args: E [F/L^2], nu [1], hypothesis; integration, "full" or "reduced" (one_point.py)."""

    name = ""
    linear = False

    def __init__(self, E, nu, hypothesis="3d", integration="full"):
        self.E, self.nu, self.hypothesis, self.integration = E, nu, hypothesis, integration
        self.lmbda, self.mu = lame(E, nu)
        if hypothesis == "plane_stress":
            self.lmbda_plane = plane_stress_lambda(self.lmbda, self.mu)

    @property
    def _lambda(self):
        return self.lmbda_plane if self.hypothesis == "plane_stress" else self.lmbda

    def gradient(self, u):
        return gradient(u, self.hypothesis)

    def energy_density(self, u):
        """Strain energy per reference volume [F L/L^3]."""
        raise NotImplementedError

    def stress(self, u):
        """Stress conjugate to the displacement gradient: Cauchy for small strain, first Piola-Kirchhoff otherwise."""
        raise NotImplementedError

    def stress_derivative(self, u, du):
        """Derivative of `stress` at u in the direction du."""
        raise NotImplementedError

    def thickness_stretch(self, u):
        """Stretch across a sheet in plane stress of finite strain [1]."""
        raise NotImplementedError

    def cauchy_stress(self, u):
        """Cauchy stress as a 3 x 3 tensor under every hypothesis; its third row is zero in plane stress [F/L^2]."""
        stress = self.stress(u)
        if not self.linear:
            H = self.gradient(u)
            F = ufl.Identity(H.ufl_shape[0]) + H
            volume = ufl.det(F) * (self.thickness_stretch(u) if self.hypothesis == "plane_stress" else 1)
            stress = stress * F.T / volume
        if stress.ufl_shape == (2, 2):
            stress = ufl.as_tensor([[stress[0, 0], stress[0, 1], 0], [stress[1, 0], stress[1, 1], 0], [0, 0, 0]])
        return stress


class LinearElastic(Law):
    """Small strain: sigma = lambda tr(eps) I + 2 mu eps, seed (3.18), (3.19)."""

    name = "linear_elastic"
    linear = True

    def strain(self, u):
        return ufl.sym(self.gradient(u))

    def energy_density(self, u):
        return ufl.inner(self.stress(u), self.strain(u)) / 2

    def stress(self, u):
        eps = self.strain(u)
        return self._lambda * ufl.tr(eps) * ufl.Identity(eps.ufl_shape[0]) + 2 * self.mu * eps

    def stress_derivative(self, u, du):
        return self.stress(du)


class StVenantKirchhoff(Law):
    """S = lambda tr(E) I + 2 mu E with Green's strain E; P = F S. Plane stress: E_zz condensed from S_zz = 0."""

    name = "st_venant_kirchhoff"

    def energy_density(self, u):
        H = self.gradient(u)
        E = ufl.sym(H) + H.T * H / 2
        return self._lambda / 2 * ufl.tr(E) ** 2 + self.mu * ufl.inner(E, E)

    def _second(self, H):
        E = ufl.sym(H) + H.T * H / 2
        return self._lambda * ufl.tr(E) * ufl.Identity(E.ufl_shape[0]) + 2 * self.mu * E

    def thickness_stretch(self, u):
        H = self.gradient(u)
        in_plane = ufl.tr(ufl.sym(H) + H.T * H / 2)
        return ufl.sqrt(1 - 2 * self.lmbda / (self.lmbda + 2 * self.mu) * in_plane)

    def stress(self, u):
        H = self.gradient(u)
        return (ufl.Identity(H.ufl_shape[0]) + H) * self._second(H)

    def stress_derivative(self, u, du):
        H, dH = self.gradient(u), self.gradient(du)
        F = ufl.Identity(H.ufl_shape[0]) + H
        dE = ufl.sym(F.T * dH)
        dS = self._lambda * ufl.tr(dE) * ufl.Identity(dE.ufl_shape[0]) + 2 * self.mu * dE
        return dH * self._second(H) + F * dS


class NeoHookean(Law):
    """psi = mu/2 (tr C - 3) - mu ln J + lambda/2 (ln J)^2; P = mu (F - F^-T) + lambda ln J F^-T (Bonet & Wood 2008,
    6.27).

    Plane stress: P_zz = 0 gives mu (C_zz - 1) + lambda/2 ln C_zz + lambda ln J_2 = 0, solved for ln C_zz by Newton
    steps written out in the form. The function is convex and the start is its small-strain root, so the steps converge
    from one side; six reach round-off for area changes between 1/3 and 3.
    """

    name = "neo_hookean"
    NEWTON_STEPS = 6

    def _log_Czz(self, log_J2):
        y = -self.lmbda * log_J2 / (self.mu + self.lmbda / 2)
        for _ in range(self.NEWTON_STEPS):
            g = self.mu * (ufl.exp(y) - 1) + self.lmbda / 2 * y + self.lmbda * log_J2
            y = y - g / (self.mu * ufl.exp(y) + self.lmbda / 2)
        return y

    def _state(self, u):
        H = self.gradient(u)
        F = ufl.Identity(H.ufl_shape[0]) + H
        log_J2 = ufl.ln(ufl.det(F))
        y = self._log_Czz(log_J2) if self.hypothesis == "plane_stress" else None
        return F, log_J2 if y is None else log_J2 + y / 2, y

    def energy_density(self, u):
        F, log_J, y = self._state(u)
        trace = ufl.inner(F, F) - 3 if y is None else ufl.inner(F, F) + ufl.exp(y) - 3
        return self.mu / 2 * trace - self.mu * log_J + self.lmbda / 2 * log_J**2

    def thickness_stretch(self, u):
        return ufl.exp(self._state(u)[2] / 2)

    def stress(self, u):
        F, log_J, _ = self._state(u)
        return self.mu * F + (self.lmbda * log_J - self.mu) * ufl.inv(F).T

    def stress_derivative(self, u, du):
        F, log_J, y = self._state(u)
        dF = self.gradient(du)
        inverse = ufl.inv(F)
        share = 1 if y is None else 1 - self.lmbda / 2 / (self.mu * ufl.exp(y) + self.lmbda / 2)
        turned = inverse.T * dF.T * inverse.T
        volume = self.lmbda * share * ufl.inner(inverse.T, dF)
        return self.mu * dF + (self.mu - self.lmbda * log_J) * turned + volume * inverse.T


LAWS = {law.name: law for law in (LinearElastic, StVenantKirchhoff, NeoHookean)}
