# SPDX-License-Identifier: MIT
"""Quadrilaterals and hexahedra with one point and hourglass control, in matrices of one element.

Uniform gradients and hourglass shape vectors gamma after Flanagan & Belytschko (1981); a stiffness of assumed strains
for the hourglass modes (Belytschko & Bindeman 1993). The mean of the gradients of the shape functions,

    b_I = 1/V int grad N_I dV,    gamma_m = 1/2^d (h_m - sum_I (h_m . x)_k b_k),

comes from a Gauss rule that integrates it exactly. h_m are the values of xi_i xi_j and xi_1 xi_2 xi_3 at the nodes.
"""

from dataclasses import dataclass

import numpy as np

from . import elements, rules
from ._reference import Material
from .array_types import ArrayLike, FloatArray, floats, integers
from .free_motion import BodyForces, FreeMotion, lumped_mass, move_freely

CELLS = ("quadrilateral", "hexahedron")
LAWS = ("linear_elastic", "st_venant_kirchhoff", "neo_hookean")


@dataclass
class OnePointForces:
    """What a cell with one point has at a displacement.

    Attributes:
        energy: strain energy, that of the hourglass modes included [F L].
        hourglass: energy of the hourglass modes [F L].
        force: internal force, shape (gdim n) [F].
        tangent: its derivative, shape (gdim n, gdim n) [F/L].
    """

    energy: float
    hourglass: float
    force: FloatArray
    tangent: FloatArray


def uniform_gradient(cell_type: str, X: ArrayLike) -> tuple[float, FloatArray]:
    """Volume of a cell and means of the gradients of its shape functions.

    Args:
        cell_type: "quadrilateral" or "hexahedron".
        X: nodes, shape (n, gdim) [L].

    Returns:
        Volume [L^gdim] and b, shape (n, gdim) [1/L].
    """
    nodes = floats(X)
    points, weights = rules.quadrature(cell_type, "gauss_jacobi:4")
    _, dN = rules.shape_functions(cell_type, 1, points)
    jacobians = np.einsum("ni,qnk->qik", nodes, dN)
    sizes = weights * np.linalg.det(jacobians)
    gradients = np.einsum("qnk,qki->qni", dN, np.linalg.inv(jacobians))
    volume = float(sizes.sum())
    return volume, np.einsum("q,qni->ni", sizes, gradients) / volume


def hourglass_vectors(cell_type: str, X: ArrayLike, b: FloatArray) -> FloatArray:
    """Hourglass shape vectors gamma, which vanish for every linear field.

    Args:
        cell_type: "quadrilateral" or "hexahedron".
        X: nodes, shape (n, gdim) [L].
        b: mean gradients of `uniform_gradient` [1/L].

    Returns:
        Shape (num_modes, n): xi eta; in space xi eta, eta zeta, zeta xi, xi eta zeta [1].
    """
    nodes, xi = floats(X), rules.reference_nodes(cell_type, 1)
    if cell_type == "quadrilateral":
        h = np.array([xi[:, 0] * xi[:, 1]])
    else:
        h = np.array([xi[:, 0] * xi[:, 1], xi[:, 1] * xi[:, 2], xi[:, 2] * xi[:, 0], np.prod(xi, axis=1)])
    return (h - (h @ nodes) @ b.T) / len(nodes)


def _plate_matrix(material: Material) -> FloatArray:
    """Stress over strain (xx, yy, xy) of a plate, plane stress [F/L^2]."""
    E, nu = material.E, material.nu
    return E / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])


def _weights(material: Material, axes: FloatArray) -> FloatArray:
    """Energy of the hourglass amplitudes a_i . q_m per volume: half of it times amplitudes from both sides.

    Args:
        material: material.
        axes: derivatives of the position by xi at the centre, rows [L].

    Returns:
        Shape (num_modes gdim, num_modes gdim), the axis fastest.
    """
    d, size = len(axes), np.linalg.norm(axes, axis=1)
    if d == 2:
        E = material.E if material.hypothesis == "plane_stress" else material.E / (1 - material.nu**2)
        return np.diag(E / 3 / size**4)
    mode = {frozenset((0, 1)): 0, frozenset((1, 2)): 1, frozenset((2, 0)): 2}
    W, D = np.zeros((12, 12)), _plate_matrix(material)
    for normal in range(3):
        i, j = (normal + 1) % 3, (normal + 2) % 3
        strains = np.zeros((3, 12))
        mi, mj = mode[frozenset((i, normal))], mode[frozenset((j, normal))]
        strains[0, 3 * mi + i] = 1 / size[i] ** 2
        strains[1, 3 * mj + j] = 1 / size[j] ** 2
        strains[2, 3 * mj + i] = strains[2, 3 * mi + j] = 1 / (size[i] * size[j])
        W += strains.T @ D @ strains / 3
    for i in range(3):
        W[9 + i, 9 + i] += material.E / 9 / size[i] ** 4
    return W


def _strain_matrix(b: FloatArray, F: FloatArray) -> FloatArray:
    """Derivative of the strain of F by the displacements of the nodes, in the order of `second_piola`."""
    n, d = b.shape
    shears = ((0, 1),) if d == 2 else ((0, 1), (1, 2), (0, 2))
    B = np.zeros((d + len(shears), n, d))
    for k in range(d):
        B[k] = b[:, [k]] * F[:, k]
    for row, (k, m) in enumerate(shears):
        B[d + row] = b[:, [k]] * F[:, m] + b[:, [m]] * F[:, k]
    return B.reshape(len(B), -1)


def element_one_point(cell_type: str, X: ArrayLike, material: Material, u: ArrayLike) -> OnePointForces:
    """Energy, force and tangent of a cell with one point and hourglass control.

    Args:
        cell_type: "quadrilateral" or "hexahedron".
        X: nodes in the order of `reference_nodes`, shape (n, gdim) [L].
        material: material data and hypothesis: "3d", "plane_strain" or "plane_stress".
        u: displacements of the nodes, shape (gdim n) or (n, gdim) [L].

    Returns:
        OnePointForces.

    Raises:
        ValueError: another cell, law or hypothesis.
    """
    if cell_type not in CELLS or material.law not in LAWS or material.hypothesis == "axisymmetric":
        raise ValueError(
            f"one point is for {' and '.join(CELLS)}, laws {', '.join(LAWS)}, and not axisymmetric; found {cell_type}, "
            f"{material.law}, {material.hypothesis}"
        )
    nodes = floats(X)
    n, d = nodes.shape
    moved, linear = floats(u).reshape(n, d), material.law == "linear_elastic"
    volume, b = uniform_gradient(cell_type, nodes)
    gamma = hourglass_vectors(cell_type, nodes, b)
    H = moved.T @ b
    F = np.eye(3)
    F[:d, :d] += H
    S, C, density = elements.second_piola(material, F)
    B = _strain_matrix(b, np.eye(d) if linear else F[:d, :d])
    force, tangent = volume * B.T @ S, volume * B.T @ C @ B
    if not linear:
        T = np.diag(S[:d])
        for row, (k, m) in enumerate(((0, 1),) if d == 2 else ((0, 1), (1, 2), (0, 2))):
            T[k, m] = T[m, k] = S[d + row]
        tangent += volume * np.kron(b @ T @ b.T, np.eye(d))
    # Hourglass modes.
    _, dN = rules.shape_functions(cell_type, 1, np.zeros((1, d)))
    axes = dN[0].T @ nodes
    W, q = _weights(material, axes), gamma @ moved
    turned = axes if linear else axes @ F[:d, :d].T
    along = axes @ b.T  # derivative of each node's displacement along an axis
    amplitude = (q @ turned.T).ravel()
    J = np.einsum("mn,ik->mink", gamma, turned)
    if not linear:
        J += np.einsum("mk,in->mink", q, along)
    J = J.reshape(len(amplitude), -1)
    conjugate = W @ amplitude
    force += volume * J.T @ conjugate
    tangent += volume * J.T @ W @ J
    if not linear:
        mixed = np.einsum("mi,in,mp->np", conjugate.reshape(len(gamma), d), along, gamma)
        tangent += volume * np.kron(mixed + mixed.T, np.eye(d))
    hourglass = 0.5 * volume * float(amplitude @ conjugate)
    return OnePointForces(volume * density + hourglass, hourglass, force, tangent)


def run_one_point(
    points: FloatArray,
    cells: ArrayLike,
    cell_type: str,
    material: Material,
    velocity: FloatArray,
    dt: float,
    num_steps: int,
) -> FreeMotion:
    """Free motion of a body by central differences with lumped mass.

    Args:
        points: nodes, shape (num_nodes, gdim) [L].
        cells: nodes of the cells in the order of `reference_nodes`, shape (num_cells, n).
        cell_type: "quadrilateral" or "hexahedron".
        material: material data, density and hypothesis.
        velocity: initial velocity, shape (num_nodes, gdim) [L/T].
        dt: step [T].
        num_steps: number of steps [1].

    Returns:
        FreeMotion.
    """
    connectivity = integers(cells, "cells", 2)

    def forces(u: FloatArray) -> BodyForces:
        out = BodyForces(np.zeros_like(points), 0.0, 0.0)
        for cell in connectivity:
            found = element_one_point(cell_type, points[cell], material, u[cell])
            out.force[cell] += found.force.reshape(len(cell), -1)
            out.internal += found.energy
            out.hourglass += found.hourglass
        return out

    return move_freely(lumped_mass(points, cells, cell_type, material), velocity, forces, dt, num_steps)
