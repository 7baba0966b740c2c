# SPDX-License-Identifier: MIT
"""Files of a user: functions of a mesh, UFL forms and materials that can be checked or compiled."""

from __future__ import annotations

import inspect
import runpy
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import ufl
from ufl.algorithms import extract_coefficients

from ..materials import _Material
from .own_form import OwnForm


def run_file(path: Path | str) -> dict[str, Any]:
    """Run a user's file.

    Args:
        path: the file.

    Returns:
        Namespace of the file.

    Raises:
        FileNotFoundError: no such file.
        ValueError: the file raises; the message has the line.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"there is no file {path}")
    try:
        return runpy.run_path(str(path))
    except SyntaxError as e:
        raise ValueError(f"{path}, line {e.lineno}: {e.msg}: {(e.text or '').strip()}") from e
    except SystemExit as e:
        raise ValueError(
            f"{path} ends the program, sys.exit({e.code!r}): put what is to run alone below if __name__ == '__main__'"
        ) from e
    except Exception as e:
        line, trace = None, e.__traceback__
        while trace is not None:
            if trace.tb_frame.f_code.co_filename == str(path):
                line = trace.tb_lineno
            trace = trace.tb_next
        raise ValueError(f"{path}, line {line}: {type(e).__name__}: {e}") from e


def things(path: Path | str, name: str | None = None) -> tuple[dict[str, Any], dict[str, Any]]:
    """What a user's file says about forms.

    Args:
        path: the file.
        name: the one that is asked for; None: all functions of a mesh, materials and forms of rank 1 (or if there are
            none, of rank 0 and 2). A function of a mesh has the parameter `mesh`, and may have `degree` and
            `hypothesis` with defaults.

    Returns:
        Things that `source_of` takes by name, and the names of the file.

    Raises:
        FileNotFoundError: no such file.
        ValueError: the file raises, or there is no form in it, or nothing of this name.
    """
    namespace = run_file(path)
    known = {n: o for n, o in namespace.items() if not n.startswith("_") and _is_checkable(o, str(path))}
    if name is not None:
        if name not in namespace:
            raise ValueError(
                f"{path} defines nothing called {name!r}; what can be checked in it: {', '.join(known) or 'nothing'}"
            )
        return {name: namespace[name]}, namespace
    first = {n: o for n, o in known.items() if not isinstance(o, ufl.Form) or len(o.arguments()) == 1}
    chosen = first or known
    if not chosen:
        raise ValueError(
            f"there is nothing to check in {path}: write a function my_form(mesh) that returns a residual and its "
            "unknown, or a UFL form"
        )
    return chosen, namespace


def _is_checkable(thing: Any, path: str) -> bool:
    if isinstance(thing, (ufl.Form, OwnForm, _Material)):
        return True
    if not inspect.isfunction(thing) or thing.__code__.co_filename != path:
        return False
    parameters = list(inspect.signature(thing).parameters.values())
    if not parameters or parameters[0].name != "mesh":
        return False
    return all(p.name in ("degree", "hypothesis") and p.default is not p.empty for p in parameters[1:])


def cells_of(namespace: Mapping[str, Any]) -> tuple[str, ...] | None:
    """Cells that a file names in `cells`; None if it names none.

    Args:
        namespace: names of the file.
    """
    cells = namespace.get("cells")
    return (cells,) if isinstance(cells, str) else cells


def unknown_of(form: ufl.Form, name: str, names: Mapping[str, Any]) -> Any:
    """The unknown of a form.

    Args:
        form: residual, energy or bilinear form.
        name: its name, for errors.
        names: names of the file that it is from.

    Returns:
        The coefficient called u, or the only one, or for bilinear forms a function of the test space.

    Raises:
        ValueError: there are several coefficients, and none is called u.
    """
    found = extract_coefficients(form)
    if len(form.arguments()) == 2 and not found:
        return ufl.Coefficient(form.arguments()[0].ufl_function_space())
    own = names.get("u")
    if any(c is own for c in found):
        return own
    if len(found) == 1:
        return found[0]
    raise ValueError(f"{name} contains {len(found)} functions: which of them is the unknown? Call it u, or give u=")
