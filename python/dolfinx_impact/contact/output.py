# SPDX-License-Identifier: MIT
"""Results of a contact: totals over the ranks, and fields."""

import functools
from typing import TYPE_CHECKING, Any

import numpy as np
from dolfinx import fem
from dolfinx.fem import Function, FunctionSpace
from mpi4py import MPI
from petsc4py import PETSc

from .. import _cpp
from ..common.collective import guard
from ..common.messages import INITIAL_PENETRATION
from ..common.types import AnyArray, ArrayLike, FloatArray, IntArray
from .pair import ContactPair
from .protocol import ContactProblem


#: Results that are arrays over the contact points, (n, gdim) and (n).
OF_VECTORS = ("points", "normal", "traction", "shear_traction", "slip")
OF_NUMBERS = ("gap", "pressure", "status", "weight")


#: Results that `function` returns and that problems record.
FIELDS = ("pressure", "gap", "traction", "shear_traction", "slip", "status")


def _three(value: ArrayLike) -> list[float]:
    """Components of a vector, filled up with zeros to three."""
    out = np.zeros(3)
    out[: np.size(value)] = value
    return list(out)


class ContactOutput:
    """Results of a contact; arrays are over this rank's contact points, totals over all ranks and the same on all.

    A derived class has these results as attributes or properties, the attributes `comm` and `initial`
    (InitialPenetration of C++; None in explicit problems), and the methods covered() and contact_forces(). A contact
    whose points are nodes has `nodes`; others override at_nodes(). What static problems ask of every contact is
    described in protocol.StaticContact; here are its answers where a contact has none of its own.

    Attributes:
        points: present positions, (n, gdim) [L].
        gap: gaps, (n), positive if open, infinite without master [L].
        normal: unit normals out of the master, (n, gdim) [1].
        pressure: contact pressure per reference area, (n) [F/L^2]; at_nodes(contact.pressure) is smoother in plots.
        traction: contact traction on the slave per reference area, (n, gdim) [F/L^2].
        slip: tangential displacement of slave relative to master, accumulated in contact, (n, gdim) [L].
        status: ContactStatus numbers, (n).
        weight: area of each point, a length in 2D, (n) [L^2].
    """

    if TYPE_CHECKING:  # members of derived classes, attributes or properties
        comm: MPI.Comm
        problem: Any
        pair: ContactPair
        gdim: int

        @property
        def initial(self) -> Any: ...
        @property
        def nodes(self) -> IntArray: ...
        @property
        def normal(self) -> FloatArray: ...
        @property
        def points(self) -> FloatArray: ...
        @property
        def traction(self) -> FloatArray: ...
        @property
        def slip(self) -> FloatArray: ...
        @property
        def status(self) -> IntArray: ...
        @property
        def weight(self) -> FloatArray: ...

    def __repr__(self) -> str:
        known = "not solved yet"
        if self.force is not None:  # a total: the same on all ranks, and known without communication
            known = f"force on the slave ({', '.join(f'{value:.6g}' for value in self.force)})"
        n = len(self.weight)
        arrays = f"{', '.join(OF_VECTORS)} ({n}, {self.gdim}); {', '.join(OF_NUMBERS)} ({n},)"
        return f"{type(self).__name__}({self.pair!r}, {n} points on this rank, {known}; arrays {arrays})"

    @property
    def fault(self) -> str:
        return ""

    @functools.cached_property
    def _totals(self) -> _cpp.enforcement.ContactTotals:
        """Totals on the C++ side."""
        return _cpp.enforcement.ContactTotals()

    @property
    def force(self) -> FloatArray | None:
        """Total contact force on the slave, (gdim), on the master it is the opposite; None before a solution [F]."""
        return np.array(self._totals.force[: self.gdim]) if self._totals.known else None

    @force.setter
    def force(self, value: ArrayLike) -> None:
        self._totals.force = _three(value)
        self._totals.known = True

    @property
    def moment(self) -> FloatArray | None:
        """Moment of these forces about the origin, (1) in the plane, (3) in space; None before a solution [F L]."""
        return np.array(self._totals.moment[: 1 if self.gdim == 2 else 3]) if self._totals.known else None

    @moment.setter
    def moment(self, value: ArrayLike) -> None:
        self._totals.moment = _three(value)

    @property
    def area(self) -> float:
        """Area in contact (2D: length), see covered() [L^2]."""
        return float(self._totals.area)

    @area.setter
    def area(self, value: float) -> None:
        self._totals.area = value

    @property
    def dissipated(self) -> float:
        """Work of friction so far: in each increment, tractions at its end times its slip [F L]."""
        return float(self._totals.dissipated)

    @dissipated.setter
    def dissipated(self, value: float) -> None:
        self._totals.dissipated = value

    @property
    def initial_penetration(self) -> float:
        """Largest penetration in the reference configuration on all ranks, removed or not [L].

        Raises:
            AttributeError: the contact is one of an explicit problem whose pair adjusts no gaps.
        """
        if self.initial is None:
            raise AttributeError(
                f"{type(self).__name__} has no initial penetration: it is known in static problems, and of pairs that "
                "adjust gaps"
            )
        return float(self.initial.depth)

    @property
    def adjustment(self) -> str:
        """What was adjusted of the initial gaps, how many points, by how much at most and where; and what penetrates.
        Empty if there is nothing to tell."""
        return "" if self.initial is None else str(self.initial.warning)

    def _tell_of_penetration(self) -> None:
        """Log penetrations in the reference configuration and what was adjusted, on rank 0."""
        if self.adjustment and self.comm.rank == 0:
            INITIAL_PENETRATION.warning(self.adjustment)

    @property
    def shear_traction(self) -> FloatArray:
        """Part of the traction along the master's surface, friction, (n, gdim) [F/L^2]."""
        traction, normal = self.traction, self.normal
        return traction - np.sum(traction * normal, axis=1)[:, None] * normal

    def refresh(self) -> None:
        """Bring the results to the present state, where they are not kept there. Collective."""

    def covered(self) -> FloatArray:
        """Part of each point's area that is in contact. Collective.

        Returns:
            Fractions, (n) [1].
        """
        raise NotImplementedError

    def contact_forces(self) -> FloatArray:
        raise NotImplementedError

    def largest_violation(self) -> str:
        return ""

    def forget(self) -> None:
        """Nothing: the contact keeps nothing of that kind."""

    def mesh_advice(self) -> str:
        return ""

    def check_parameters(self) -> None:
        """Nothing: all fit."""

    def add_residual(self, b: PETSc.Vec) -> None:
        b.array[:] -= self.contact_forces()

    def prescribed_overlap(self) -> str:
        return ""

    def passed_through(self) -> str:
        return ""

    def close_nearest(self) -> bool:
        return False

    def update_totals(self) -> None:
        """Sum up force, moment, area and work of friction of a converged increment. Collective."""
        x, traction, slip = (np.ascontiguousarray(a, dtype=float) for a in (self.points, self.traction, self.slip))
        status, covered = np.asarray(self.status, dtype=np.int8), np.asarray(self.covered(), dtype=float)
        self._totals.update(self.comm, x, traction, slip, status, self.weight, covered)

    def at_nodes(self, values: ArrayLike) -> tuple[IntArray, AnyArray]:
        """Values of the contact points by nodes. Collective.

        Args:
            values: an array over the contact points, (n) or (n, gdim).

        Returns:
            Numbers of nodes on this rank, (m), and their values, (m) or (m, gdim).
        """
        return self.nodes, np.asarray(values, dtype=float)

    def field(self, problem: ContactProblem, values: ArrayLike, name: str) -> Function:
        """Make a function of an array over the contact points, for ParaView. Collective.

        The function is on the mesh of the displacement and zero at other nodes. Values at quadrature points (penalty)
        become means at the slave's nodes; see QuadraturePenalty.at_nodes.

        Args:
            problem: problem of the contact.
            values: one of the arrays of results, (n) or (n, gdim).
            name: name of the function.

        Returns:
            Function of the degree of the displacement.

        Raises:
            ValueError: `values` have another number of rows than the contact has points; on all ranks.
        """
        with guard(self.comm, "field", name=name):
            if len(np.atleast_1d(values)) != len(self.points):
                raise ValueError(
                    f"the array has {len(np.atleast_1d(values))} rows, the contact {len(self.points)} points"
                )
        f = self._new_function(problem.space, np.shape(values)[1:], name)
        self._fill(f, values, 0.0)
        return f

    @property
    def fields(self) -> tuple[str, ...]:
        """Names of the results that `function` returns."""
        return FIELDS

    def function(self, name: str, elsewhere: float | None = None, out: Function | None = None) -> Function:
        """One of the results in the present state as a function on the mesh. Collective.

        It is of the degree of the displacement, has the values of the slave's nodes (means of those at quadrature
        points, see at_nodes) and `elsewhere` at other nodes; so have slave nodes without a value, as a gap without a
        master has none.

        Args:
            name: pressure, gap, traction, shear_traction, slip or status, in rolling with friction also slip_velocity.
            elsewhere: value at other nodes; None: zero, of a gap a number that is none, as an open place is not one of
                gap zero.
            out: function that an earlier call has returned, which is set anew; None: a new one.

        Returns:
            The function: numbers, or vectors of gdim components, in the unit of the result.

        Raises:
            ValueError: another name, or `out` is not a function of this result; on all ranks.
        """
        with guard(self.comm, "function", name=name, elsewhere=elsewhere) as ranks:
            if name not in self.fields:
                raise ValueError(f"{self.pair.name} has no field {name!r:.60}: use one of {', '.join(self.fields)}")
            shape: tuple[int, ...] = () if name in (*OF_NUMBERS, "status") else (self.gdim,)
            if out is not None and (out.function_space.mesh is not self._space.mesh or out.ufl_shape != shape):
                raise ValueError(f"out is no function that {name!r} of {self.pair.name} was returned in")
            ranks.same(new=out is None)
        self.refresh()
        f = self._new_function(self._space, shape, name) if out is None else out
        if elsewhere is None:
            elsewhere = np.nan if name == "gap" else 0.0
        self._fill(f, getattr(self, name), float(elsewhere))
        return f

    @property
    def _space(self) -> FunctionSpace:
        """Displacement space."""
        space: FunctionSpace = self.problem.space
        return space

    @staticmethod
    def _new_function(V: FunctionSpace, shape: tuple[int, ...], name: str) -> Function:
        return Function(fem.functionspace(V.mesh, ("Lagrange", V.element.basix_element.degree, shape)), name=name)

    def _fill(self, f: Function, values: ArrayLike, elsewhere: float) -> None:
        """Set a function to values of the contact points. Collective."""
        nodes, found = self.at_nodes(values)
        f.x.array[:] = elsewhere
        flat = f.x.array.reshape(-1, *found.shape[1:])
        flat[nodes] = np.where(np.isfinite(found), found, elsewhere)
        f.x.scatter_forward()
