# SPDX-License-Identifier: MIT
"""Bodies with internal variables, on the ranks of COMM_WORLD; see on_ranks.py."""

import shutil
import warnings

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI
from on_ranks import on_rank_0
from own_laws import LargestOfCell, Limited
from shared_folder import shared_folder
from over_ranks import largest

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
E, NU, Y = 2.0, 0.3, 0.01
SAME = 1e-10  # round-off of sums in another order, times the condition of some hundred unknowns and of yielding points


def square(comm=COMM, n=6, kind="quadrilateral"):
    return mesh.create_unit_square(comm, n, n, getattr(mesh.CellType, kind))


def space(domain, degree=1):
    return fem.functionspace(domain, ("Lagrange", degree, (domain.geometry.dim,)))


def steel(hardening=0.1, **options):
    return di.J2Plasticity(E, NU, 1.0, Y, hardening=hardening, hypothesis="plane_strain", **options)


def three_materials(domain):
    """Elastic at the left, and two parts that yield."""
    tdim = domain.topology.dim
    cells = domain.topology.index_map(tdim)
    cells = np.arange(cells.size_local + cells.num_ghosts, dtype=np.int32)
    x = mesh.compute_midpoints(domain, tdim, cells)
    tags = mesh.meshtags(
        domain, tdim, cells, (1 + (x[:, 0] > 0.34) + (x[:, 1] > 0.5) * (x[:, 0] > 0.34)).astype(np.int32)
    )
    return di.MaterialMap(
        tags,
        {
            1: di.LinearElastic(E, NU, 1.0, "plane_strain"),
            2: steel(di.Voce(1.5 * Y, 40.0, 0.2 * Y)),
            3: steel(0.0, kinematic=di.ArmstrongFrederick(0.6, 30.0)),
        },
    )


def ends(V, displacement):
    """Supports: the left side is held, the right one has a displacement (a fem.Constant)."""
    left, right = (fem.locate_dofs_geometrical(V, lambda x, a=a: np.isclose(x[0], a)) for a in (0.0, 1.0))
    return [fem.dirichletbc(np.zeros(2), left, V), fem.dirichletbc(displacement, right, V)]


def pulled(comm=COMM, material=None, kind="quadrilateral", n=6, degree=1):
    """Static problem of a square, its displacement and the displacement of its right side."""
    domain = square(comm, n, kind)
    V = space(domain, degree)
    u, pull = fem.Function(V, name="u"), fem.Constant(domain, np.zeros(2))
    return di.StaticProblem(u, material or three_materials(domain), bcs=ends(V, pull)), u, pull


def thrown(comm=COMM, material=None, n=6, speed=0.05, domain=None):
    """Explicit problem of a square that is held at the left and flies away at the right."""
    domain = square(comm, n) if domain is None else domain
    V = space(domain)
    u, v = fem.Function(V, name="u"), fem.Function(V, name="v")
    v.interpolate(lambda x: speed * np.vstack([x[0], 0.5 * np.sin(3 * x[1]) * x[0]]))
    left = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[0], 0.0))
    hold = fem.dirichletbc(np.zeros(2), left, V)
    return di.ExplicitProblem(u, material or three_materials(domain), velocity=v, bcs=[hold])


def everywhere(f):
    """Values at all nodes on all ranks, in the order of the nodes' places."""
    V = f.function_space
    comm, n, bs = V.mesh.comm, V.dofmap.index_map.size_local, V.dofmap.bs
    x = np.vstack(comm.allgather(V.tabulate_dof_coordinates()[:n]))
    values = np.vstack(comm.allgather(f.x.array.reshape(-1, bs)[:n].copy()))
    return values[np.lexsort(np.round(x, 9).T)]


def all_points(comm, values):
    """Values at all points of all ranks, sorted."""
    return np.sort(np.concatenate(comm.allgather(np.ravel(values))))


def assert_same(found, expected):
    scale = np.abs(expected).max()
    assert scale > 0.0 and np.abs(found - expected).max() <= SAME * scale, np.abs(found - expected).max() / scale


def raises(error, words, work):
    """The same error on all ranks."""
    with pytest.raises(error, match=words) as caught:
        work()
    assert len(set(COMM.allgather(str(caught.value)))) == 1
    return str(caught.value)


# --- the same on any number of ranks ----------------------------------------------------------------------------------


def static_results(comm):
    problem, u, pull = pulled(comm)
    parts = []
    for x in (0.01, 0.03, 0.02):  # beyond yield, and partly back
        pull.value[:] = (x, 0.5 * x)
        problem.solve(rtol=1e-12)
        parts += [everywhere(u), everywhere(problem.reactions())]
        parts += [all_points(comm, problem.history[name].values) for name in (*problem.history, "stress", "von_mises")]
        parts.append(everywhere(problem.history["von_mises"].at_nodes()))
    return parts


def check_static_materials_are_those_of_one_rank():
    expected = on_rank_0(COMM, lambda: static_results(MPI.COMM_SELF))
    found = static_results(COMM)
    for a, b in zip(found, expected):
        assert_same(a, b)


def explicit_results(comm):
    problem = thrown(comm)
    problem.advance(200 * 0.9 * problem.stable_step(), progress=False)
    assert problem.energy["plastic"] > 0.1 * problem.energy["kinetic"]
    parts = [everywhere(problem.u), everywhere(problem.velocity)]
    parts += [all_points(comm, problem.history[name].values) for name in (*problem.history, "stress")]
    energies = np.array([problem.energy[name] for name in ("kinetic", "internal", "plastic")])
    return [*parts, energies]


def check_explicit_materials_are_those_of_one_rank():
    expected = on_rank_0(COMM, lambda: explicit_results(MPI.COMM_SELF))
    for a, b in zip(explicit_results(COMM), expected):
        assert_same(a, b)


# --- checkpoints ------------------------------------------------------------------------------------------------------


def state(problem):
    parts = [f.x.array for f in (problem.u, problem.velocity, problem.acceleration)]
    return np.concatenate([*parts, *(problem.history[name].values.ravel() for name in problem.history)])


def check_a_restart_in_the_middle_of_yielding_is_bit_exact():
    """On the same ranks and mesh: state, plastic strain and energies go on as if nothing had been."""
    with shared_folder() as path:
        domain = square()
        whole, kept = thrown(domain=domain), {}
        end = 200 * 0.9 * whole.stable_step()

        def keep(problem):
            if problem.step == 77:
                problem.save(path / "middle.h5")
                kept["state"], kept["plastic"] = state(problem), problem.energy["plastic"]

        whole.advance(end, callback=keep, progress=False)
        assert 0.0 < kept["plastic"] < 0.99 * whole.energy["plastic"], "it yields before and after"
        again = thrown(domain=domain)
        again.restore(path / "middle.h5")
        np.testing.assert_array_equal(state(again), kept["state"])
        again.advance(end, progress=False)
        np.testing.assert_array_equal(state(again), state(whole))
        assert abs(again.energy["plastic"] / whole.energy["plastic"] - 1) < 1e-12


def check_a_restart_from_one_rank_goes_on_to_round_off():
    with shared_folder() as path:

        def alone():
            problem = thrown(MPI.COMM_SELF)
            dt = 0.9 * problem.stable_step()
            problem.advance(77 * dt, progress=False)
            problem.save(path / "one.h5")
            problem.advance(200 * dt, progress=False)
            return dt, everywhere(problem.u), all_points(MPI.COMM_SELF, problem.history["plastic_strain"].values)

        dt, u, plastic = on_rank_0(COMM, alone)
        problem = thrown()
        problem.restore(path / "one.h5")
        problem.advance(200 * dt, progress=False)
        assert_same(everywhere(problem.u), u)
        assert_same(all_points(COMM, problem.history["plastic_strain"].values), plastic)


def check_a_law_of_one_s_own_is_evaluated_once_in_a_step():
    """A history that counts: also in a run that was restored, and in one that was saved on the way."""
    with shared_folder() as path:
        domain, law = square(n=3), Limited(0.5)
        whole = thrown(domain=domain, material=law)
        dt = 0.9 * whole.stable_step()
        for until in (5, 12):
            whole.advance(until * dt, dt=dt, progress=False)
            assert np.all(counts(whole) == whole.step + 1), "and once at the start"
            if until == 5:
                whole.save(path / "five.h5")
        again = thrown(domain=domain, material=law)
        again.restore(path / "five.h5")
        again.advance(12 * dt, dt=dt, progress=False)
        np.testing.assert_array_equal(state(again), state(whole))


def check_a_checkpoint_of_another_law_or_mesh_is_refused():
    with shared_folder() as path:
        problem = thrown(material=steel())
        problem.advance(20 * 0.9 * problem.stable_step(), progress=False)
        problem.save(path / "here.h5")
        for other in (steel(0.2), steel(0.1, kinematic=0.1), steel(finite_strain=True), steel(average=False)):
            stranger = thrown(material=other)
            before = state(stranger)
            raises(ValueError, "another problem.*material", lambda p=stranger: p.restore(path / "here.h5"))
            np.testing.assert_array_equal(state(stranger), before)
        stranger = thrown(material=steel(), n=5)
        raises(ValueError, "another problem", lambda: stranger.restore(path / "here.h5"))
        elastic = thrown(material=di.LinearElastic(E, NU, 1.0, "plane_strain"))
        raises(ValueError, "another problem.*material", lambda: elastic.restore(path / "here.h5"))


# --- trials and cut-backs ---------------------------------------------------------------------------------------------


def check_trials_do_not_change_the_history():
    """Reactions at any displacement, and an increment that fails, leave the history as it was."""
    problem, u, pull = pulled(material=steel())
    pull.value[0] = 0.03
    problem.solve()
    names = list(problem.history)
    before, here = [problem.history[name].values.copy() for name in names], u.x.array.copy()
    assert COMM.allreduce(float(before[0].max(initial=0.0)), MPI.MAX) > 0.01
    u.x.array[:] *= 3.0
    problem.reactions()
    u.x.array[:] = here
    for a, name in zip(before, names):
        np.testing.assert_array_equal(problem.history[name].values, a)
    pull.value[0] = 0.3
    raises(RuntimeError, "did not converge", lambda: problem.solve(max_iterations=1))
    for a, name in zip(before, names):
        np.testing.assert_array_equal(problem.history[name].values, a)
    np.testing.assert_array_equal(u.x.array, here)
    problem.solve(steps=4)


def counts(problem):
    return all_points(COMM, problem.history["count"].values)


def check_cut_backs_start_from_the_committed_history():
    """A step of three limits is cut into four: four commits, the stretch of the end."""
    problem, u, pull = pulled(material=Limited(0.01, of_step=True), degree=1)
    pull.value[0] = 0.02
    report = problem.solve(cut_backs=5)
    assert report.cut_backs > 0
    assert np.all(counts(problem) == len(report.fractions)), "one commit for each increment that converged"
    stretch = all_points(COMM, problem.history["stretch"].values)
    assert abs(stretch.mean() - 0.02) < 1e-12  # the mean stretch between the ends is that of the supports


def check_statics_name_the_point_that_has_no_solution():
    problem, u, pull = pulled(material=Limited(0.01))
    pull.value[0] = 0.004
    problem.solve()
    here = u.x.array.copy()
    pull.value[0] = 0.04
    words = r"local equations.*not solved at \d+ points.*point \d+ of cell \d+ .*residual.*unknowns"
    text = raises(RuntimeError, words, problem.solve)
    assert "smaller parts" in text
    np.testing.assert_array_equal(u.x.array, here)
    assert np.all(counts(problem) == 1)
    raises(RuntimeError, words + ".*reached", lambda: problem.solve(steps=4, cut_backs=3))
    assert largest(u.x.array) > 0.004, "the last converged increment"
    stretch = all_points(COMM, problem.history["stretch"].values)
    assert stretch.max() < 0.01 and np.all(counts(problem) > 1)


def check_explicit_runs_go_back_to_the_last_good_state():
    """The history is that of the displacement there, and the run can go on."""
    problem = thrown(material=Limited(0.05), speed=0.2)
    kept = {}

    def keep(p):
        kept[p.step] = (p.u.x.array.copy(), p.history["stretch"].values.copy())

    words = r"local equations.*point \d+ of cell \d+.*back at the time.*smaller step, or check the law"
    raises(RuntimeError, words, lambda: problem.advance(3.0, callback=keep, progress=False))
    assert problem.step in kept and max(kept) > problem.step
    u, stretch = kept[problem.step]
    np.testing.assert_array_equal(problem.u.x.array, u)
    np.testing.assert_allclose(problem.history["stretch"].values, stretch, rtol=0, atol=1e-15)
    problem.advance(problem.time + 2 * problem.stable_step(), progress=False)


# --- bad input --------------------------------------------------------------------------------------------------------


def check_cells_without_a_law_are_refused():
    domain = square()
    n = domain.topology.index_map(2).size_local
    owned = np.arange(n, dtype=np.int32)
    x = mesh.compute_midpoints(domain, 2, owned)
    some = mesh.meshtags(domain, 2, owned, np.where(x[:, 0] < 0.5, 1, 2).astype(np.int32))
    raises(ValueError, r"tags \[2\], which have no material", lambda: di.MaterialMap(some, {1: steel()}))
    left = owned[x[:, 0] < 0.5]
    part = mesh.meshtags(domain, 2, left, np.ones(len(left), dtype=np.int32))
    raises(ValueError, "cells carry no tag", lambda: di.MaterialMap(part, {1: steel()}))


def warnings_of(work, words="degree 1 lock"):
    """Texts of the warnings with some words, by default those about locking, of all ranks."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        work()
    here = [str(w.message) for w in caught if issubclass(w.category, UserWarning) and words in str(w.message)]
    return [text for texts in COMM.allgather(here) for text in texts]


def check_softening_is_warned_of():
    """Once for a problem and material, on rank 0, with the element length of the material's cells."""
    soft = steel(di.Table([0.0, 0.1], [Y, 0.5 * Y]))
    for work in (lambda: pulled(material=soft), lambda: thrown(material=soft)):
        (text,) = warnings_of(work, "softens")
        for words in ("up to -0.05 [F", "is 0.2357 to 0.2357 [L]", "length 1 [L]", "below 0.025 [L]", "on the mesh"):
            assert words in text, text
    domain = square()
    three = three_materials(domain)
    three = di.MaterialMap(three.cell_tags, {**three.materials, 2: steel(-0.05)})
    u = fem.Function(space(domain), name="u")
    (text,) = warnings_of(lambda: di.StaticProblem(u, three), "softens")
    assert "A body of the length 0.6667 [L]" in text and "below 0.01667 [L]" in text
    assert not warnings_of(lambda: pulled(), "softens")


def check_a_table_that_softens_is_followed():
    """A bar that yields everywhere at once: its stress is that of the table, also beyond its end."""
    domain = square(n=1)
    V = space(domain)
    u = fem.Function(V, name="u")
    sides = [
        fem.locate_dofs_geometrical((V.sub(a), V.sub(a).collapse()[0]), lambda x, a=a: np.isclose(x[a], 0.0))[0]
        for a in (0, 1)
    ]
    right = fem.locate_dofs_geometrical((V.sub(0), V.sub(0).collapse()[0]), lambda x: np.isclose(x[0], 1.0))[0]
    zero, one = fem.Constant(domain, 0.0), fem.Constant(domain, 0.0)
    bcs = [fem.dirichletbc(zero, d, V.sub(a)) for a, d in enumerate(sides)] + [fem.dirichletbc(one, right, V.sub(0))]
    sheet = di.J2Plasticity(E, NU, None, Y, hardening=di.Table([0.0, 0.1], [Y, 0.5 * Y]), hypothesis="plane_stress")
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "J2Plasticity softens")
        problem = di.StaticProblem(u, sheet, bcs=bcs)
    for plastic in (0.04, 0.08, 0.2):
        stress = Y * max(0.5, 1.0 - 5.0 * plastic)
        one.value = plastic + stress / E
        problem.solve(rtol=1e-12)
        found = all_points(COMM, problem.history["von_mises"].values)
        assert np.abs(found / stress - 1.0).max() < SAME
        assert np.abs(all_points(COMM, problem.history["plastic_strain"].values) - plastic).max() < SAME


def check_a_yield_stress_that_has_fallen_to_zero_is_an_error():
    """Y - 0.2 a is zero at a = 0.05: statics cut back and give up, explicit runs stop."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        problem, _, pull = pulled(material=steel(-0.2), n=2)
        pull.value[:] = (0.01, 0.0)
        problem.solve(rtol=1e-10)
        assert 0.0 < all_points(COMM, problem.history["plastic_strain"].values).max() < 0.05
        pull.value[:] = (0.3, 0.0)
        with pytest.raises(RuntimeError, match="local equations|converge"):
            problem.solve(rtol=1e-10)
        run = thrown(material=steel(-0.2), n=2, speed=1.0)
        with pytest.raises(RuntimeError, match="local equations"):
            run.advance(5.0, progress=False)


def check_a_law_with_the_maximum_of_a_cell():
    """The largest value of the points of a cell at all of them; of static problems in the history only."""
    run = thrown(material=LargestOfCell(0.5), n=3)
    plain = thrown(material=LargestOfCell(), n=3)
    problem, _, pull = pulled(material=LargestOfCell(), n=3)
    pull.value[:] = (0.02, 0.05)
    problem.solve(rtol=1e-12)
    run.advance(0.2, progress=False)
    plain.advance(0.2, progress=False)
    for body in (problem, run):
        point, cell = (body.history[name].values.reshape(-1, 4) for name in ("of_point", "of_cell"))
        if body is problem:
            assert np.abs(cell - point.max(axis=1, keepdims=True)).max(initial=0.0) < SAME
        assert np.all(cell >= point) and np.all(np.ptp(cell, axis=1) == 0.0)
        assert COMM.allreduce(np.ptp(point, axis=1).max(initial=0.0), op=MPI.MAX) > 1e-4
    change = np.abs(everywhere(run.u) - everywhere(plain.u)).max()
    assert change > 1e-6
    raises(ValueError, "maximum over a cell, which has no derivative", lambda: pulled(material=LargestOfCell(0.5), n=3))


def check_cells_that_lock_are_warned_of():
    """Once for a problem, on rank 0; not of degree 2, quadrilaterals, plane stress or elastic bodies."""
    found = warnings_of(lambda: pulled(kind="triangle", n=3))
    assert len(found) == 1 and "triangles of degree 2, or quadrilaterals" in found[0]
    assert len(warnings_of(lambda: thrown(domain=square(n=3, kind="triangle")))) == 1
    cube = mesh.create_unit_cube(COMM, 2, 2, 2)
    u = fem.Function(space(cube), name="u")
    found = warnings_of(lambda: di.StaticProblem(u, di.J2Plasticity(E, NU, yield_stress=Y)))
    assert len(found) == 1 and "tetrahedra of degree 2, or hexahedra" in found[0]
    sheet = di.J2Plasticity(E, NU, 1.0, Y, hypothesis="plane_stress")
    for work in (
        lambda: pulled(),
        lambda: pulled(kind="triangle", degree=2, n=3, material=steel()),
        lambda: pulled(kind="triangle", n=3, material=sheet),
        lambda: pulled(kind="triangle", n=3, material=di.LinearElastic(E, NU, hypothesis="plane_strain")),
    ):
        assert warnings_of(work) == []


# --- output -----------------------------------------------------------------------------------------------------------


def check_a_series_of_materials_that_is_removed():
    """The run warns and goes on; closing the recorder is an error."""
    with shared_folder() as path:
        problem = thrown(domain=square())
        dt = 0.5 * problem.stable_step()
        recorder = problem.record(path / "run", fields=["displacement", "von_mises"], every=5)
        problem.advance(10 * dt, dt=dt, progress=False)
        COMM.barrier()
        if COMM.rank == 0:
            shutil.rmtree(path / "run" / "materials.bp")
        COMM.barrier()
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            problem.advance(20 * dt, dt=dt, progress=False)
        assert problem.step == 20 and len(told) == (COMM.rank == 0)
        assert all("materials.bp is gone" in str(t.message) for t in told)
        raises(RuntimeError, "materials.bp is gone", recorder.close)


def check_recorders_write_internal_variables():
    """A series of averages at the vertices; the run is the same with and without; unknown names are refused."""
    with shared_folder() as path:
        domain = square()
        problem, alone = thrown(domain=domain), thrown(domain=domain)
        end = 100 * 0.9 * problem.stable_step()
        fields = ["displacement", "plastic_strain", "back_stress", "stress", "von_mises"]
        recorder = problem.record(path / "run", fields=fields, every=50)
        problem.advance(end, progress=False)
        _, materials = recorder.fields.sources
        found = {f.name: f.x.array.copy() for f in materials.functions}
        names = ["plastic_strain", *(f"back_stress_{k}" for k in range(3))]
        assert list(found) == [*names, "stress_xx", "stress_yy", "stress_zz", "stress_xy", "von_mises"]
        if problem.step % 50 == 0:
            for name in ("plastic_strain", "von_mises"):
                np.testing.assert_array_equal(found[name], problem.history[name].at_nodes().x.array)
        assert COMM.allreduce(float(found["plastic_strain"].max(initial=0.0)), MPI.MAX) > 1e-3
        recorder.close()
        COMM.barrier()
        assert (path / "run" / "fields.bp").exists() and (path / "run" / "materials.bp").exists()
        data = b"".join(p.read_bytes() for p in (path / "run" / "materials.bp").iterdir() if p.is_file())
        assert all(name.encode() in data for name in found)
        alone.advance(end, progress=False)
        np.testing.assert_array_equal(state(problem), state(alone))
        only = alone.record(path / "only", fields=["von_mises"])
        only.close()
        assert not (path / "only" / "fields.bp").exists()
        words = r"\['back_strain'\] are unknown.*plastic_strain.*stress, von_mises"
        raises(ValueError, words, lambda: alone.record(path / "no", fields=["back_strain"]))
        elastic = thrown(material=di.LinearElastic(E, NU, 1.0, "plane_strain"))
        raises(
            ValueError, r"\['back_stress'\] are unknown", lambda: elastic.record(path / "no", fields=["back_stress"])
        )
