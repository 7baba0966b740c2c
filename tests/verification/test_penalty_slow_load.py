# SPDX-License-Identifier: MIT
"""Explicit penalty contact without a given penalty: what its springs do to forces, under slow loads and in impacts.

`python test_penalty_slow_load.py` prints the table of docs/explicit/penalty.md, "Slow loads".
"""

import warnings

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di

WARNED = "of the deformation is penetration"


def rectangle(size, cells):
    """Mesh, space, and tags: 1 on the lower edge, 2 on the upper one."""
    domain = mesh.create_rectangle(MPI.COMM_SELF, [[0, 0], list(size)], cells, mesh.CellType.quadrilateral)
    edges = [mesh.locate_entities_boundary(domain, 1, lambda x, y=y: np.isclose(x[1], y)) for y in (0.0, size[1])]
    facets = np.concatenate(edges)
    order = np.argsort(facets)
    values = np.repeat([1, 2], [len(e) for e in edges]).astype(np.int32)
    return (
        domain,
        fem.functionspace(domain, ("Lagrange", 1, (2,))),
        mesh.meshtags(domain, 1, facets[order], values[order]),
    )


def pressed(method, n, law=di.LinearElastic):
    """A block of n cells between two rigid plates, pushed together by a hundredth of its height within some periods.

    Returns:
        Force over the exact one of uniaxial stress, and the largest share of both contacts.
    """
    _, V, tags = rectangle((0.5, 0.6), (max(2, n // 2), n))
    top = di.RigidPlane((0, 0.6), (0, -1))
    top.motion = lambda t: (0.0, -0.006 * np.sin(0.5 * np.pi * min(1.0, t / 0.2)) ** 2, 0.0)
    pairs = [di.ContactPair(tags, 2, top), di.ContactPair(tags, 1, di.RigidPlane((0, 0), (0, 1)))]
    material = law(1e6, 0.0, 1000.0, "plane_strain")
    u, v = fem.Function(V), fem.Function(V)
    problem = di.ExplicitProblem(
        u, material, velocity=v, contact=[method(p) for p in pairs], damping=di.Rayleigh(30.0, 0.0)
    )
    problem.advance(0.4, progress=False, energy_limits=None)
    force = -problem.force_history[0][-1, 1] / (1e6 * 0.01 * 0.5)
    return force, sum(c.penetration_share for c in problem.contact)


@pytest.mark.parametrize("n", [6, 12])
def test_share_tells_what_is_missing(n):
    """Two springs of half a layer in a row with n layers: n/(n + 4) at least what the mass allows. What is missing in
    the force is the share, and it is warned of."""
    with pytest.warns(UserWarning, match=WARNED):
        force, share = pressed(di.Penalty, n)
    assert force == pytest.approx(n / (n + 4), abs=0.03)
    assert force + share == pytest.approx(1.0, abs=0.01)  # waves that still run


def test_share_counts_finite_strain():
    """A neo-Hookean block, whose internal energy is summed up as work."""
    with pytest.warns(UserWarning, match=WARNED):
        force, share = pressed(di.Penalty, 6, di.NeoHookean)
    assert force + share == pytest.approx(1.0, abs=0.02)  # 1 % of strain


def test_kinematic_contact_has_no_share():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        force, share = pressed(di.Kinematic, 6)
    assert force == pytest.approx(1.0, abs=0.01) and share == 0.0


def plateau(fraction=0.9, stiff=None):
    """Force on the plateau of a bar of 60 cells that strikes a wall, over rho c V A: mean and standard deviation.

    Args:
        fraction: of the stable step.
        stiff: factor of the stiffness of the last third, which the wave does not come back from in that time.
    """
    domain, V, tags = rectangle((1.0, 60.0), (1, 60))
    material = di.LinearElastic(1.0, 0.0, 1.0, "plane_strain")
    if stiff:
        cells = np.arange(60, dtype=np.int32)
        far = (mesh.compute_midpoints(domain, 2, cells)[:, 1] > 40.0).astype(np.int32)
        hard = di.LinearElastic(stiff, 0.0, 1.0, "plane_strain")
        material = di.MaterialMap(mesh.meshtags(domain, 2, cells, far), {0: material, 1: hard})
    u, v = fem.Function(V), fem.Function(V)
    u.x.array[1::2], v.x.array[1::2] = 0.1, -0.1
    walls = fem.Function(V.sub(0).collapse()[0])
    sides = fem.locate_dofs_geometrical((V.sub(0), walls.function_space), lambda x: x[0] > -1)
    pair = di.ContactPair(tags, 1, di.RigidPlane((0, 0), (0, 1)))
    problem = di.ExplicitProblem(
        u, material, velocity=v, bcs=[fem.dirichletbc(walls, sides, V.sub(0))], contact=[di.Penalty(pair)]
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # no share is warned of in an impact
        problem.advance(70.0, dt=fraction * problem.stable_step(), progress=False)
    t, force = problem.energy_history[:, 0], problem.force_history[0][:, 1] / 0.1
    held = force[(t > 21.0) & (t < 70.0)]
    return held.mean(), held.std()


def test_force_of_an_impact_does_not_depend_on_the_step():
    """The mesh rings by two per cent whatever the step; springs of the step's stiffness rang by 7 % to 500 %."""
    mean, rings = plateau()
    assert mean == pytest.approx(1.0, abs=0.005) and rings < 0.03
    small, smaller = plateau(0.2), plateau(0.02)
    assert small == pytest.approx(smaller, abs=0.002)
    assert smaller[0] == pytest.approx(mean, abs=0.005) and smaller[1] < 1.05 * rings


def test_force_of_an_impact_does_not_depend_on_a_stiff_part_elsewhere():
    """A hundred times stiffer: steps are a tenth."""
    assert plateau(stiff=100.0) == pytest.approx(plateau(0.09), abs=0.002)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    for n in (6, 12, 24, 48):
        row = [*pressed(di.Penalty, n), pressed(di.Kinematic, n)[0]]
        print(n, *(f"{value:.2f}" for value in row))
