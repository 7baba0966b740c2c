# SPDX-License-Identifier: MIT
"""Parameters of materials: bounds, messages, and the physics behind the numbers."""

import numpy as np
import pytest
from dolfinx import mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.materials import _Material

LAWS = [di.LinearElastic, di.StVenantKirchhoff, di.NeoHookean]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(
    "arguments, error, words",
    [
        (dict(nu=0.5), ValueError, "0.5.*incompressible.*0.499"),
        (dict(nu=0.6), ValueError, "nu is 0.6.*between -1 and 0.5"),
        (dict(nu=-1.0), ValueError, "nu is -1.0.*between"),
        (dict(nu=float("nan")), ValueError, "nu is nan.*finite"),
        (dict(E=-1.0), ValueError, "E is -1.0.*greater than 0"),
        (dict(E=0), ValueError, "E is 0.0.*greater than 0"),
        (dict(E=float("inf")), ValueError, "E is inf.*finite"),
        (dict(E="207e9"), TypeError, "E must be a number.*'207e9'"),
        (dict(E=None), TypeError, "E must be a number.*None"),
        (dict(E=[1.0, 2.0]), TypeError, "E must be a number"),
        (dict(E=True), TypeError, "E must be a number.*True"),
        (dict(density=-7800.0), ValueError, "density is -7800.0.*not be negative"),
        (dict(density=float("nan")), ValueError, "density is nan"),
        (dict(density="heavy"), TypeError, "density must be a number.*'heavy'"),
        (dict(hypothesis="plain_strain"), ValueError, "plain_strain.*plane_strain"),
        (dict(hypothesis=2), ValueError, "hypothesis 2 is unknown"),
    ],
    ids=lambda a: str(a) if isinstance(a, dict) else "",
)
def test_bad_parameters(law, arguments, error, words):
    with pytest.raises(error, match=words):
        law(**{"E": 207e9, "nu": 0.3, "density": 7800.0, **arguments})


@pytest.mark.parametrize("arguments", [dict(alpha=-1), dict(beta=-0.1), dict(alpha=float("nan"))])
def test_bad_damping(arguments):
    with pytest.raises(ValueError, match="Rayleigh"):
        di.Rayleigh(**arguments)


def test_lame_constants_and_wave_speeds():
    steel = di.LinearElastic(E=207e9, nu=0.3, density=7800.0)
    lmbda, mu = steel.lame
    # Definitions of E and nu in terms of lambda and mu; round-off of a few operations.
    assert mu * (3 * lmbda + 2 * mu) / (lmbda + mu) == pytest.approx(207e9, rel=1e-14)
    assert lmbda / (2 * (lmbda + mu)) == pytest.approx(0.3, rel=1e-14)
    assert steel.wave_speed == pytest.approx(np.sqrt((lmbda + 2 * mu) / 7800.0), rel=1e-14)
    sheet = di.LinearElastic(E=207e9, nu=0.3, density=7800.0, hypothesis="plane_stress")
    assert sheet.wave_speed == pytest.approx(np.sqrt(207e9 / (1 - 0.3**2) / 7800.0), rel=1e-14)


def test_density_is_asked_for():
    with pytest.raises(ValueError, match="no density.*wave speed"):
        di.LinearElastic(1.0, 0.3).wave_speed
    domain = mesh.create_unit_square(MPI.COMM_SELF, 1, 1)
    weightless = di.LinearElastic(1.0, 0.3, 0.0, hypothesis="plane_strain")
    with pytest.raises(ValueError, match="density 0.*wave speed"):
        weightless.wave_speed
    with pytest.raises(ValueError, match="density 0.*StaticProblem"):
        weightless.mass_density(domain)
    with pytest.raises(ValueError, match="no density.*mass"):
        di.LinearElastic(1.0, 0.3, hypothesis="plane_strain").density_constant(domain)


def test_hypothesis_must_fit_the_mesh():
    square = mesh.create_unit_square(MPI.COMM_SELF, 1, 1)
    cube = mesh.create_unit_cube(MPI.COMM_SELF, 1, 1, 1)
    assert di.LinearElastic(1.0, 0.3).hypothesis_on(cube) == "3d"
    with pytest.raises(ValueError, match="2D.*plane_strain, plane_stress or axisymmetric"):
        di.LinearElastic(1.0, 0.3).hypothesis_on(square)
    with pytest.raises(ValueError, match="plane_strain.*dimension 3"):
        di.LinearElastic(1.0, 0.3, hypothesis="plane_strain").hypothesis_on(cube)


def tagged(comm, values, dim=None):
    domain = mesh.create_unit_square(comm, 2, 2)
    dim = domain.topology.dim if dim is None else dim
    domain.topology.create_entities(dim)
    entities = np.arange(len(values), dtype=np.int32)
    return mesh.meshtags(domain, dim, entities, np.array(values, dtype=np.int32))


STEEL = dict(E=1.0, nu=0.3, hypothesis="plane_strain")


@pytest.mark.parametrize(
    "values, materials, words",
    [
        ([1] * 8, {}, "at least one"),
        ([1] * 4 + [2] * 4, {1: STEEL}, r"tags \[2\].*no material"),
        ([1] * 8, {1: STEEL, 3: STEEL}, r"no cell carries the tags \[3\].*\[1\]"),
        ([1] * 7, {1: STEEL}, "1 cells carry no tag"),
        ([1] * 4 + [2] * 4, {1: STEEL, 2: {**STEEL, "hypothesis": "plane_stress"}}, "one hypothesis"),
    ],
)
def test_bad_maps(values, materials, words):
    with pytest.raises(ValueError, match=words):
        di.MaterialMap(tagged(MPI.COMM_SELF, values), {t: di.LinearElastic(**m) for t, m in materials.items()})


def test_map_of_something_else():
    with pytest.raises(TypeError, match="tag 1: expected a material, found str"):
        di.MaterialMap(tagged(MPI.COMM_SELF, [1] * 8), {1: "steel"})
    with pytest.raises(ValueError, match="tags of cells.*dimension 1"):
        di.MaterialMap(tagged(MPI.COMM_SELF, [1] * 8, dim=1), {1: di.LinearElastic(**STEEL)})


def test_map_takes_the_fastest_wave():
    soft, hard = (di.LinearElastic(E, 0.3, 1.0, "plane_strain") for E in (1.0, 4.0))
    both = di.MaterialMap(tagged(MPI.COMM_SELF, [1] * 4 + [2] * 4), {1: soft, 2: hard})
    assert both.wave_speed == hard.wave_speed == pytest.approx(2 * soft.wave_speed, rel=1e-14)


@pytest.mark.parametrize("ranks", [2, 3])
def test_same_error_on_all_ranks(script_on_ranks, ranks):
    """The faulty cell is on one rank only."""
    output = script_on_ranks(
        ranks,
        """
        import numpy as np
        from dolfinx import mesh
        from mpi4py import MPI
        import dolfinx_impact as di
        comm = MPI.COMM_WORLD
        domain = mesh.create_unit_square(comm, 4, 4)
        owned = domain.topology.index_map(2).size_local
        steel = di.LinearElastic(1.0, 0.3, hypothesis="plane_strain")
        def message(values):
            tags = mesh.meshtags(domain, 2, np.arange(len(values), dtype=np.int32), values)
            try:
                di.MaterialMap(tags, {1: steel})
            except ValueError as e:
                return str(e)
        values = np.ones(owned, dtype=np.int32)
        last = comm.rank == comm.size - 1
        wrong = np.where(np.arange(owned) == 0, 7, 1).astype(np.int32) if last else values
        few = values[1:] if last else values
        for found, words in ((message(wrong), "[7]"), (message(few), "1 cells carry no tag")):
            everywhere = comm.allgather(found)
            assert words in everywhere[0] and len(set(everywhere)) == 1, everywhere
        print("same")
        """,
    )
    assert output.count("same") == ranks


@pytest.mark.parametrize("kind", LAWS)
def test_constants_of_a_material_belong_to_a_mesh(kind):
    law = kind(100.0, 0.25, 2.0)
    assert isinstance(law, _Material)
    first, second = (mesh.create_unit_cube(MPI.COMM_SELF, 1, 1, 1) for _ in range(2))
    assert law.constants_on(first) == {} and law.parts() == [(None, law)]
    density = law.mass_density(first)
    assert law.mass_density(first) is density is not law.mass_density(second) and float(density) == 2.0
    law.law(first)
    assert {n: float(c) for n, c in law.constants_on(first).items()} == {"E": 100.0, "nu": 0.25, "density": 2.0}
    assert law.elastic_law(first).E is law.constants_on(first)["E"]
    # lambda = mu = E/(2 (1 + nu)) at nu = 1/4.
    assert law.lame == pytest.approx((40.0, 40.0)) and law.p_wave_modulus == pytest.approx(120.0)
    sheet = kind(100.0, 0.25, 2.0, "plane_stress")
    assert sheet.p_wave_modulus == pytest.approx(100.0 / (1 - 0.25**2)) == pytest.approx(2.0 * sheet.wave_speed**2)
    with pytest.raises(ValueError, match="does not fit"):
        sheet.law(first)
