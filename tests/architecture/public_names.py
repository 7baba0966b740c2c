# SPDX-License-Identifier: MIT
"""The public names of the Python packages with their signatures, as lines of text.

Public is what `dolfinx_impact.__all__` has, what the pages of docs/api show by `autoclass` and `autofunction`, and the
public members of these classes (docs/compatibility.md). `python3 tests/architecture/public_names.py` writes the list
anew into public_names.txt; `make public-names` does the same.
"""

import enum
import importlib
import inspect
import pathlib
import re
import types

CHECKOUT = pathlib.Path(__file__).resolve().parents[2]
FILE = pathlib.Path(__file__).with_name("public_names.txt")
OWN = ("dolfinx_impact", "impact_verify", "impact_studies", "impact_reference")
HEAD = """# Public names of the Python packages and their signatures: names and defaults of parameters, without types.
# A test compares it with what there is. After a change on purpose (docs/compatibility.md): make public-names
"""


def shown(checkout=CHECKOUT):
    """Dotted names that the pages of the API show."""
    names = []
    for page in sorted((checkout / "docs" / "api").glob("*.md")):
        module = ""
        for kind, name in re.findall(r"\.\. (currentmodule|autoclass|autofunction):: ([\w.]+)", page.read_text()):
            if kind == "currentmodule":
                module = name
            else:
                names.append(name if name.startswith(OWN) else f"{module}.{name}")
    return names


def found(name):
    """Object of a dotted name."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            value = importlib.import_module(".".join(parts[:count]))
        except ImportError:
            continue
        for part in parts[count:]:
            value = getattr(value, part)
        return value
    raise ImportError(name)


def _default(value):
    """A default in words that do not depend on the process: functions and objects by their names."""
    if isinstance(value, enum.Enum):
        return str(value)
    if value is None or isinstance(value, (bool, int, float, str, tuple, list, dict)):
        return repr(value)
    name = getattr(value, "__name__", type(value).__name__)
    return "<made anew>" if "FACTORY" in name else f"<{name}>"  # the default of a field of a dataclass


def signature(value, method=False):
    """Parameters with their defaults, without types, which other versions of Python write otherwise. A function that is
    a method of a class is given the object, whatever it calls it.
    """
    try:
        parameters = list(inspect.signature(value).parameters.values())[1 if method else 0 :]
    except (TypeError, ValueError):
        return "(...)"  # compiled
    words, keywords = [], False
    for p in parameters:
        if p.name in ("self", "cls"):
            continue
        if p.kind is p.KEYWORD_ONLY and not keywords:
            words.append("*")
        keywords = keywords or p.kind in (p.VAR_POSITIONAL, p.KEYWORD_ONLY)
        star = {p.VAR_POSITIONAL: "*", p.VAR_KEYWORD: "**"}.get(p.kind, "")
        words.append(star + p.name + ("" if p.default is p.empty else f"={_default(p.default)}"))
    return f"({', '.join(words)})"


def _is_own(value):
    return (getattr(value, "__module__", None) or "").startswith(OWN)


def members(name, kind):
    """Lines of the public members of a class that this project wrote, inherited ones included."""
    for member in sorted(set(dir(kind))):
        owner = next((base for base in kind.__mro__ if member in vars(base)), None)
        if member.startswith("_") or owner is None or not _is_own(owner):
            continue
        value = vars(owner)[member]
        if isinstance(value, property):
            yield f"{name}.{member}" + ("" if value.fset is None else ", can be set")
        elif isinstance(value, (staticmethod, classmethod)) or callable(value):
            yield f"{name}.{member}{signature(getattr(kind, member), inspect.isfunction(value))}"
        elif not isinstance(value, types.ModuleType):
            yield f"{name}.{member}"


def lines(checkout=CHECKOUT):
    """The list."""
    import dolfinx_impact

    names = [f"dolfinx_impact.{name}" for name in dolfinx_impact.__all__ if not name.startswith("_")]
    out = set()
    for name in dict.fromkeys(names + shown(checkout)):
        value = found(name)
        if isinstance(value, types.ModuleType):
            inside = getattr(value, "__all__", None)
            out.add(name)
            out |= {f"{name}.{n}{signature(getattr(value, n))}" for n in inside or () if callable(getattr(value, n))}
        elif inspect.isclass(value):
            is_enum = issubclass(value, enum.Enum)
            out.add(name if is_enum else f"{name}{signature(value)}")
            out |= {f"{name}.{m}" for m in value.__members__} if is_enum else set(members(name, value))
        else:
            out.add(f"{name}{signature(value)}" if callable(value) else name)
    return sorted(out)


def difference(listed, there):
    """Lines that say what has changed; empty if nothing has."""
    listed, there = set(listed), set(there)
    return [f"- {line}" for line in sorted(listed - there)] + [f"+ {line}" for line in sorted(there - listed)]


def read(file=FILE):
    return [line for line in file.read_text().splitlines() if line and not line.startswith("#")]


if __name__ == "__main__":
    now = lines()
    print("\n".join(difference(read() if FILE.exists() else [], now)) or "nothing has changed")
    FILE.write_text(HEAD + "".join(f"{line}\n" for line in now))
