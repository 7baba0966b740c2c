# SPDX-License-Identifier: MIT
"""Quadrilaterals and hexahedra of degree 1 with one point and hourglass control; docs/one_point.md derives it.

With reference coordinates X from 0 to 1 and z = X - 1/2, a field of a cell is

    u = u_0 + sum_i z_i u_i + sum_(i<j) z_i z_j u_ij + z_1 z_2 z_3 u_123,

and its coefficients are the derivatives at the centre. The mean of the gradient over the cell is known in closed form
from u_i and u_ij (Flanagan and Belytschko 1981). What it does not see is an hourglass mode,

    h_ij = u_ij - mean(grad u) x_ij,    h_123 = u_123 - mean(grad u) x_123,

which vanishes for every linear field. It bends and twists the cell like plates across each of its axes, and the
assumed strains are theirs (Belytschko and Bindeman 1993; Puso 2000).
"""

import copy
import itertools

import ufl

from .materials import in_space
from .reference_derivatives import reference_derivatives

CELLS = ("quadrilateral", "hexahedron")
HYPOTHESES = ("3d", "plane_strain", "plane_stress")
SQUARE = 1 / 12  # mean of z^2 over the cell
METADATA = {"quadrature_degree": 1}


def _sum(terms):
    first, *others = terms
    for term in others:
        first = first + term
    return first


class OnePointCell:
    """Mean gradients and hourglass modes of fields on the cells of a mesh, at the centre of its cells.

    Args:
        mesh: UFL mesh of quadrilaterals or hexahedra of degree 1.

    Attributes:
        dim: dimension [1].
        modes: pairs (i, j), i < j, of the modes with two factors z.
        volume: volume of the cell, area in the plane; negative where the nodes are numbered the other way round
            [L^dim].
        axes: derivatives of the position by the reference coordinates at the centre [L].
    """

    def __init__(self, mesh):
        x = ufl.SpatialCoordinate(mesh)
        (self.dim,) = x.ufl_shape
        self.modes = list(itertools.combinations(range(self.dim), 2))
        self._x = [reference_derivatives(x, order) for order in range(1, self.dim + 1)]
        self.axes = [ufl.as_vector([self._x[0][k, i] for k in range(self.dim)]) for i in range(self.dim)]
        determinant = ufl.JacobianDeterminant(mesh)
        if self.dim == 2:
            J = self._x[0]
            self._linear = [[J[1, 1], -J[1, 0]], [-J[0, 1], J[0, 0]]]
            self._bilinear = None
            self.volume = J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0]
        else:
            self._cofactors()
            J, p = self._x[0], self._two
            terms = [J[0, i] * self._linear[0][i] + p(0, i) * self._bilinear[0][i] for i in range(3)]
            self.volume = _sum(terms)
        self._size = abs(determinant)
        # DOLFINx keeps cells whose nodes are numbered the other way round: their volume counts all the same.
        self._sign = ufl.conditional(ufl.gt(self.volume, 0), 1.0, -1.0)

    def _two(self, component, axis):
        """Coefficient of the position's component at the mode without an axis."""
        i, j = (k for k in range(3) if k != axis)
        return self._x[1][component, i, j]

    def _cofactors(self):
        """Factors of u_i and u_ij in volume times mean gradient, by direction of the derivative.

        The mean of det(grad f, grad g, grad h) is det(f, g, h) of the vectors f_i, g_i, h_i, minus 1/12 of the same
        with the vectors (f_23, f_31, f_12) in the place of two of the three.
        """
        J, p = self._x[0], self._two

        def cross(a, b, k, m, i):
            j, n = (i + 1) % 3, (i + 2) % 3
            return a(k, j) * b(m, n) - a(k, n) * b(m, j)

        def linear(component, axis):
            return J[component, axis]

        self._linear, self._bilinear = [], []
        for direction in range(3):
            k, m = (direction + 1) % 3, (direction + 2) % 3
            self._linear.append([cross(linear, linear, k, m, i) - SQUARE * cross(p, p, k, m, i) for i in range(3)])
            self._bilinear.append([-SQUARE * (cross(linear, p, k, m, i) + cross(p, linear, k, m, i)) for i in range(3)])

    def _factors(self, u):
        """Pairs of a coefficient of a field's components and its factors, by direction, in volume times mean
        gradient."""
        first = reference_derivatives(u, 1)
        pairs = [([first[k, i] for k in range(self.dim)], [f[i] for f in self._linear]) for i in range(self.dim)]
        if self.dim == 3:
            second = reference_derivatives(u, 2)
            for i in range(3):
                j, n = (a for a in range(3) if a != i)
                pairs.append(([second[k, j, n] for k in range(3)], [f[i] for f in self._bilinear]))
        return pairs

    def mean_gradient(self, u):
        """Mean of the gradient of a field over the cell, dim x dim."""
        pairs, inverse, dims = self._factors(u), 1 / self.volume, range(self.dim)
        return ufl.as_tensor([[_sum([c[k] * f[d] for c, f in pairs]) * inverse for d in dims] for k in dims])

    def work(self, stress, v):
        """Signed volume times stress : mean(grad v). Written by the coefficients of v, so that their factors need no
        division by the volume."""
        pairs, dims = self._factors(v), range(self.dim)
        return _sum([c[k] * _sum([stress[k, d] * f[d] for d in dims]) for c, f in pairs for k in dims])

    def integrand(self, total):
        """Integrand whose integral by the one point is a total of the cell, which was computed with the signed
        volume."""
        return total * self._sign / self._size

    def modes_of(self, u):
        """Coefficients of a field with two factors z, by pair of axes, and in space the one with three under None."""
        second = reference_derivatives(u, 2)
        found = {(i, j): ufl.as_vector([second[k, i, j] for k in range(self.dim)]) for i, j in self.modes}
        if self.dim == 3:
            third = reference_derivatives(u, 3)
            found[None] = ufl.as_vector([third[k, 0, 1, 2] for k in range(3)])
        return found

    def position_modes(self):
        """The same of the position."""
        found = {(i, j): ufl.as_vector([self._x[1][k, i, j] for k in range(self.dim)]) for i, j in self.modes}
        if self.dim == 3:
            found[None] = ufl.as_vector([self._x[2][k, 0, 1, 2] for k in range(3)])
        return found

    def hourglass(self, u):
        """Hourglass modes of a field by pair of axes, and in space that with three factors z under None."""
        mean, modes, x = self.mean_gradient(u), self.modes_of(u), self.position_modes()
        return {m: modes[m] - mean * x[m] for m in modes}

    def virtual_work(self, stress, on_modes, on_mean, v):
        """Integrand of the virtual work of a stress and of forces on the modes, per volume.

        Args:
            stress: conjugate of the mean gradient; components in the plane count [F/L^2].
            on_modes: conjugates of the modes, vectors by mode [F/L].
            on_mean: more of the stress, dim x dim, or None [F/L^2].
            v: test function.
        """
        dim, x = self.dim, self.position_modes()
        plane = ufl.as_tensor([[stress[i, j] for j in range(dim)] for i in range(dim)])
        total = plane - _sum([ufl.outer(f, x[m]) for m, f in on_modes.items()])
        if on_mean is not None:
            total = total + on_mean
        modes = self.modes_of(v)
        work = self.work(total, v)
        work += _sum([modes[m][k] * (f[k] * self.volume) for m, f in on_modes.items() for k in range(dim)])
        return self.integrand(work)


class OnePointBody:
    """Virtual work, tangent and energy of a law on cells with one point.

    The energy of the modes, per volume, is that of plates in plane stress,

        w = 1/2 1/12 sum_k [E' (e_ik^2 + e_jk^2 + 2 nu e_ik e_jk) + G g_k^2] + 1/2 1/144 E sum_i e_i^2,
        e_ik = a_i . h_ik / |x_i|^2,  g_k = (a_i . h_jk + a_j . h_ik) / (|x_i| |x_j|),  e_i = a_i . h_123 / |x_i|^2,

    where k is the plate's normal and i, j are the other axes; E' = E / (1 - nu^2). In the plane there are no twists,
    and E' = E in plane stress. The axes a_i are x_i for small strain and mean(F) x_i for finite strain: a rigid
    rotation turns them with the modes.

    Args:
        mesh: UFL mesh.
        law: law of materials.py.
    """

    def __init__(self, mesh, law):
        if mesh.ufl_coordinate_element().cell_type.name not in CELLS:
            raise ValueError(f"one point with hourglass control is for {' and '.join(CELLS)} cells")
        if law.hypothesis not in HYPOTHESES:
            raise ValueError(f"one point with hourglass control is not for the hypothesis {law.hypothesis}")
        self.cell, self.law = OnePointCell(mesh), copy.copy(law)
        cell = self.cell
        self.law.gradient = lambda u: in_space(cell.mean_gradient(u), law.hypothesis)
        self._x = cell.position_modes()
        self._small = law.linear
        self._inverse = [1 / ufl.dot(a, a) for a in cell.axes]
        E, nu = law.E, law.nu
        self._plate = E if law.hypothesis == "plane_stress" else E / (1 - nu**2)

    def _hourglass(self, u):
        """Mean gradient of a field and its hourglass modes."""
        mean, modes = self.cell.mean_gradient(u), self.cell.modes_of(u)
        return mean, {m: modes[m] - mean * self._x[m] for m in modes}

    def _turned(self, mean):
        """Axes that turn with the body, or what a mean gradient adds to them."""
        return [mean * a for a in self.cell.axes]

    def _axes(self, mean):
        if self._small:
            return self.cell.axes
        return [a + b for a, b in zip(self.cell.axes, self._turned(mean))]

    def _amplitudes(self, axes, modes):
        """a_i . h_m by mode m and axis i."""
        return {(m, i): ufl.dot(axes[i], h) for m, h in modes.items() for i in range(self.cell.dim)}

    def _conjugates(self, amplitude):
        """Derivatives of the energy per volume by the amplitudes a_i . h_m; linear in them."""
        dim, s, law = self.cell.dim, self._inverse, self.law
        found = {}
        for k in range(dim):
            others = [i for i in range(dim) if i != k]
            strain = {i: s[i] * amplitude[pair(i, k), i] for i in others}
            for i in others:
                coupled = sum(law.nu * strain[j] for j in others if j != i)
                found[pair(i, k), i] = SQUARE * self._plate * s[i] * (strain[i] + coupled)
        if dim == 3:
            twist = [amplitude[pair(*(j for j in range(3) if j != i)), i] for i in range(3)]
            for i in range(3):
                shear = sum(s[j] * (twist[i] + twist[j]) for j in range(3) if j != i)
                found[pair(*(j for j in range(3) if j != i)), i] = SQUARE * law.mu * s[i] * shear
                found[None, i] = SQUARE**2 * law.E * s[i] * s[i] * amplitude[None, i]
        return found

    def _forces(self, mean, modes, change=None):
        """Forces on the hourglass modes, and what the turning axes add to the stress; or their derivatives.

        Args:
            mean: mean gradient of the displacement.
            modes: its hourglass modes.
            change: mean gradient and hourglass modes of a direction: derivatives in it.
        """
        dim, axes = self.cell.dim, self._axes(mean)
        amplitude = self._amplitudes(axes, modes)
        force, turning = self._conjugates(amplitude), None
        if change is None:
            on_modes = {m: _sum([force[m, i] * axes[i] for i in range(dim)]) for m in modes}
            if not self._small:
                on_axes = [_sum([force[m, i] * modes[m] for m in modes]) for i in range(dim)]
                turning = _sum([ufl.outer(on_axes[i], self.cell.axes[i]) for i in range(dim)])
            return on_modes, turning
        d_mean, d_modes = change
        d_axes = None if self._small else self._turned(d_mean)
        d_amplitude = self._amplitudes(axes, d_modes)
        if not self._small:
            more = self._amplitudes(d_axes, modes)
            d_amplitude = {key: value + more[key] for key, value in d_amplitude.items()}
        d_force = self._conjugates(d_amplitude)
        on_modes = {m: _sum([d_force[m, i] * axes[i] for i in range(dim)]) for m in modes}
        if not self._small:
            on_modes = {m: f + _sum([force[m, i] * d_axes[i] for i in range(dim)]) for m, f in on_modes.items()}
            on_axes = [_sum([d_force[m, i] * modes[m] + force[m, i] * d_modes[m] for m in modes]) for i in range(dim)]
            turning = _sum([ufl.outer(on_axes[i], self.cell.axes[i]) for i in range(dim)])
        return on_modes, turning

    def force(self, u, v):
        """Integrand of the internal virtual work at the centre."""
        return self.cell.virtual_work(self.law.stress(u), *self._forces(*self._hourglass(u)), v)

    def tangent(self, u, du, v):
        """Integrand of its derivative at u in the direction du."""
        if self._small:
            return self.cell.virtual_work(self.law.stress(du), *self._forces(*self._hourglass(du)), v)
        forces = self._forces(*self._hourglass(u), self._hourglass(du))
        return self.cell.virtual_work(self.law.stress_derivative(u, du), *forces, v)

    def energy_density(self, u):
        """Strain energy of the mean gradient, per volume."""
        return self.law.energy_density(u)

    def hourglass_density(self, u):
        """Energy of the hourglass modes, per volume."""
        mean, modes = self._hourglass(u)
        amplitude = self._amplitudes(self._axes(mean), modes)
        force = self._conjugates(amplitude)
        return _sum([force[key] * amplitude[key] for key in force]) / 2


def pair(i, j):
    """Name of the mode with the factors z_i and z_j."""
    return (min(i, j), max(i, j))


def _measure(dx):
    """A measure with the one point at the centre that the formulas are for."""
    return dx(metadata={**dx.metadata(), **METADATA})


def mean_law(u, law):
    """A law of the mean gradient of the displacement instead of its gradient, at the centre."""
    return OnePointBody(ufl.domain.extract_unique_domain(u), law).law


def internal_force(u, v, law, dx):
    """Internal virtual work of cells with one point and hourglass control."""
    body = OnePointBody(ufl.domain.extract_unique_domain(u), law)
    return body.force(u, v) * _measure(dx)


def tangent(u, du, v, law, dx):
    """Derivative of the internal virtual work at u in the direction du."""
    body = OnePointBody(ufl.domain.extract_unique_domain(v), law)
    return body.tangent(u, du, v) * _measure(dx)


def internal_energy(u, law, dx):
    """Strain energy, that of the hourglass modes included [F L]."""
    return energy_density(u, law) * _measure(dx)


def energy_density(u, law):
    """Integrand of `internal_energy`."""
    body = OnePointBody(ufl.domain.extract_unique_domain(u), law)
    return body.cell.integrand(body.cell.volume * (body.energy_density(u) + body.hourglass_density(u)))


def hourglass_energy(u, law, dx):
    """Energy of the hourglass modes [F L]."""
    body = OnePointBody(ufl.domain.extract_unique_domain(u), law)
    return body.cell.integrand(body.cell.volume * body.hourglass_density(u)) * _measure(dx)
