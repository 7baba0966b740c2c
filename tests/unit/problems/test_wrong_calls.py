# SPDX-License-Identifier: MIT
"""Wrong calls of the public interface, as users make them: the type of the error and a word of its text."""

import copy
import gc
import pickle
import re
import warnings

import basix.ufl
import numpy as np
import pytest
import ufl
from dolfinx import fem, io, mesh
from mpi4py import MPI

import dolfinx_impact as di

COMM = MPI.COMM_SELF
NAN, INF = float("nan"), float("inf")


def law(**changes):
    return di.LinearElastic(**{**dict(E=1e4, nu=0.3, density=1.0, hypothesis="plane_strain"), **changes})


def square(n=2, cell="triangle", **options):
    return mesh.create_unit_square(COMM, n, n, getattr(mesh.CellType, cell), **options)


def tags_of(domain, **where):
    """MeshTags of boundary facets: tags_of(domain, y0=3) marks y = 0 by 3."""
    parts, values = [], []
    for name, tag in where.items():
        axis, value = "xyz".index(name[0]), float(name[1:])
        parts.append(mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[axis], value)))
        values.append(np.full(len(parts[-1]), tag, dtype=np.int32))
    facets, first = np.unique(np.concatenate(parts), return_index=True)
    return mesh.meshtags(domain, 1, facets, np.concatenate(values)[first])


class Body:
    """A square that is held at its top, over a rigid plane."""

    def __init__(self, domain=None, element=("Lagrange", 1, (2,))):
        self.mesh = domain or square()
        self.V = fem.functionspace(self.mesh, element)
        self.u, self.velocity = fem.Function(self.V, name="u"), fem.Function(self.V)
        self.tags = tags_of(self.mesh, y0=3, x1=5)

    def held(self, value=(0.0, 0.0)):
        dofs = fem.locate_dofs_geometrical(self.V, lambda x: np.isclose(x[1], 1.0))
        return fem.dirichletbc(np.array(value), dofs, self.V)

    def pair(self, master=None, **options):
        return di.ContactPair(self.tags, 3, master or di.RigidPlane((0, -0.1), (0, 1)), **options)

    def static(self, material=None, **options):
        return di.StaticProblem(self.u, material or law(), **{"bcs": [self.held()], **options})

    def explicit(self, material=None, **options):
        return di.ExplicitProblem(self.u, material or law(), **{"velocity": self.velocity, **options})

    def force(self, form=None):
        v = ufl.TestFunction(self.V)
        return di.InternalForce(form(self.u, v) if form else v[0] * ufl.dx)


def on(element, domain=None):
    """Both problems on another space."""
    V = fem.functionspace(domain or square(), element)
    kind = V.mesh.geometry.x.dtype
    u, velocity = (fem.Function(V, name="u", dtype=kind) for _ in range(2))
    given = law() if V.mesh.geometry.dim == 2 else law(hypothesis="3d")
    return lambda: di.StaticProblem(u, given), lambda: di.ExplicitProblem(u, given, velocity=velocity)


def surface():
    element = basix.ufl.element("Lagrange", "triangle", 1, shape=(3,))
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.3]])
    return mesh.create_mesh(COMM, np.array([[0, 1, 2], [1, 2, 3]]), x=points, e=element)


def moved(change, cell="triangle"):
    domain = square(cell=cell)
    change(domain.geometry.x)
    return domain


def inside_out(x):
    x[np.argmin(np.linalg.norm(x[:, :2] - 0.5, axis=1)), :2] = [-3.0, -3.0]


def flat(x):
    x[:, 1] = 0.0


def not_a_number(x):
    x[4] = NAN


def left_of_the_axis(x):
    x[:, 0] -= 0.5


SPACES = {
    "mesh of float32": (lambda: on(("Lagrange", 1, (2,)), square(dtype=np.float32)), TypeError, "float32.*float64"),
    "1D mesh": (
        lambda: on(("Lagrange", 1, (1,)), mesh.create_interval(COMM, 4, (0.0, 1.0))), ValueError, "1 in 1.*bars"),
    "surface in space": (lambda: on(("Lagrange", 1, (3,)), surface()), ValueError, "dimension 2 in 3.*shells"),
    "scalar": (lambda: on(("Lagrange", 1)), ValueError, "u is a scalar.*2 components"),
    "three components in the plane": (lambda: on(("Lagrange", 1, (3,))), ValueError, r"\(3,\).*2 components"),
    "discontinuous": (lambda: on(("DG", 1, (2,))), ValueError, "discontinuous"),
    "Nedelec": (lambda: on(("N1curl", 1)), ValueError, "not of Lagrange's kind"),
    "Crouzeix-Raviart": (lambda: on(("CR", 1, (2,))), ValueError, "not of Lagrange's kind"),
    "cell inside out": (lambda: on(("Lagrange", 1, (2,)), moved(inside_out)), ValueError, "over a neighbour"),
    "quadrilateral inside out": (
        lambda: on(("Lagrange", 1, (2,)), moved(inside_out, "quadrilateral")), ValueError, "folded or inverted"),
    "flat cells": (lambda: on(("Lagrange", 1, (2,)), moved(flat)), ValueError, "zero volume"),
    "coordinates": (lambda: on(("Lagrange", 1, (2,)), moved(not_a_number)), ValueError, "coordinates are not finite"),
}  # fmt: skip


@pytest.mark.parametrize("which", (0, 1), ids=("static", "explicit"))
@pytest.mark.parametrize("name", SPACES)
def test_spaces_and_meshes(name, which):
    make, kind, words = SPACES[name]
    with pytest.raises(kind, match=re.compile(words, re.DOTALL)):
        make()[which]()


def test_complex_function():
    u = fem.Function(fem.functionspace(square(), ("Lagrange", 1, (2,))), dtype=np.complex128)
    with pytest.raises(TypeError, match="complex128.*float64"):
        di.StaticProblem(u, law())


@pytest.mark.parametrize("method", ("static", "explicit"))
def test_axisymmetric_left_of_the_axis(method):
    body = Body(moved(left_of_the_axis))
    with pytest.raises(ValueError, match="3 nodes of the mesh have x < 0, down to -0.5"):
        getattr(body, method)(law(hypothesis="axisymmetric"))


def one(body, **options):
    """A solution with a body force, so that there is something to do."""
    problem = body.static(loads=[di.BodyForce((0, -1.0))], options=options.pop("options", None))
    return problem.solve(**options)


def run(body, **options):
    return body.explicit().advance(**{"until": 0.01, "progress": False, **options})


def nested(body):
    problem = body.explicit()
    problem.advance(0.01, callback=lambda p: p.advance(p.time + 0.001, progress=False), progress=False)


def pressed_in(body, how):
    """All nodes of the slave are prescribed, and end inside the obstacle."""
    bc = fem.dirichletbc(np.array([0.0, -0.2]), np.arange(body.V.dofmap.index_map.size_local, dtype=np.int32), body.V)
    return body.static(bcs=[bc], contact=[how(body.pair())]).solve()


def with_penalty(body, value, explicit=False):
    contact = [di.Penalty(body.pair(), penalty=value)]
    return body.explicit(contact=contact).advance(1.0) if explicit else body.static(contact=contact).solve()


def not_finite(body):
    body.u.x.array[3] = NAN
    return body.static().solve()


def other_tags(body):
    return tags_of(square(), y0=3, x1=5)


def measure(**metadata):
    return lambda b: b.force(lambda u, v: ufl.inner(u, v) * ufl.dx(metadata=metadata))


CALLS = {
    # kinds of arguments
    "u None": (lambda b: di.StaticProblem(None, law()), TypeError, "Function of dolfinx.fem, found NoneType"),
    "u a space": (lambda b: di.StaticProblem(b.V, law()), TypeError, r"fem.Function\(V\)"),
    "no material": (lambda b: di.StaticProblem(b.u), ValueError, "either a material or a residual"),
    "material a text": (lambda b: b.static("steel"), TypeError, "found 'steel'.*LinearElastic"),
    "material a class": (lambda b: b.static(di.LinearElastic), TypeError, "is the class LinearElastic"),
    "material a number": (lambda b: b.explicit(3.0), TypeError, "material must be a material, found float"),
    "bcs None": (lambda b: b.static(bcs=None), TypeError, "a DirichletBC or a list of them, found NoneType"),
    "bcs of texts": (lambda b: b.explicit(bcs=["a"]), TypeError, "bcs must hold DirichletBC"),
    "bc of another mesh": (lambda b: b.static(bcs=[Body().held()]), ValueError, "another mesh than u"),
    "bc of another mesh, explicit": (lambda b: b.explicit(bcs=[Body().held()]), ValueError, "another mesh than u"),
    "bc of another space": (
        lambda b: b.static(bcs=[Body(b.mesh, ("Lagrange", 2, (2,))).held()]), ValueError, "another space than u"),
    "loads a vector": (lambda b: b.static(loads=[(0, -1)]), TypeError, "loads must hold Traction"),
    "load tags of another mesh": (
        lambda b: b.static(loads=[di.Traction(other_tags(b), 5, (0, 1))]), ValueError, "another mesh than u"),
    "load with amplitude": (
        lambda b: b.static(loads=[di.BodyForce((0, 1), amplitude=abs)]), ValueError, "amplitude.*problems in time"),
    "contact a pair": (lambda b: b.static(contact=[b.pair()]), TypeError, r"contact=\[di.Lagrange\(pair\)\]"),
    "contact a pair, explicit": (lambda b: b.explicit(contact=[b.pair()]), TypeError, r"di.Kinematic\(pair\)"),
    "contact a class": (lambda b: b.static(contact=[di.Penalty]), TypeError, "found Penalty"),
    "pair's tags of another mesh": (
        lambda b: b.static(contact=[di.Lagrange(di.ContactPair(other_tags(b), 3, di.RigidPlane((0, 0), (0, 1))))]),
        ValueError, "another mesh than u"),
    "residual a text": (lambda b: di.StaticProblem(b.u, residual="F"), TypeError, "residual must be a UFL form"),
    "residual of rank 0": (
        lambda b: di.StaticProblem(b.u, residual=ufl.inner(b.u, b.u) * ufl.dx), ValueError, "this one has rank 0"),
    "options a text": (lambda b: b.static(options="abc"), TypeError, "options must be a dict"),
    "options with a dash": (lambda b: b.static(options={"-ksp_type": "cg"}), ValueError, "without dash"),
    "unknown ksp_type": (lambda b: b.static(options={"ksp_type": "none such"}), ValueError, "PETSc does not take"),
    "unknown snes_type": (lambda b: one(b, options={"snes_type": "none such"}), ValueError, "PETSc does not take"),
    # solve
    "steps nan": (lambda b: one(b, steps=NAN), ValueError, "positive integer"),
    "steps None": (lambda b: one(b, steps=None), TypeError, "positive integer"),
    "steps a text": (lambda b: one(b, steps="2"), TypeError, "positive integer"),
    "rtol nan": (lambda b: one(b, rtol=NAN), ValueError, "rtol is nan"),
    "rtol negative": (lambda b: one(b, rtol=-1), ValueError, "from 0 to 1"),
    "rtol a text": (lambda b: one(b, rtol="a"), TypeError, "rtol must be a number"),
    "no iterations": (lambda b: one(b, max_iterations=0), ValueError, "max_iterations is 0"),
    "u not finite": (not_finite, ValueError, "not finite numbers"),
    "slave prescribed, multipliers": (
        lambda b: pressed_in(b, di.Lagrange), RuntimeError, "prescribed along the normal.*exchange slave and master"),
    "penalty of 1e30": (lambda b: with_penalty(b, 1e30), ValueError, "penalty is 1e.30, .* times what material"),
    # advance
    "penalty of 1e30, explicit": (lambda b: with_penalty(b, 1e30, True), ValueError, "large penalty"),
    "dt of 1e-300": (lambda b: run(b, dt=1e-300), ValueError, "1e.298 steps.*larger dt"),
    "dt of 1e-12": (lambda b: run(b, dt=1e-12), ValueError, "1e.10 steps"),
    "dt None": (lambda b: run(b, dt=None), TypeError, "dt must be a number"),
    "callback a number": (lambda b: run(b, callback=3), TypeError, "callback must be a function"),
    "advance from a callback": (nested, RuntimeError, "called while it runs"),
    "velocity an array": (lambda b: b.explicit(velocity=np.zeros(3)), TypeError, "velocity must be"),
    "save, no name": (lambda b: b.explicit().save(None), TypeError, "path must be the name"),
    "save, empty name": (lambda b: b.explicit().save(""), ValueError, "path is empty"),
    "record, fields a text": (lambda b: b.explicit().record("x", fields="displacement"), TypeError, "list of names"),
    "record, every a text": (lambda b: b.explicit().record("x", every="a"), TypeError, "every is 'a'"),
    "record, points": (lambda b: b.explicit().record("x", points=[[NAN, 0.0]]), ValueError, "not finite"),
    # parts
    "tag None": (lambda b: di.ContactPair(b.tags, None, 4), TypeError, "tag must be an integer, found None"),
    "tag nan": (lambda b: di.ContactPair(b.tags, NAN, 4), TypeError, "tag must be an integer, found nan"),
    "master None": (lambda b: di.ContactPair(b.tags, 3, None), TypeError, "a list of tags or a rigid obstacle"),
    "master a class": (lambda b: di.ContactPair(b.tags, 3, di.RigidPlane), TypeError, "make an object of it"),
    "traction without tags": (lambda b: di.Traction(None, 5, (0, 1)), TypeError, "Traction: facet_tags"),
    "MaterialMap without tags": (lambda b: di.MaterialMap(None, {1: law()}), TypeError, "MeshTags of cells"),
    "MaterialMap of a list": (lambda b: di.MaterialMap(b.tags, [law()]), TypeError, "must be a dict"),
    "sweeps None": (lambda b: di.Kinematic(b.pair(), sweeps=None), TypeError, "sweeps is None"),
    "sweeps nan": (lambda b: di.Kinematic(b.pair(), sweeps=NAN), ValueError, "positive integer"),
    "sweeps a text": (lambda b: di.Kinematic(b.pair(), sweeps="x"), TypeError, "positive integer"),
    **{f"{how.__name__}, degree {degree!r}": (
        lambda b, how=how, degree=degree: how(b.pair(), quadrature_degree=degree), kind, "quadrature_degree is .* 60")
       for how in (di.Penalty, di.Lagrange)
       for degree, kind in ((-1, ValueError), (1.5, ValueError), (200, ValueError), ("3", TypeError))},
    "measure, degree of 500": (measure(quadrature_degree=500), ValueError, "quadrature_degree is 500"),
    "measure, degree a text": (measure(quadrature_degree="a"), TypeError, "quadrature_degree is 'a'"),
    "measure, unknown rule": (measure(quadrature_rule="bogus"), ValueError, "quadrature_rule is 'bogus'"),
    "assemble, float32": (
        lambda b: b.force().assemble(np.zeros(18, dtype=np.float32)), TypeError, "float32: float64 is needed"),
    "assemble, with gaps": (lambda b: b.force().assemble(np.zeros(36)[::2]), ValueError, "no gaps"),
    "assemble, a list": (lambda b: b.force().assemble([0.0] * 18), TypeError, "NumPy array"),
    "apply, an array": (lambda b: b.force().apply(np.zeros(18)), TypeError, "la.Vector"),
    "points of another shape": (lambda b: di.PointValues(b.u[0], [[0.1]]), ValueError, r"shape \(1, 1\)"),
    "points outside the cell": (lambda b: di.PointValues(b.u[0], [[0.8, 0.8]]), ValueError, "outside the reference"),
    "check_mesh None": (lambda b: di.check_mesh(None), TypeError, "mesh must be a dolfinx mesh"),
    "lumped_mass None": (lambda b: di.lumped_mass(None, None), TypeError, "FunctionSpace"),
    "read_mesh None": (lambda b: di.read_mesh(None), TypeError, "path must be"),
}  # fmt: skip


@pytest.mark.parametrize("name", CALLS)
def test_wrong_call(name):
    call, kind, words = CALLS[name]
    with pytest.raises(kind, match=re.compile(words, re.DOTALL)) as found:
        call(Body())
    assert type(found.value) is kind


@pytest.mark.parametrize("method", ("static", "explicit"))
@pytest.mark.parametrize("copied", (copy.copy, copy.deepcopy, pickle.dumps), ids=lambda f: f.__name__)
def test_problems_are_not_copied(method, copied):
    with pytest.raises(TypeError, match="cannot be (copied|pickled): it shares its state"):
        copied(getattr(Body(), method)())


def test_two_problems_on_one_function():
    body = Body()
    first = body.explicit()
    for make in (body.explicit, body.static):
        with pytest.warns(UserWarning, match="same displacement function"):
            make()
    gc.collect()
    del first
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        body.static()
        body.static()  # they read u, and one may prepare what the other starts from
        body.explicit()


def test_petsc_options_that_nobody_reads():
    body = Body()
    with pytest.warns(UserWarning, match=r"\['kps_type'\]"):
        one(body, options={"kps_type": "cg", "ksp_rtol": 1e-8})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        one(body, options={"ksp_type": "cg", "pc_type": "jacobi", "ksp_rtol": 1e-10, "snes_rtol": 1e-8})


def test_equal_spaces_of_one_mesh_may_be_mixed():
    body = Body()
    other = Body(body.mesh)
    body.static(bcs=[other.held()])
    body.explicit(bcs=[other.held()], velocity=other.velocity)


@pytest.mark.parametrize("number", (-1, 10**6))
def test_xdmf_that_names_nodes_that_are_not_there(tmp_path, number):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "a.xdmf"
    with io.XDMFFile(COMM, path, "w") as file:
        file.write_mesh(square())
    with h5py.File(tmp_path / "a.h5", "a") as data:
        data["Mesh/mesh/topology"][0, 0] = number
    with pytest.raises(ValueError, match=f"row 0 of grid 'mesh' names the node {number}, but there are 9 nodes"):
        di.read_mesh(path, comm=COMM)
