# SPDX-License-Identifier: MIT
"""Pairs of surfaces that may come into contact, with checked input."""

import enum
import functools
from collections.abc import Callable, Sequence
from typing import Any, TypeVar, cast

import numpy as np
from dolfinx import mesh as dmesh
from dolfinx.fem import FunctionSpace
from dolfinx.mesh import Mesh, MeshTags
from mpi4py import MPI

from .. import _cpp
from ..common.arguments import LARGEST_DEGREE, integer, number
from ..common.collective import comm_of, guard
from ..common.fixed import Fixed
from ..common.types import FloatArray, IntArray
from ..interface.friction_law import FrictionLaw
from ..loads import _tag, check_tag, facet_tags_of
from .nodal_sum import NodalSum
from .rigid import _Rigid
from .rigid_body import RigidBody

_Result = TypeVar("_Result")
Smooth = bool | Callable[[FloatArray], Any]


class ContactStatus(enum.IntEnum):
    """Status of a contact point in a converged state; arrays of status contain these numbers."""

    open = 0
    stick = 1
    slip = 2


class ContactPair(Fixed):
    """Two surfaces that may touch: the slave carries the contact points, the master the facets they are projected on.

    Args:
        facet_tags: tags of facets.
        slave: tag of the slave surface; preferably the finer mesh and the softer body.
        master: tag of the master surface, a list of tags for several surfaces that one slave may touch, or a
            RigidPlane, RigidSphere, RigidCylinder, RigidSurface or RigidBody.
        friction: coefficient of friction, zero or more [1]; or a function that returns it in UFL, of `pressure`,
            `slip_rate`, `normal`, or a FrictionLaw.
        search_distance: largest distance at which slave and master are paired; None: from the sizes of the facets [L].
        remove_penetration: add the initial penetration of contact points to their gaps, so that they are closed at the
            start; for meshes that overlap although the bodies do not. The same as `adjust=0.0`.
        clearance: initial gap of the points that are adjusted, whatever the meshes say: of all points that have a
            master, or with `adjust` of those up to there. Negative: an overlap, as of a press fit [L].
        offset: thickness of layers that the meshes do not have, of shells and coatings: surfaces touch when they are
            this far apart. One number, or two, (slave, master); negative where material is missing [L].
        adjust: points whose initial gap is at most this, and all that overlap, are closed at the start, or have the
            gap `clearance`; None: no point [L].
        smooth: lay smooth surfaces of degree 2 through the nodes of linear facets (docs/contact.md, "Smooth
            surfaces"): True, False, or a function of positions, (3, n) -> (gdim, n), that gives normals out of the
            body, whose length does not count; where they are not a number, or off the facet by more than `crease`,
            the mean normals of the facets are used. Two of these, (slave, master): each side its own.
        crease: smooth surfaces keep edges sharp where facets meet at a larger angle [degrees].
        name: name for messages and files; None: from the tags, as "3 on 4", "3 on 4 and 5", "3 on RigidPlane". Of the
            contacts of a problem with the same name each gets a number behind it, "3 on 4 (2)".

    Raises:
        TypeError: a tag is not an integer, or the master is neither a tag, a list of tags nor a rigid obstacle; on all
            ranks.
        ValueError: slave and master are the same surface, a list of masters is empty or has a tag twice, friction is
            negative or not finite, a number that changes gaps is not finite or of the wrong sign, or crease is no angle
            above 0 up to 180; on all ranks. The tags are compared with the mesh when a problem is made.
    """

    facet_tags: MeshTags
    slave: int
    master: int | tuple[int, ...] | _Rigid
    rigid: bool
    friction: float | FrictionLaw
    search_distance: float | None
    remove_penetration: bool
    clearance: float | None
    offset: tuple[float, float]
    adjust: float | None
    smooth: tuple[Smooth, Smooth]
    crease: float
    name: str

    def __init__(
        self,
        facet_tags: MeshTags,
        slave: int,
        master: int | Sequence[int] | _Rigid,
        friction: float | Callable[..., Any] | FrictionLaw = 0.0,
        search_distance: float | None = None,
        remove_penetration: bool = False,
        name: str | None = None,
        smooth: Smooth | tuple[Smooth, Smooth] = False,
        crease: float = 30.0,
        clearance: float | None = None,
        offset: float | tuple[float, float] = 0.0,
        adjust: float | None = None,
    ) -> None:
        given: dict[str, Any] = dict(slave=slave, master=master, friction=friction, name=name)
        given |= dict(search_distance=search_distance, crease=crease, smooth=[_kind(s) for s in _sides(smooth)])
        given |= dict(clearance=clearance, offset=offset, adjust=adjust)
        with guard(comm_of(facet_tags), "ContactPair", **given, remove_penetration=bool(remove_penetration)):
            self._check(facet_tags, slave, master, friction, search_distance)
            self.smooth = _check_smooth(smooth)
            self.crease = number("crease", crease, 0.0, " [degrees]")
            if self.crease > 180.0:
                raise ValueError(f"crease is {self.crease}: it is an angle of up to 180 degrees")
            self._check_adjustment(clearance, offset, adjust, bool(remove_penetration))
        self.remove_penetration = bool(remove_penetration)
        met = " and ".join(map(str, self.masters)) if self.masters else type(self.master).__name__
        self.name = name or f"{self.slave} on {met}"

    def __repr__(self) -> str:
        more = "" if self.search_distance is None else f", search_distance {self.search_distance:g}"
        if self.remove_penetration:
            more += ", remove_penetration"
        if any(self.offset):
            more += f", offset {sum(self.offset):g}"
        for name, value in (("clearance", self.clearance), ("adjust", self.adjust)):
            more += "" if value is None else f", {name} {value:g}"
        sides = [side for side, kind in zip(("slave", "master"), self.smooth) if kind is not False]
        if sides:
            more += f", smooth {' and '.join(sides)}, crease {self.crease:g}"
        return f"ContactPair({self.name!r}: slave {self.slave}, master {self.master!r}, friction {self.friction}{more})"

    @property
    def has_friction(self) -> bool:
        """Whether there is friction: a law, or a coefficient above zero."""
        return isinstance(self.friction, FrictionLaw) or self.friction > 0.0

    def constant_friction(self, what: str) -> float:
        """The coefficient of friction of a method that takes a number alone [1].

        Args:
            what: the method.

        Raises:
            ValueError: the friction is a law.
        """
        if isinstance(self.friction, FrictionLaw):
            raise ValueError(
                f"{self.name}: {what} takes a number as its friction, not a law: take Lagrange or Kinematic, or "
                "Penalty(pair, law=...) with a law of the interface that has this friction"
            )
        return self.friction

    @property
    def masters(self) -> tuple[int, ...]:
        """Tags of the master surfaces; none if the master is rigid."""
        if isinstance(self.master, _Rigid):
            return ()
        return self.master if isinstance(self.master, tuple) else (self.master,)

    @property
    def rigid_master(self) -> _Rigid:
        """The master of a pair with `rigid`.

        Raises:
            TypeError: the master is a surface of the mesh.
        """
        if isinstance(self.master, _Rigid):
            return self.master
        raise TypeError(f"{self.name}: the master is a surface of the mesh, not a rigid obstacle")

    @property
    def rigid_body(self) -> RigidBody | None:
        """The master, if it is a body that moves by forces."""
        return self.master if isinstance(self.master, RigidBody) else None

    def refuse_rigid_body(self, what: str, problem: object = None) -> None:
        """Refuse a master that moves by forces, unless the problem moves it.

        Args:
            what: what does not move it.
            problem: the problem; None: none that does.

        Raises:
            ValueError: the master is a RigidBody.
        """
        if self.rigid_body is not None and not getattr(problem, "moves_rigid_bodies", False):
            raise ValueError(
                f"{self.name}: {what} does not move a RigidBody: take Penalty in an ExplicitProblem or a "
                "NewmarkProblem, or a StaticProblem, or give its surface as the master and displace it"
            )

    def refuse_angle(self, why: str) -> None:
        """Refuse a rigid master that turns as prescribed.

        Args:
            why: sentence that says what cannot turn it, and what can.

        Raises:
            ValueError: the master has an angle.
        """
        if self.rigid and self.rigid_body is None and self.rigid_master.angle is not None:
            raise ValueError(f"{self.name}: {why}")

    def _check(self, facet_tags: Any, slave: Any, master: Any, friction: Any, search_distance: Any) -> None:
        """Check the arguments of a pair, on this rank."""
        if isinstance(slave, (_Rigid, RigidBody)):
            raise TypeError(
                f"slave is a {type(slave).__name__}: what is rigid is the master, and the deformable surface the slave"
            )
        self.facet_tags, self.slave = facet_tags_of("ContactPair", facet_tags), _tag(slave)
        self.master = _checked_master(master)
        self.rigid = isinstance(master, _Rigid)
        if self.slave in self.masters:
            raise ValueError(
                f"slave and master have the same tag {self.slave}: tag two surfaces, or take GeneralContact, which "
                "knows self-contact, in an explicit problem"
            )
        self.friction = _checked_friction(friction)
        self.search_distance = None
        if search_distance is not None:
            self.search_distance = number("search_distance", search_distance, 0.0, " [L]")

    def _check_adjustment(self, clearance: Any, offset: Any, adjust: Any, remove: bool) -> None:
        """Check what changes gaps, on this rank."""
        self.clearance = None if clearance is None else number("clearance", clearance, unit=" [L]")
        both = offset if isinstance(offset, (tuple, list, np.ndarray)) else (offset, 0.0)
        if len(both) != 2:
            raise ValueError(f"offset has {len(both)} numbers: give one, or two, of slave and master")
        self.offset = number("offset", both[0], unit=" [L]"), number("offset", both[1], unit=" [L]")
        self.adjust = None if adjust is None else number("adjust", adjust, unit=" [L]")
        if self.adjust is not None and self.adjust < 0.0:
            raise ValueError(f"adjust is {self.adjust:g}: it is a gap up to which points are closed, zero or more")
        if remove and (adjust is not None or clearance is not None):
            raise ValueError("remove_penetration is adjust=0.0: give it alone, or adjust and clearance without it")

    @property
    def adjustment(self) -> _cpp.gap.GapAdjustment:
        """How gaps differ from the distances of the meshed surfaces (C++)."""
        adjust = 0.0 if self.remove_penetration else self.adjust
        return _cpp.gap.GapAdjustment(offset=sum(self.offset), clearance=self.clearance, adjust=adjust)

    def surfaces(self, V: FunctionSpace) -> tuple[_cpp.surface.Facets, _cpp.surface.Facets | None]:
        """Find this rank's slave and master facets. Collective.

        Args:
            V: displacement space.

        Returns:
            Facets of the slave, and facets of the master, None if the master is rigid.

        Raises:
            ValueError: a tag without facets, facets inside the body, or nodes that both surfaces share; on all ranks.
        """
        mesh = V.mesh
        tdim = mesh.topology.dim
        sides = [("slave", (self.slave,)), *([] if self.rigid else [("master", self.masters)])]
        for what, tags in sides:
            for tag in tags:
                check_tag(self.facet_tags, tag, mesh, f"{self.name}, {what}")
        mesh.topology.create_connectivity(tdim - 1, tdim)
        mesh.topology.create_connectivity(tdim, tdim - 1)
        exterior = dmesh.exterior_facet_indices(mesh.topology)
        made = []
        for _, tags in sides:
            facets = np.sort(np.concatenate([self.facet_tags.find(tag) for tag in tags]))
            inside = mesh.comm.allreduce(len(np.setdiff1d(facets, _boundary(mesh, exterior))), MPI.SUM)
            if inside:
                found = " and ".join(map(str, tags))
                raise ValueError(f"{self.name}: {inside} facets with the tag {found} lie inside the body")
            outside = np.intersect1d(facets, exterior)
            made.append(_guarded(mesh.comm, functools.partial(_surface, V, outside)))
        for side, normals in enumerate(self.smooth[: len(made)]):
            if normals is not False:
                made[side] = self._smoothed(V, made[side], normals)
        if self.rigid:
            return made[0], None
        slave, master = made
        self._check_shared_nodes(V, slave, master)
        return slave, master

    def _smoothed(self, V: FunctionSpace, facets: _cpp.surface.Facets, normals: Smooth) -> _cpp.surface.Facets:
        """Smooth surface through the nodes of facets. Collective."""
        given = _guarded(V.mesh.comm, functools.partial(_normals_at, normals, facets, self.name))
        crease = float(np.radians(self.crease))
        return _guarded(V.mesh.comm, lambda: _cpp.surface.make_smooth(V._cpp_object, facets, crease, given.ravel()))

    def _check_shared_nodes(self, V: FunctionSpace, slave: _cpp.surface.Facets, master: _cpp.surface.Facets) -> None:
        """Refuse surfaces that share nodes. Collective."""
        index_map, gdim = V.dofmap.index_map, V.mesh.geometry.dim
        total = NodalSum(index_map, 2)
        marks = np.zeros((index_map.size_local + index_map.num_ghosts, 2))
        marks[slave.nodes, 0] = marks[master.nodes, 1] = 1.0
        # A rank need not have facets of both surfaces at a shared node: the marks are added at the owner of the node.
        shared = np.flatnonzero(np.all(total(marks)[: index_map.size_local] > 0.0, axis=1))
        count = V.mesh.comm.allreduce(len(shared), MPI.SUM)
        if count:
            first = V.tabulate_dof_coordinates()[shared[:3], :gdim].round(12).tolist()
            some = [place for places in V.mesh.comm.allgather(first) for place in places][:3]
            raise ValueError(
                f"{self.name}: slave and master share {count} nodes, the first at {some}: a body cannot touch "
                "itself there; leave the common edge out of one of the tags, or mesh the bodies apart"
            )


def _checked_friction(friction: Any) -> float | FrictionLaw:
    """A coefficient of friction, or a law."""
    if isinstance(friction, FrictionLaw):
        return friction
    if callable(friction):
        return FrictionLaw(friction)
    found = number("friction", friction)
    if found < 0.0:
        raise ValueError(f"friction is {found}: a coefficient of friction is zero or positive")
    return found


def _checked_master(master: Any) -> int | tuple[int, ...] | _Rigid:
    """The argument `master`: a tag, several ones, or an obstacle; checked on this rank."""
    if isinstance(master, _Rigid):
        return master
    if isinstance(master, (int, float, np.integer, np.floating)):
        return _tag(master)
    if not isinstance(master, (list, tuple, np.ndarray)):
        hint = " (make an object of it)" if isinstance(master, type) else ""
        raise TypeError(f"master must be a tag, a list of tags or a rigid obstacle, found {master!r:.60}{hint}")
    if any(isinstance(one, _Rigid) for one in master):
        raise TypeError("a list of masters holds tags: make a pair with each rigid obstacle")
    tags = tuple(_tag(one) for one in master)
    if not tags:
        raise ValueError("the list of masters is empty: give the tags of the surfaces")
    if len(set(tags)) < len(tags):
        raise ValueError(f"the masters {list(tags)} have a tag twice: give each once")
    return tags if len(tags) > 1 else tags[0]


def _surface(V: FunctionSpace, facets: IntArray) -> _cpp.surface.Facets:
    return _cpp.surface.make_surface(V._cpp_object, np.ascontiguousarray(facets, dtype=np.int32))


def _sides(smooth: Any) -> tuple[Any, Any]:
    """What is asked for slave and master."""
    return tuple(smooth) if isinstance(smooth, (tuple, list)) and len(smooth) == 2 else (smooth, smooth)


def _kind(smooth: Any) -> str:
    """What all ranks must ask for alike: functions may differ in their addresses."""
    return "function" if callable(smooth) else repr(smooth)[:60]


def _check_smooth(smooth: Any) -> tuple[Smooth, Smooth]:
    """Check the argument `smooth`, on this rank."""
    sides = _sides(smooth)
    for side in sides:
        if not (callable(side) or isinstance(side, (bool, np.bool_))):
            raise TypeError(f"smooth is {side!r:.60}: True, False, a function of positions, or two of these")
    first, second = (side if callable(side) else bool(side) for side in sides)
    return first, second


def _normals_at(normals: Smooth, facets: _cpp.surface.Facets, name: str) -> FloatArray:
    """Normals of a function at the corners of facets, (facets, corners, gdim); none without a function."""
    if not callable(normals):
        return np.zeros(0)
    X = facets.X
    points = np.zeros((3, X.shape[0] * X.shape[1]))
    points[: facets.gdim] = X.reshape(-1, facets.gdim).T
    try:
        found = np.asarray(normals(points), dtype=float)
    except Exception as e:  # on this rank alone: the others must hear of it
        raise ValueError(f"{name}: the normals of the smooth surface raised {type(e).__name__}: {e}") from e
    if found.ndim != 2 or found.shape[0] not in (facets.gdim, 3) or found.shape[1] != points.shape[1]:
        raise ValueError(
            f"{name}: the normals of the smooth surface have shape {found.shape}, not ({facets.gdim}, "
            f"{points.shape[1]}) as the positions"
        )
    return np.ascontiguousarray(found[: facets.gdim].T).reshape(X.shape)


def _boundary(mesh: Mesh, exterior: IntArray) -> IntArray:
    """Exterior facets that this rank knows, and all ghost facets: only the owner knows whether a facet is exterior."""
    tdim = mesh.topology.dim
    ghosts = np.arange(
        mesh.topology.index_map(tdim - 1).size_local,
        mesh.topology.index_map(tdim - 1).size_local + mesh.topology.index_map(tdim - 1).num_ghosts,
        dtype=np.int32,
    )
    return np.concatenate([exterior, ghosts])


def _guarded(comm: MPI.Comm, function: Callable[[], _Result]) -> _Result:
    """Result of a function; if it raises on some ranks, ValueError on all ranks."""
    result, error = None, ""
    try:
        result = function()
    except (ValueError, RuntimeError) as e:
        error = str(e)
    errors = [e for e in comm.allgather(error) if e]
    if errors:
        raise ValueError(errors[0])
    return cast(_Result, result)


def check_pair(pair: Any) -> None:
    """Check the pair of a contact, on this rank.

    Args:
        pair: the argument.

    Raises:
        TypeError: `pair` is not a ContactPair.
    """
    if not isinstance(pair, ContactPair):
        raise TypeError(f"expected a ContactPair, found {type(pair).__name__}")


def check_quadrature_degree(degree: Any) -> int | None:
    """Check a degree of quadrature.

    Args:
        degree: the argument.

    Returns:
        The degree, or None if none was given.

    Raises:
        TypeError: `degree` is not a number.
        ValueError: there is no quadrature rule of this degree.
    """
    return None if degree is None else integer("quadrature_degree", degree, 1, LARGEST_DEGREE)
