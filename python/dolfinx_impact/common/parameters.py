# SPDX-License-Identifier: MIT
"""Parameters of commands: types, units, ranges, texts of errors and the template of a file from one declaration.

A set of parameters is a subclass of `Parameters` whose fields are declared by `parameter`. Values come from Python,
from a TOML file, or as texts from a command line; a number may be a text with a unit, such as "120 km/h".
"""

from __future__ import annotations

import difflib
import hashlib
import math
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args, get_origin

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, JsonValue, ValidationError, model_validator

from .types import FilePath

Self = TypeVar("Self", bound="Parameters")

# Units that a text may have, by the SI unit of the parameter, with their factors.
UNITS: dict[str, dict[str, float]] = {
    "m": {"m": 1.0, "mm": 1e-3, "um": 1e-6},
    "N": {"N": 1.0, "kN": 1e3, "MN": 1e6},
    "kg": {"kg": 1.0, "t": 1e3},
    "m/s": {"m/s": 1.0, "km/h": 1.0 / 3.6},
    "Pa": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9},
    "kg/m^3": {"kg/m^3": 1.0, "t/m^3": 1e3},
    "N/m": {"N/m": 1.0, "kN/mm": 1e6, "MN/m": 1e6},
    "N s/m": {"N s/m": 1.0, "kN s/m": 1e3},
    "1": {"1": 1.0, "%": 1e-2},
    "s": {"s": 1.0, "min": 60.0},
}
NUMBER = re.compile(r"\s*([-+]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|inf|nan))\s*(.*?)\s*")
SHOWN = 60  # characters of a bad value in a message
LONGEST = 10**15  # of whole numbers: every one up to it is a number of double precision, too


def parameter(
    default: Any,
    unit: str,
    what: str,
    low: float | None = None,
    high: float | None = None,
    above: float | None = None,
    zero: bool = False,
    infinite: bool = False,
) -> Any:
    """Declare a field of `Parameters`.

    Args:
        default: value if none is given.
        unit: of numbers, "1" for those without a dimension, "" for what is no number.
        what: description for the template, the help of the command line and reports.
        low: smallest value; None: no bound.
        high: largest value; None: no bound.
        above: value that must be exceeded; None: no bound.
        zero: whether zero is allowed below `low`, with a meaning of its own.
        infinite: whether inf is allowed, too.
    """
    bounds: dict[str, JsonValue] = {"low": low, "high": high, "above": above, "zero": zero, "infinite": infinite}
    return Field(default, description=what, json_schema_extra={"unit": unit, "bounds": bounds})


class Parameters(BaseModel):
    """A set of parameters that does not change; all in SI units.

    Args:
        values: in the order of the fields.
        named: by name.

    Raises:
        TypeError: more values than fields, or a field twice.
        ValueError: an unknown name, a value of a wrong kind, or one outside its range. The text is one sentence that
            names the parameter, what was found and what is allowed.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    def __init__(self, *values: Any, **named: Any) -> None:
        names = list(type(self).model_fields)
        twice = sorted(set(names[: len(values)]) & set(named))
        if len(values) > len(names) or twice:
            raise TypeError(f"a {type(self).__name__} has {len(names)} parameters; given twice: {', '.join(twice)}")
        given = {**dict(zip(names, values)), **named}
        try:
            super().__init__(**{name: self._converted(name, value) for name, value in given.items()})
        except ValidationError as error:
            raise ValueError(self._sentence(error.errors()[0], given)) from None

    @classmethod
    def unit_of(cls, name: str) -> str:
        """Unit of a parameter, empty for what is no number.

        Args:
            name: of the parameter.
        """
        return str(_extra(cls, name)["unit"])

    @classmethod
    def what_of(cls, name: str) -> str:
        """Description of a parameter.

        Args:
            name: of the parameter.
        """
        return str(cls.model_fields[name].description)

    @classmethod
    def expected(cls, name: str, texts: bool = True) -> str:
        """What a parameter may be, for messages and help: kind, range and units.

        Args:
            name: of the parameter.
            texts: whether the units are named that a text may have.
        """
        kind, unit, bounds = _kind(cls, name), cls.unit_of(name), _extra(cls, name)["bounds"]
        if kind is bool:
            return "true or false"
        if get_origin(kind) is Literal:
            return f"one of {', '.join(get_args(kind))}"
        if get_origin(kind) is tuple:
            return f"a list{_in(unit, False)}"
        text = "a whole number" if kind is int else "a number"
        low, high, above = bounds["low"], bounds["high"], bounds["above"]
        if low is not None:
            text += f" from {low:g}" + ("" if high is None else f" to {high:g}")
        elif above is not None:
            text += f" above {above:g}" + ("" if high is None else f" and up to {high:g}")
        elif high is not None:
            text += f" up to {high:g}"
        text += " or 0" if bounds["zero"] else ""
        text += " or inf" if bounds["infinite"] else ""
        return text if kind is int else text + _in(unit, texts)

    @classmethod
    def _converted(cls, name: str, value: Any) -> Any:
        """A value as pydantic's strict types take it: Python's numbers, tuples, texts with units as numbers."""
        if isinstance(value, np.generic):
            value = value.item()
        if name not in cls.model_fields:
            return value
        kind = _kind(cls, name)
        if isinstance(value, str) and kind is bool:
            return {"true": True, "false": False}.get(value.lower(), value)
        if isinstance(value, str) and get_origin(kind) is tuple:
            return _tuples(_from_text(value))
        if isinstance(value, str) and kind in (int, float):
            return _number(value, cls.unit_of(name), kind)
        return _tuples(value)

    @model_validator(mode="after")
    def _check_bounds(self) -> Parameters:
        """Ranges of numbers; NaN is outside each."""
        for name in type(self).model_fields:
            value, bounds = getattr(self, name), _extra(type(self), name)["bounds"]
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                continue
            good = abs(value) <= LONGEST if isinstance(value, int) else math.isfinite(value)
            good = good or (bounds["infinite"] and value == math.inf)
            low, high, above = bounds["low"], bounds["high"], bounds["above"]
            inside = (low is None or value >= low) and (above is None or value > above)
            inside = (inside or (bounds["zero"] and value == 0)) and (
                high is None or value <= high or (bounds["infinite"] and value == math.inf)
            )
            if not good or not inside:
                raise ValueError(self._refusal(name, value))
        self._check_together()
        return self

    def _check_together(self) -> None:
        """Raise ValueError where values that are good alone do not fit each other."""

    @classmethod
    def _refusal(cls, name: str, value: Any) -> str:
        shown = repr(value)
        shown = shown if len(shown) <= SHOWN else shown[:SHOWN] + "..."
        return f"{name} is {shown}: give {cls.expected(name)}"

    @classmethod
    def _sentence(cls, error: Any, given: Mapping[str, Any]) -> str:
        """One sentence for what pydantic has found."""
        place = error["loc"]
        if error["type"] == "extra_forbidden":
            return cls.unknown([str(place[0])])
        if not place:  # raised by the checks above, as a whole sentence
            return str(error["ctx"]["error"])
        return cls._refusal(str(place[0]), given.get(str(place[0])))

    @classmethod
    def unknown(cls, names: Iterable[str]) -> str:
        """Sentence about names that are no parameters.

        Args:
            names: that were given.
        """
        near = [n for name in names for n in difflib.get_close_matches(name, cls.model_fields, 1)]
        hint = f" (did you mean {', '.join(near)}?)" if near else ""
        known = ", ".join(sorted(cls.model_fields))
        return f"a {cls.__name__} has no {', '.join(sorted(names))}{hint}; it has {known}"

    def changed(self: Self, **values: Any) -> Self:
        """The same with other values.

        Args:
            values: by name.

        Raises:
            ValueError: an unknown name, or a bad value.
        """
        unknown = set(values) - set(type(self).model_fields)
        if unknown:
            raise ValueError(self.unknown(unknown))
        return type(self)(**{**self.values(), **values})

    def values(self) -> dict[str, Any]:
        """Values by name."""
        return {name: getattr(self, name) for name in type(self).model_fields}

    @classmethod
    def from_toml(cls: type[Self], path: FilePath) -> Self:
        """Read parameters: `name = number` in SI units, or `name = "number unit"`, for example `speed = "120 km/h"`.

        Args:
            path: file; what it does not name has its default.

        Raises:
            ValueError: the file cannot be read or is no TOML, an unknown name, a unit of another kind, a bad value.
        """
        return cls(**cls.read_toml(path))

    @classmethod
    def read_toml(cls, path: FilePath) -> dict[str, Any]:
        """Names and values of a TOML file, not checked but for the names.

        Args:
            path: file.

        Raises:
            ValueError: the file cannot be read, is no TOML, or has an unknown name.
        """
        try:
            given = tomllib.loads(Path(path).read_text(encoding="utf-8"))
        except OSError as error:
            raise ValueError(f"{path} cannot be read: {error.strerror}") from None
        except (ValueError, RecursionError) as error:  # of TOML, of UTF-8, and names of files with a zero byte
            raise ValueError(f"{path} is no TOML file: {error}") from None
        unknown = set(given) - set(cls.model_fields)
        if unknown:
            raise ValueError(f"{path}: {cls.unknown(unknown)}")
        return given

    @classmethod
    def from_command_line(cls: type[Self], texts: Sequence[str], file: FilePath | None = None, **given: Any) -> Self:
        """Parameters from a file, from texts NAME=VALUE, and from options; later ones replace earlier ones.

        Args:
            texts: at most one name of a TOML file, and texts NAME=VALUE.
            file: TOML file; None: one of `texts`, or none.
            given: further values by name; None: not given.

        Raises:
            ValueError: an unknown name, a bad value, or a file that cannot be read.
        """
        single = [text for text in texts if _is_assignment(text)]
        files = [text for text in texts if text not in single] + ([] if file is None else [str(file)])
        if len(files) > 1:
            raise ValueError(f"more than one file of parameters: {', '.join(files)}")
        values = cls.read_toml(files[0]) if files else {}
        values |= dict(text.split("=", 1) for text in single)
        values |= {name: value for name, value in given.items() if value is not None}
        return cls(**values)

    def to_toml(self) -> str:
        """Text of a TOML file with all parameters, what they are, their units and ranges."""
        first = str(type(self).__doc__).split("\n")[0].rstrip(".")
        lines = [f'# {first}; numbers in the units of the comments, or texts such as "120 km/h"']
        for name in type(self).model_fields:
            value = _as_toml(getattr(self, name))
            lines.append(f"{name} = {value}  # {self.what_of(name)}: {self.expected(name, texts=False)}")
        return "\n".join(lines) + "\n"

    def identity(self) -> str:
        """Checksum of all values, for files that belong to them."""
        text = "\n".join(f"{name} = {_as_toml(value)}" for name, value in self.values().items())
        return hashlib.blake2b(f"{type(self).__name__}\n{text}".encode(), digest_size=16).hexdigest()


def _extra(cls: type[Parameters], name: str) -> dict[str, Any]:
    found = cls.model_fields[name].json_schema_extra
    assert isinstance(found, dict)
    return dict(found)


def _kind(cls: type[Parameters], name: str) -> Any:
    return cls.model_fields[name].annotation


def _in(unit: str, texts: bool) -> str:
    """Unit and those that texts may have, for messages."""
    others = [u for u in UNITS.get(unit, {}) if u != unit and texts]
    if unit in ("", "1"):
        return f" (or a text in {', '.join(others)})" if others else ""
    return f" [{unit}]" + (f" (or a text in {', '.join(others)})" if others else "")


def _is_assignment(text: str) -> bool:
    name, equals, _ = text.partition("=")
    return bool(equals) and not Path(text).is_file() and "/" not in name


def _number(text: str, unit: str, kind: type) -> Any:
    """Number of a text with a unit; the text itself if it is none."""
    match = NUMBER.fullmatch(text)
    factors = UNITS.get(unit, {unit: 1.0})
    if match is None or match.group(2) not in {"", *factors}:
        return text
    if math.isinf(float(match.group(1))) and "inf" not in match.group(1):  # too large for a number
        return text
    number = float(match.group(1)) * (factors[match.group(2)] if match.group(2) else 1.0)
    return int(number) if kind is int and math.isfinite(number) and number == int(number) else number


def _from_text(text: str) -> Any:
    """Value of a text as TOML has it; the text itself if it is none."""
    try:
        return tomllib.loads(f"x = {text}")["x"]
    except tomllib.TOMLDecodeError:
        return text


def _tuples(value: Any) -> Any:
    """Lists as tuples, numbers of NumPy as Python's, at any depth."""
    if isinstance(value, (list, tuple, np.ndarray)):
        return tuple(_tuples(v) for v in value)
    return value.item() if isinstance(value, np.generic) else value


def _as_toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, tuple):
        return "[" + ", ".join(_as_toml(v) for v in value) + "]"
    return repr(value)
