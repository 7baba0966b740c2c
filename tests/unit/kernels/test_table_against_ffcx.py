# SPDX-License-Identifier: MIT
"""Every kernel built with the package equals FFCx's own C kernel, in every vector width and on every local facet."""

import numpy as np
import pytest
from kernel_oracle import Oracle, aligned, build_many, constants, difference, random_cell

from dolfinx_impact import _cpp
from dolfinx_impact.forms import registry

ROWS = [(r.name, r.cell, r.degree, r.geometry_degree, r.hypothesis) for r in registry.TABLE]
# FFCx has no kernels with internal variables or stresses: see test_packaged_plasticity.py and test_packaged_stress.py.
SPECS = [spec for spec in ROWS if not spec[0].startswith("j2.") and not spec[0].endswith(".stress")]

# Both kernels sum the same few hundred terms in different orders: some tens of roundings of 1.1e-16. The neo-Hookean
# energy is the small difference of terms of order one: at strains of a few percent (squares about 1e-3) three digits
# are lost.
TOLERANCE = 1e-13
CANCELLING = {"neo_hookean.energy": 2e-12}


@pytest.fixture(scope="module")
def libraries(tmp_path_factory):
    return build_many(SPECS, tmp_path_factory.mktemp("table"), with_ours=False)


@pytest.mark.parametrize("spec", SPECS, ids=lambda s: "-".join(map(str, s)))
def test_row_equals_ffcx(spec, libraries, rng):
    kernels = _cpp.kernels.find(*spec)
    assert kernels and all(k.name == spec[0] and k.flops > 0 for k in kernels)
    oracle = Oracle(libraries[spec][0])
    for kernel in kernels:
        # the radius of axisymmetric cells stays positive
        assert difference(kernel, oracle, rng, shift=3.0 * (spec[4] == "axisymmetric")) < CANCELLING.get(
            spec[0], TOLERANCE
        )


def test_table_holds_the_registry():
    rows = {(k.name, k.cell, k.geometry_degree, k.hypothesis) for k in _cpp.kernels.table()}
    assert rows == {(s[0], s[1], s[3], s[4]) for s in ROWS}


def test_a_machine_that_has_vectors_uses_them():
    widest = _cpp.kernels.processor_width()
    available = [w for w in (1, 4, 8) if w <= widest]
    for kernel in _cpp.kernels.table():  # matrices of eight cells are too large for a first cache
        assert kernel.widths == (available if kernel.rank < 2 else available[:2])


def test_a_matrix_depends_neither_on_its_lane_nor_on_the_others(rng):
    """Bit by bit: assembly gives the same on any number of ranks."""
    kernels = [k for k in _cpp.kernels.table() if k.rank == 2 and 4 in k.widths]
    assert bool(kernels) == (_cpp.kernels.processor_width() >= 4)
    for kernel in kernels:
        x, w = (aligned((size, 4)) for size in (3 * kernel.num_nodes, sum(e["num_dofs"] for e in kernel.coefficients)))
        for lane in range(4):
            x[:, lane] = random_cell(kernel, rng, 3.0 * (kernel.hypothesis == "axisymmetric")).ravel()
        w[:] = rng.uniform(-0.05, 0.05, size=w.shape)
        c, found = constants(kernel, rng), []
        for order in ([0, 1, 2, 3], [3, 0, 0, 0]):  # the fourth cell, then in the first lane beside copies of another
            A, x_now, w_now = aligned((int(np.prod(kernel.shape)), 4)), aligned(x.shape), aligned(w.shape)
            x_now[:], w_now[:] = x[:, order], w[:, order]
            kernel.tabulate(A.reshape(-1), w_now.reshape(-1), c, x_now.reshape(-1), lanes=4)
            found.append(A[:, order.index(3)].copy())
        assert np.any(found[0]) and np.array_equal(*found)
