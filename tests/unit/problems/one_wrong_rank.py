# SPDX-License-Identifier: MIT
"""Every public call that communicates, with an argument that is wrong, or another one, on the last rank only.

As a script, on several ranks: each case must raise on all ranks, the same error, of the type and with the word that the
table says. Only cases that fail are printed, and the one that hangs.
"""

import faulthandler
import math
import tempfile

import numpy as np
import ufl
from dolfinx import fem, la, mesh
from mpi4py import MPI

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
SECONDS = 30  # for a case: far more than any takes, as machines may be busy
NAN = float("nan")


class Setting:
    """A square over a rigid plane, and what calls take; made once."""

    def __init__(self):
        self.mesh, self.other = (mesh.create_unit_square(COMM, 4, 4, mesh.CellType.quadrilateral) for _ in range(2))
        self.V, self.W = (fem.functionspace(m, ("Lagrange", 1, (2,))) for m in (self.mesh, self.other))
        self.tags, self.other_tags = (self._tags(m) for m in (self.mesh, self.other))
        count = self.mesh.topology.index_map(2).size_local + self.mesh.topology.index_map(2).num_ghosts
        self.cells = mesh.meshtags(self.mesh, 2, np.arange(count, dtype=np.int32), np.full(count, 1, dtype=np.int32))
        self.bc, self.other_bc = (self._bc(V) for V in (self.V, self.W))
        self.u, self.v = fem.Function(self.V, name="u"), ufl.TestFunction(self.V)
        self.velocity, self.not_finite = fem.Function(self.V), fem.Function(self.V)
        self.not_finite.x.array[:] = NAN
        self.form = ufl.inner(ufl.grad(self.u), ufl.grad(self.v)) * ufl.dx
        self.another = ufl.inner(self.u, self.v) * ufl.dx
        self.plane = di.RigidPlane((0, -0.1), (0, 1))
        self.pair = di.ContactPair(self.tags, 3, self.plane)
        self.force = di.InternalForce(self.form)
        self.spoilt = False  # of the functions of time below
        self.static = di.StaticProblem(fem.Function(self.V, name="u"), law(), bcs=[self.bc])
        self.loaded = di.StaticProblem(
            fem.Function(self.V, name="u"), law(), bcs=[self.bc], loads=[di.BodyForce((0, 1))]
        )
        self.touching = di.StaticProblem(
            fem.Function(self.V, name="u"), law(), bcs=[self.bc], contact=[di.Lagrange(self.pair)]
        )
        self.run = self.explicit()
        load = di.BodyForce((0, 1), amplitude=self._amplitude)
        self.driven = di.ExplicitProblem(fem.Function(self.V, name="u"), law(), velocity=self.velocity, loads=[load])
        self.implicit = self.newmark()
        driving = di.BodyForce((0, 1), amplitude=self._amplitude)
        self.driven_implicit = self.newmark(bcs=[], loads=[driving])
        self.folder = COMM.bcast(tempfile.mkdtemp() if COMM.rank == 0 else None)
        self.run.save(f"{self.folder}/good.h5")
        self.implicit.save(f"{self.folder}/implicit.h5")
        self.static.save(f"{self.folder}/static.h5")

    def _amplitude(self, t):
        if self.spoilt == "raises":
            raise KeyError("no such time")
        return NAN if self.spoilt else 1.0

    @staticmethod
    def _tags(domain):
        parts = [mesh.locate_entities_boundary(domain, 1, lambda x, y=y: np.isclose(x[1], y)) for y in (0.0, 1.0)]
        order = np.argsort(np.concatenate(parts))
        values = np.repeat([3, 4], [len(p) for p in parts]).astype(np.int32)
        return mesh.meshtags(domain, 1, np.concatenate(parts)[order], values[order])

    @staticmethod
    def _bc(V):
        return fem.dirichletbc(np.zeros(2), fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[1], 1.0)), V)

    def explicit(self, **changes):
        given = dict(material=law(), velocity=self.velocity, bcs=[self.bc]) | changes
        return di.ExplicitProblem(given.pop("u", None) or fem.Function(self.V, name="u"), **given)

    def newmark(self, **changes):
        given = dict(material=law(), velocity=self.velocity, bcs=[self.bc]) | changes
        return di.NewmarkProblem(given.pop("u", None) or fem.Function(self.V, name="u"), **given)


def law(E=1.0, **changes):
    return di.LinearElastic(E, 0.3, density=1.0, **{"hypothesis": "plane_strain", **changes})


def calls_of_problems(s):
    """(name, call of one argument, right argument, wrong argument, error, word of the text)."""

    def static(u=s.u, material=None, **given):
        material = law() if material is None and "residual" not in given else material
        return di.StaticProblem(u, material, **{"bcs": [s.bc], **given})

    vector = fem.Function(s.V)
    return [
        ("StaticProblem, u", static, s.u, None, TypeError, "Function"),
        ("StaticProblem, u a space", static, s.u, s.V, TypeError, "Function"),
        ("StaticProblem, material", lambda m: static(material=m), law(), "steel", TypeError, "material"),
        ("StaticProblem, E", lambda E: static(material=law(E)), 1.0, 2.0, ValueError, "material differs"),
        ("StaticProblem, bcs", lambda b: static(bcs=b), [s.bc], {s.bc}, TypeError, "list"),
        ("StaticProblem, bc of another mesh", lambda b: static(bcs=[b]), s.bc, s.other_bc, ValueError, "another mesh"),
        ("StaticProblem, number of bcs", lambda b: static(bcs=b), [s.bc], [s.bc, s.bc], ValueError, "bcs differs"),
        ("StaticProblem, loads", lambda x: static(loads=x), [di.BodyForce((0, 1))], [(0, 1)], TypeError, "loads"),
        ("StaticProblem, value of a load", lambda f: static(loads=[di.BodyForce(f)]), (0, 1), (0, 2), ValueError,
         "loads differs"),
        ("StaticProblem, contact", lambda c: static(contact=c), [di.Lagrange(s.pair)], [s.pair], TypeError, "Lagrange"),
        ("StaticProblem, residual", lambda F: static(residual=F), s.form, s.another, ValueError, "residual differs"),
        ("StaticProblem, residual of a kind", lambda F: static(residual=F), s.form, "F", TypeError, "UFL form"),
        ("StaticProblem, function of a residual", lambda w: static(u=w, residual=s.form), s.u, vector, ValueError,
         "does not contain the displacement"),
        ("StaticProblem, options", lambda o: static(options=o), {"ksp_type": "cg"}, {"ksp_type": "gmres"}, ValueError,
         "options differs"),
        ("StaticProblem, options of a kind", lambda o: static(options=o), None, "cg", TypeError, "dict"),
        ("StaticProblem, prefix", lambda p: static(prefix=p), "a_", "b_", ValueError, "prefix differs"),
        ("solve, steps", lambda n: s.static.solve(steps=n), 1, 2, ValueError, "steps differs"),
        ("solve, steps 0", lambda n: s.static.solve(steps=n), 1, 0, ValueError, "positive integer"),
        ("solve, steps a text", lambda n: s.static.solve(steps=n), 1, "2", TypeError, "positive integer"),
        ("solve, rtol", lambda r: s.static.solve(rtol=r), 1e-8, NAN, ValueError, "finite"),
        ("solve, atol", lambda a: s.static.solve(atol=a), 0.0, 1.0, ValueError, "atol differs"),
        ("solve, max_iterations", lambda n: s.static.solve(max_iterations=n), 25, 24, ValueError, "max_iterations"),
        ("solve, cut_backs", lambda n: s.static.solve(cut_backs=n), None, 3, ValueError, "cut_backs"),
        ("solve, u not finite", lambda x: spoilt_start(s, x), 0.0, NAN, ValueError, "not finite"),
        ("solve, load changed", lambda f: changed_load(s, f), 1.0, 2.0, ValueError, "loads differs"),
        ("save static, path", s.static.save, f"{s.folder}/a.h5", None, TypeError, "path"),
        ("restore static, path", s.static.restore, f"{s.folder}/static.h5", f"{s.folder}/none.h5", ValueError,
         "path differs"),
        ("ExplicitProblem, u", lambda u: s.explicit(u=u), s.u, 3.0, TypeError, "Function"),
        ("ExplicitProblem, velocity", lambda v: s.explicit(velocity=v), s.velocity, None, ValueError, "velocity"),
        ("ExplicitProblem, nan", lambda v: s.explicit(velocity=v), s.velocity, s.not_finite, ValueError,
         "not a number"),
        ("ExplicitProblem, damping", lambda d: s.explicit(damping=d), None, (0.1, 0.0), TypeError, "Rayleigh"),
        ("ExplicitProblem, alpha", lambda a: s.explicit(damping=di.Rayleigh(a, 0.0)), 0.1, 0.2, ValueError, "damping"),
        ("ExplicitProblem, scheme", lambda x: s.explicit(scheme=x), "half_step", "newmark", ValueError, "scheme"),
        ("ExplicitProblem, bulk", lambda b: s.explicit(bulk_viscosity=b), None, (0.1, 0.1), ValueError,
         "bulk_viscosity"),
        ("ExplicitProblem, lumping", lambda x: s.explicit(lumping=x), "auto", "hrz", ValueError, "lumping"),
        ("ExplicitProblem, mass_scaling", lambda x: s.explicit(mass_scaling=x), None, 1.0, ValueError, "mass_scaling"),
        ("ExplicitProblem, friction", lambda f: s.explicit(contact=[di.Penalty(di.ContactPair(s.tags, 3, s.plane, f))]),
         0.1, 0.2, ValueError, "friction differs"),
        ("ExplicitProblem, tags of another mesh",
         lambda t: s.explicit(contact=[di.Penalty(di.ContactPair(t, 3, s.plane))]), s.tags, s.other_tags, ValueError,
         "another mesh"),
        ("advance, until", lambda t: s.run.advance(t, progress=False), 1.0, 2.0, ValueError, "until differs"),
        ("advance, until nan", lambda t: s.run.advance(t, progress=False), 1.0, NAN, ValueError, "finite"),
        ("advance, until a text", lambda t: s.run.advance(t, progress=False), 1.0, "1", TypeError, "number"),
        ("advance, dt", lambda dt: s.run.advance(1.0, dt=dt, progress=False), 0.01, 0.02, ValueError, "dt differs"),
        ("advance, dt negative", lambda dt: s.run.advance(1.0, dt=dt, progress=False), 0.01, -1.0, ValueError, "dt"),
        ("advance, callback on some ranks", lambda f: s.run.advance(1.0, callback=f, progress=False), None, len,
         ValueError, "callback differs"),
        ("advance, callback of a kind", lambda f: s.run.advance(1.0, callback=f, progress=False), abs, 3, TypeError,
         "callback"),
        ("advance, callback raises", lambda k: s.run.advance(s.run.time + 1.0, callback=lambda p: {}[k] if k else None,
                                                             progress=False), None, "key", KeyError, "key"),
        ("advance, function of time", lambda w: spoilt_amplitude(s, w), False, "nan", ValueError, "nan"),
        ("advance, function of time raises", lambda w: spoilt_amplitude(s, w), False, "raises", KeyError, "such time"),
        ("advance, unsafe", lambda x: s.run.advance(9.0, unsafe=x, progress=False), False, True, ValueError, "unsafe"),
        ("stable_step", s.run.stable_step, "element", "eigenvalue", ValueError, "method differs"),
        ("save, path", s.run.save, f"{s.folder}/a.h5", None, TypeError, "path"),
        ("save, another path", s.run.save, f"{s.folder}/a.h5", f"{s.folder}/b.h5", ValueError, "path differs"),
        ("restore, path", s.run.restore, f"{s.folder}/good.h5", f"{s.folder}/none.h5", ValueError, "path differs"),
        ("record, fields", lambda f: s.run.record(s.folder, fields=f), ("displacement",), ("stresses",), ValueError,
         "unknown"),
        ("record, every", lambda n: s.run.record(s.folder, every=n), 10, 0, ValueError, "every"),
        ("record, points", lambda p: s.run.record(s.folder, points=p), [[0.0, 0.0]], [[NAN, 0.0]], ValueError,
         "finite"),
    ]  # fmt: skip


def calls_of_implicit_problems(s):
    """As calls_of_problems."""

    def advance(until=1.0, dt=0.5, **options):
        s.implicit.advance(until, dt, progress=False, **options)

    return [
        ("NewmarkProblem, u", lambda u: s.newmark(u=u), s.u, 3.0, TypeError, "Function"),
        ("NewmarkProblem, velocity", lambda v: s.newmark(velocity=v), s.velocity, None, ValueError, "velocity"),
        ("NewmarkProblem, nan", lambda v: s.newmark(velocity=v), s.velocity, s.not_finite, ValueError, "not a number"),
        ("NewmarkProblem, beta", lambda b: s.newmark(beta=b), 0.25, 0.3, ValueError, "scheme differs"),
        ("NewmarkProblem, beta 0", lambda b: s.newmark(beta=b), 0.25, 0.0, ValueError, "beta is 0"),
        ("NewmarkProblem, gamma", lambda g: s.newmark(gamma=g), 0.5, 0.4, ValueError, "gamma"),
        ("NewmarkProblem, rho_inf", lambda r: s.newmark(rho_inf=r), 0.8, NAN, ValueError, "finite"),
        ("NewmarkProblem, hht", lambda a: s.newmark(hht=a), -0.1, "a", TypeError, "number"),
        ("NewmarkProblem, damping", lambda d: s.newmark(damping=d), None, (0.1, 0.0), TypeError, "Rayleigh"),
        ("NewmarkProblem, lumping", lambda x: s.newmark(lumping=x), None, "hrz", ValueError, "lumping differs"),
        ("NewmarkProblem, impact", lambda x: s.newmark(impact=x), "none", "some", ValueError, "impact is 'some'"),
        ("NewmarkProblem, options", lambda o: s.newmark(options=o), None, {"ksp_rtol": 1e-8}, ValueError, "options"),
        ("NewmarkProblem, contact", lambda f: s.newmark(contact=[di.Lagrange(di.ContactPair(s.tags, 3, s.plane, f))]),
         0.1, 0.2, ValueError, "friction differs"),
        ("advance implicit, until", lambda t: advance(until=t), 1.0, 2.0, ValueError, "until differs"),
        ("advance implicit, dt", lambda dt: advance(dt=dt), 0.5, 0.0, ValueError, "dt"),
        ("advance implicit, tolerance", lambda x: advance(tolerance=x), None, 1e-3, ValueError, "tolerance differs"),
        ("advance implicit, smallest", lambda x: advance(smallest=x), 0.1, 1.0, ValueError, "smallest"),
        ("advance implicit, rtol", lambda x: advance(rtol=x), 1e-8, 2.0, ValueError, "rtol"),
        ("advance implicit, max_iterations", lambda n: advance(max_iterations=n), 25, 0, ValueError, "positive"),
        ("advance implicit, callback", lambda f: advance(callback=f), None, len, ValueError, "callback differs"),
        ("advance implicit, callback raises", lambda k: s.implicit.advance(
            s.implicit.time + 1.0, 0.5, callback=lambda p: {}[k] if k else None, progress=False), None, "key",
         KeyError, "key"),
        ("advance implicit, function of time", lambda w: spoilt_amplitude(s, w, True), False, "nan", ValueError, "nan"),
        ("advance implicit, function of time raises", lambda w: spoilt_amplitude(s, w, True), False, "raises",
         KeyError, "such time"),
        ("save implicit, path", s.implicit.save, f"{s.folder}/a.h5", None, TypeError, "path"),
        ("restore implicit, path", s.implicit.restore, f"{s.folder}/implicit.h5", f"{s.folder}/none.h5", ValueError,
         "path differs"),
        ("record implicit, fields", lambda f: s.implicit.record(s.folder, fields=f), ("displacement",), ("stresses",),
         ValueError, "unknown"),
        ("record implicit, ending", lambda e: s.implicit.record(s.folder, ending=e), ".xdmf", ".vtk", ValueError,
         "ending"),
        ("record implicit, units", lambda n: s.implicit.record(s.folder, units=n), di.SI, di.MILLIMETRES, ValueError,
         "output differs"),
        ("record implicit, times", lambda t: s.implicit.record(s.folder, times=[t]), 1.0, NAN, ValueError, "finite"),
    ]  # fmt: skip


def calls_of_parts(s):
    tensor = ufl.inner(ufl.TrialFunction(s.V), s.v) * ufl.dx
    middle = [[0.5, 0.5]]
    short = la.vector(s.mesh.topology.index_map(2), 1)
    scalar = ufl.inner(s.u, s.u)
    return [
        ("InternalForce", di.InternalForce, s.form, None, TypeError, "UFL form"),
        ("InternalForce, another form", di.InternalForce, s.form, s.another, ValueError, "form differs"),
        ("InternalForce, rank", di.InternalForce, s.form, tensor, ValueError, "rank"),
        ("InternalForce, width", lambda w: di.InternalForce(s.form, width=w), 1, 4, ValueError, "width differs"),
        ("InternalForce.apply", s.force.apply, s.force.vector(), short, ValueError, "entries"),
        ("InternalForce.assemble", s.force.assemble, np.zeros_like(s.u.x.array),
         np.zeros(len(s.u.x.array), dtype=np.float32), TypeError, "float64"),
        ("Energy", di.Energy, scalar * ufl.dx, s.form, ValueError, "rank"),
        ("Tangent", di.Tangent, tensor, s.form, ValueError, "rank"),
        ("Tangent, bcs", lambda b: di.Tangent(tensor, bcs=b), [s.bc], [s.other_bc], ValueError, "another mesh"),
        ("PointValues", lambda p: di.PointValues(scalar, p), middle, [[5.0, 0.5]], ValueError, "outside"),
        ("PointValues, expression", lambda e: di.PointValues(e, middle), scalar, "u", TypeError, "expression"),
        ("lumped_mass", lambda m: di.lumped_mass(s.V, m), law(), law(E=2.0), ValueError, "material differs"),
        ("lumped_mass, space", lambda V: di.lumped_mass(V, law()), s.V, None, TypeError, "FunctionSpace"),
        ("lumped_mass, scheme", lambda x: di.lumped_mass(s.V, law(), x), "hrz", "foo", ValueError, "scheme"),
        ("compile_form", di.compile_form, s.form, "f", TypeError, "UFL form"),
        ("compile_form, another", di.compile_form, s.form, s.another, ValueError, "form differs"),
        ("compile_expression", lambda e: di.compile_expression(e, np.array(middle)), scalar, 2 * scalar, ValueError,
         "expression differs"),
        ("MaterialMap", lambda m: di.MaterialMap(s.cells, m), {1: law()}, {}, ValueError, "at least one"),
        ("MaterialMap, E", lambda E: di.MaterialMap(s.cells, {1: law(E)}), 1.0, 2.0, ValueError, "materials differs"),
        ("MaterialMap, tags", lambda t: di.MaterialMap(t, {1: law()}), s.cells, s.tags, ValueError, "tags of cells"),
        ("MaterialMap, no tags", lambda t: di.MaterialMap(t, {1: law()}), s.cells, None, TypeError, "MeshTags"),
        ("ContactPair, tags", lambda t: di.ContactPair(t, 3, 4), s.tags, None, TypeError, "MeshTags"),
        ("ContactPair, slave", lambda t: di.ContactPair(s.tags, t, 4), 3, "3", TypeError, "integer"),
        ("ContactPair, masters", lambda t: di.ContactPair(s.tags, 3, t), [4, 5], [4, 4], ValueError, "twice"),
        ("contact, function", s.touching.contact[0].function, "gap", "stress", ValueError, "no field"),
        ("ContactPair, friction", lambda f: di.ContactPair(s.tags, 3, 4, f), 0.0, -1.0, ValueError, "friction"),
        ("ContactPair, plane", lambda y: di.ContactPair(s.tags, 3, di.RigidPlane((0, y), (0, 1))), 0.0, 0.1, ValueError,
         "master differs"),
        ("Lagrange", di.Lagrange, s.pair, None, TypeError, "ContactPair"),
        ("Tie", di.Tie, di.ContactPair(s.tags, 3, 4), None, TypeError, "ContactPair"),
        ("Tie, directions", lambda d: di.Tie(di.ContactPair(s.tags, 3, 4), directions=d), "all", "al",
         ValueError, "directions"),
        ("Tie.adjust", lambda V: di.Tie(di.ContactPair(s.tags, 3, 4)).adjust(V), s.V, s.u, TypeError, "FunctionSpace"),
        ("Lagrange, basis", lambda b: di.Lagrange(s.pair, basis=b), "dual", "dua", ValueError, "basis"),
        ("Penalty", lambda p: di.Penalty(s.pair, penalty=p), "auto", NAN, ValueError, "penalty"),
        ("Penalty, degree", lambda n: di.Penalty(s.pair, quadrature_degree=n), 2, -1, ValueError, "quadrature_degree"),
        ("Kinematic", lambda n: di.Kinematic(s.pair, sweeps=n), 3, 0, ValueError, "sweeps"),
        ("GeneralContact, tags", lambda t: di.GeneralContact(s.tags, tags=t), [3], [], ValueError, "tags is empty"),
        ("GeneralContact, friction", lambda f: di.GeneralContact(s.tags, None, f), 0.0, -1.0, ValueError, "friction"),
        ("Traction, tag", lambda t: di.Traction(s.tags, t, (0, 1)), 3, None, TypeError, "integer"),
        ("Traction, vector", lambda f: di.Traction(s.tags, 3, f), (0, 1), (0, 2), ValueError, "vector differs"),
        ("FollowerPressure", lambda p: di.FollowerPressure(s.tags, 3, p), 1.0, None, TypeError, "number"),
        ("PrescribedMotion", lambda b: di.PrescribedMotion(b, math.sin), s.bc, 3, TypeError, "DirichletBC"),
        ("read_mesh", di.read_mesh, "a.msh", None, TypeError, "path"),
        ("read_mesh, ending", di.read_mesh, "a.msh", "a.stl", ValueError, "msh"),
        ("read_mesh, gdim", lambda n: di.read_mesh("a.msh", gdim=n), 2, 7, ValueError, "gdim"),
        ("check_mesh", di.check_mesh, s.mesh, None, TypeError, "mesh"),
        ("check_mesh, tags", lambda t: di.check_mesh(s.mesh, s.cells, required_cell_tags=t), [1], [1, 2], ValueError,
         "required_cell_tags"),
    ]  # fmt: skip


def calls_of_rolling_problems(s):
    """Rows as calls_of_problems, of a rail, the unit square, that flows straight."""
    along = di.Translation((1e-3, 0))

    def rolling(**changes):
        given = dict(material=law(), cell_tags=s.cells, motions={1: along}, bcs=[s.bc]) | changes
        return di.RollingProblem(fem.Function(s.V), **given)

    problem = rolling()
    rough = di.ContactPair(s.tags, 3, s.plane, friction=0.3)
    heavy, massless = law(), di.LinearElastic(1.0, 0.3, hypothesis="plane_strain")
    return [
        ("RollingProblem, material", lambda m: rolling(material=m), heavy, "steel", TypeError, "material"),
        ("RollingProblem, density", lambda m: rolling(material=m), heavy, massless, ValueError, "density"),
        ("RollingProblem, cell_tags", lambda t: rolling(cell_tags=t), s.cells, None, TypeError, "MeshTags"),
        ("RollingProblem, motions", lambda m: rolling(motions=m), {1: along}, along, TypeError, "dict"),
        ("RollingProblem, velocity", lambda x: rolling(motions={1: di.Translation((x, 0))}), 0.0, 0.1, ValueError,
         "motions differs"),
        ("RollingProblem, no motion", lambda m: rolling(motions=m), {1: along}, {}, ValueError, "empty"),
        ("RollingProblem, friction", lambda c: rolling(contact=c), [di.Penalty(s.pair)], [di.Penalty(rough)],
         ValueError, "Lagrange"),
        ("rolling solve, torque", lambda t: problem.solve(torque=t), None, 0.0, ValueError, "Spin"),
        ("rolling solve, steps", lambda n: problem.solve(steps=n), 1, 2, ValueError, "steps differs"),
        ("from_rolling, rolling", lambda r: di.ExplicitProblem.from_rolling(r), problem, 3.0, TypeError,
         "RollingProblem"),
        ("from_rolling, penalty", lambda p: di.ExplicitProblem.from_rolling(problem, penalty=p), "auto", 1.0,
         ValueError, "penalty differs"),
        ("rolling record, fields", lambda f: problem.record(s.folder, f), ["displacement"], ["stresses"], ValueError,
         "stresses"),
        ("frequencies, n", problem.frequencies, 1, 0, ValueError, "positive integer"),
        ("frequencies, another n", problem.frequencies, 1, 2, ValueError, "n differs"),
        ("frequencies, tolerance", lambda t: problem.frequencies(1, t), 1e-8, -1.0, ValueError, "tolerance is -1"),
    ]  # fmt: skip


def changed_load(s, factor):
    s.loaded.loads[0].constant.value[:] = [0.0, factor]
    s.loaded.solve()


def spoilt_start(s, value):
    s.static.u.x.array[0] = value
    try:
        s.static.solve()
    finally:
        s.static.u.x.array[:] = 0.0


def spoilt_amplitude(s, how, implicit=False):
    s.spoilt = how
    try:
        if implicit:
            s.driven_implicit.advance(s.driven_implicit.time + 1.0, 0.5, progress=False)
        else:
            s.driven.advance(s.driven.time + 1.0, progress=False)
    finally:
        s.spoilt = False


def outcome(call, argument):
    try:
        call(argument)
    except Exception as error:
        return type(error), str(error)
    return None, "nothing was raised"


def main():
    s, failed = Setting(), []
    table = calls_of_problems(s) + calls_of_implicit_problems(s) + calls_of_rolling_problems(s)
    table += calls_of_parts(s)
    for name, call, right, wrong, kind, word in table:
        faulthandler.dump_traceback_later(SECONDS, exit=True)
        if COMM.rank == 0:
            print(f"case: {name}", flush=True)
        found = COMM.allgather(outcome(call, wrong if COMM.rank == COMM.size - 1 else right))
        if len(set(found)) > 1 or found[0][0] is not kind or word not in found[0][1]:
            failed.append(f"FAILED {name}: {found}")
        faulthandler.cancel_dump_traceback_later()
    if COMM.rank == 0:
        print(*failed, f"{len(table)} cases, {len(failed)} failed", sep="\n", flush=True)


if __name__ == "__main__":
    main()
