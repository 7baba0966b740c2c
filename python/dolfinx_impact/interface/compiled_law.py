# SPDX-License-Identifier: MIT
"""What laws of contacts have in common: parameters, fields, and a kernel for each dimension of space."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any, Generic, TypeVar

from dolfinx.fem import Function, FunctionSpace
from mpi4py import MPI

from .. import _cpp
from ..assembly import jit
from ..common.arguments import number
from ..common.fixed import Fixed
from ..forms.compiler.frontend import form_signature

Made = TypeVar("Made", _cpp.enforcement.InterfaceLaw, _cpp.enforcement.FrictionLaw)
Part = Callable[..., Any]


class CompiledLaw(Fixed, Generic[Made]):
    """A law in UFL whose kernel is compiled when a contact asks for it.

    Args:
        fields: functions on the mesh by name, scalar and of the degree of the displacement.
        parameters: numbers by name.
        name: name for messages.

    Raises:
        TypeError: a field is no scalar function, a parameter is no number.
    """

    def __init__(
        self, fields: Mapping[str, Function] | None, parameters: Mapping[str, float] | None, name: str
    ) -> None:
        self.name = name
        self.fields = dict(fields or {})
        for key, function in self.fields.items():
            if not isinstance(function, Function) or function.function_space.dofmap.bs > 1:
                raise TypeError(f"field {key!r} of a law must be a scalar fem.Function")
        self._parameters = {key: number(f"parameter {key!r}", value) for key, value in (parameters or {}).items()}
        self._made_for: dict[int, Made] = {}
        self._signatures: dict[int, str] = {}

    @property
    def parameters(self) -> dict[str, float]:
        """Values of the parameters by name; a copy."""
        return dict(self._parameters)

    def set(self, **values: float) -> None:
        """Change parameters, of this law and of the contacts that have it.

        Args:
            values: new values by name.

        Raises:
            TypeError: a value is no number.
            ValueError: the law has no parameter of a name.
        """
        for name, value in values.items():
            if name not in self._parameters:
                raise ValueError(f"the law has no parameter {name!r}, it has {sorted(self._parameters)}")
            self._parameters[name] = number(f"parameter {name!r}", value)
            for made in self._made_for.values():
                made.set_constant(name, self._parameters[name])

    def in_cpp(self, V: FunctionSpace, comm: MPI.Comm | None = None) -> Made:
        """The law in C++, compiled when it is asked for the first time. Collective.

        Args:
            V: space of the displacement.
            comm: communicator whose ranks compile together; None: that of the mesh.

        Raises:
            ValueError: the law does not fit the mesh, or cannot be compiled; on all ranks.
        """
        mesh = V.mesh
        gdim = mesh.geometry.dim
        for key, function in self.fields.items():
            space = function.function_space
            same = space.mesh == mesh and space.dofmap.index_map.size_global == V.dofmap.index_map.size_global
            if not same or space.element.basix_element.degree != V.element.basix_element.degree:
                raise ValueError(f"field {key!r} of {self.name} must be of the mesh and the degree of the displacement")
        if gdim not in self._made_for:
            self._made_for[gdim] = self.compiled(gdim, comm or mesh.comm)
        return self._made_for[gdim]

    def compiled(self, gdim: int, comm: MPI.Comm) -> Made:
        """The law in C++, without a mesh. Collective.

        Args:
            gdim: dimension of space [1].
            comm: communicator whose ranks compile together.
        """
        form = self._form(gdim)
        self._signatures[gdim] = form_signature(form.form, form.point_law)[:32]
        compiled = jit.compile_form(form.form, form.names, comm, form.point_law)
        functions = {name: function._cpp_object for name, function in self.fields.items()}
        (kernel,) = compiled.kernels
        return self._make(kernel.address, gdim, functions)

    def _form(self, gdim: int) -> Any:
        """The kernel's form."""
        raise NotImplementedError

    def _make(self, kernel: int, gdim: int, functions: dict[str, Any]) -> Made:
        """The law in C++, of a kernel."""
        raise NotImplementedError

    def identity(self, gdim: int) -> str:
        """What a checkpoint knows of the law: its expressions and parameters.

        Args:
            gdim: dimension of space of a problem that has the law [1].
        """
        numbers = ", ".join(f"{name} {value!r}" for name, value in sorted(self._parameters.items()))
        fields = ", ".join(sorted(self.fields))
        return f"expressions {self._signatures[gdim]}; {numbers}; fields {fields}"


def call(function: Part | float | None, given: Mapping[str, Any], what: str) -> Any:
    """Call a function of a law with the arguments that it asks for.

    Args:
        function: of the law.
        given: what there is, by name.
        what: name of the function, for messages.

    Raises:
        TypeError: it asks for something else.
    """
    assert callable(function)
    try:
        parameters = inspect.signature(function).parameters
    except (TypeError, ValueError) as e:
        raise TypeError(f"the arguments of `{what}` of a law cannot be found out: write it as a Python function") from e
    # An argument of another name with a default is the function's own, as in `lambda gap, k=k: -k * gap`.
    wanted = [name for name, p in parameters.items() if name in given or p.default is inspect.Parameter.empty]
    unknown = [name for name in wanted if name not in given]
    if unknown:
        raise TypeError(f"`{what}` of a law asks for {unknown}; there are {', '.join(sorted(given))}")
    return function(**{name: given[name] for name in wanted})
