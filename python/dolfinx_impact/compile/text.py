# SPDX-License-Identifier: MIT
"""Text of the header and the source with the kernels of a file."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from .. import _cpp
from ..forms.compiler import emit, frontend
from .law import OwnLaw

# Words that no namespace can be called by: of the language, and of the libraries that a program includes.
RESERVED = frozenset(
    """
    alignas alignof and and_eq asm auto basix bitand bitor bool break case catch char char8_t char16_t char32_t class
    compl concept const consteval constexpr constinit const_cast continue co_await co_return co_yield decltype default
    delete do dolfinx dolfinx_impact double dynamic_cast else enum explicit export extern false float for friend goto if
    inline int long main mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected public
    register reinterpret_cast requires return short signed sizeof static static_assert static_cast std struct switch
    template this thread_local throw true try typedef typeid typename union unsigned using virtual void volatile wchar_t
    while xor xor_eq
    """.split()
)

HEADER = """\
{comment}
#pragma once
#include <map>
#include <span>
#include <string>
#include <vector>
#include "dolfinx_impact/kernels/Kernel.h"

static_assert(IMPACT_KERNEL_ABI == {abi}, "this header is of another version of dolfinx_impact: write it anew");

namespace {stem}
{{
/// Kernels of {file}. Give them to dolfinx_impact::kernels::add, and dolfinx_impact::kernels::find finds them by name.
{inline}std::span<const impact_kernel* const> kernels();

/// Values that the constants of a law have in {file}, by name, for dolfinx_impact::kernels::constants.
/// @throws std::invalid_argument for another name than {names}
{inline}std::map<std::string, std::vector<double>> constants(const std::string& law{default});
}} // namespace {stem}
"""

FUNCTIONS = """
namespace {stem}
{{
{inline}std::span<const impact_kernel* const> kernels()
{{
  static const impact_kernel* const all[] = {{
{kernels}}};
  return all;
}}

{inline}std::map<std::string, std::vector<double>> constants(const std::string& law)
{{
{constants}  throw std::invalid_argument("{file} has no law '" + law + "': there is {names}");
}}
}} // namespace {stem}
"""


@dataclass
class Origin:
    """What a header was made of.

    Attributes:
        file: name of the user's file, without its folder.
        command: command that makes the same kernels.
        versions: versions of the libraries, by name.
    """

    file: str
    command: str
    versions: dict[str, str]

    @property
    def stem(self) -> str:
        """Name of the file without its ending: name of the header and of its namespace."""
        return self.file.rpartition(".")[0]

    def check(self) -> None:
        """Refuse a file whose name is none in C++.

        Raises:
            ValueError: it is not.
        """
        valid = re.fullmatch(r"[A-Za-z]\w*\.\w+", self.file, re.ASCII)
        if not valid or self.stem in RESERVED or "__" in self.stem:
            raise ValueError(
                f"the namespace of the kernels has the name of the file, and {self.file} gives none in C++: rename it, "
                "as my_law.py"
            )


@dataclass
class Kernel:
    """Kernels of one form of a law.

    Attributes:
        law: the law on its cells.
        kind: kind of the kernel, of law.KINDS.
        integrals: what the kernels are written of.
    """

    law: OwnLaw
    kind: str
    integrals: list[frontend.Integral]

    @property
    def name(self) -> str:
        """Name by which kernels::find finds it."""
        return f"{self.law.name}.{self.kind}"

    def prefix(self, stem: str) -> str:
        """Beginning of the names of its descriptors.

        Args:
            stem: name of the header.
        """
        return "_".join(["impact", stem, self.law.name, self.kind, *map(str, self.law.case)])


def kernel_of(law: OwnLaw, kind: str) -> Kernel:
    """What the kernels of a form are written of.

    Args:
        law: the law.
        kind: kind of the kernel.

    Raises:
        ValueError: kernels do not support the form.
    """
    form = law.forms[kind]
    try:
        names = _names(law, form.form, form.law)
        found = frontend.form_integrals(form.form, f"{law.name}.{kind}", names, law.case.hypothesis, form.law)
    except KeyboardInterrupt:
        raise
    except Exception as e:  # UFL and FFCx raise errors of many kinds
        lines = str(e).strip().splitlines() or [type(e).__name__]
        what = lines[0] if isinstance(e, ValueError) else f"{type(e).__name__}: {lines[0]}"
        raise ValueError(
            f"no kernel can be written of {law.name}.{kind} on {law.case}: {what}; --kernels leaves a kind out"
        ) from e
    return Kernel(law, kind, found)


def _names(law: OwnLaw, form: Any, point_law: Any) -> dict[Any, str]:
    """Names of the coefficients and constants of one form."""
    coefficients, constants = frontend.objects_of(form, point_law)
    return {o: law.names[o] for o in [*coefficients, *constants] if o in law.names}


def comment(origin: Origin, laws: Sequence[OwnLaw], kernels: Sequence[Kernel]) -> str:
    """What a header says about itself.

    Args:
        origin: what it is made of.
        laws: its laws.
        kernels: its kernels.
    """
    lines = [f"Kernels of {origin.file} for C++ programs with dolfinx_impact. Do not edit: written by", ""]
    lines += [f"    {origin.command}", "", f"with {', '.join(f'{n} {v}' for n, v in origin.versions.items())}.", ""]
    for name in dict.fromkeys(law.name for law in laws):
        own = [law for law in laws if law.name == name]
        lines.append(f"{name}, constants with their values in the file:")
        sizes = {c.name: c.size for k in kernels if k.law.name == name for i in k.integrals for c in i.constants}
        given = own[0].values
        lines += [f"    {n} {_numbers(given.get(n), size)}" for n, size in sizes.items()] or ["    none"]
        lines.append("on")
        lines += [f"    {law.case}" for law in own] + ["kernels, and what they read:"]
        for kind in dict.fromkeys(k.kind for k in kernels if k.law.name == name):
            first = next(k for k in kernels if k.law.name == name and k.kind == kind)
            read = dict.fromkeys(c.name for i in first.integrals for c in (*i.coefficients, *i.constants))
            lines.append(f"    {first.name}: {', '.join(read) or 'nothing'}")
        for kind, reason in own[0].missing.items():
            lines.append(f"    no {name}.{kind}: {reason}")
        lines.append("")
    return "\n".join(f"// {line}".rstrip() for line in lines[:-1])


def _numbers(values: Sequence[float] | None, size: int) -> str:
    """Value of a constant, or that the file has none."""
    if values is None:
        return "(no value)" if size == 1 else f"({size} components, no value)"
    return repr(values[0]) if size == 1 else str(list(values))


def texts(
    origin: Origin,
    laws: Sequence[OwnLaw],
    kernels: Sequence[Kernel],
    apart: bool,
    advance: Callable[[Kernel], None] = lambda kernel: None,
) -> tuple[str, str]:
    """Header and source.

    Args:
        origin: what they are made of.
        laws: the laws, on all cells.
        kernels: their kernels.
        apart: whether the code is in a source of its own; else it is in the header.
        advance: called before each kernel.

    Returns:
        Text of the header, and text of the source, which is empty unless `apart`.
    """
    stem, inline = origin.stem, "" if apart else "inline "
    names = list(dict.fromkeys(law.name for law in laws))
    code, descriptors = [], []
    for kernel in kernels:
        advance(kernel)
        linkage = emit.OBJECT if apart else emit.INLINE
        text, found = emit.definitions(kernel.integrals, kernel.prefix(stem), linkage)
        code.append(text)
        descriptors += found
    common = {"stem": stem, "file": origin.file, "inline": inline, "names": ", ".join(names)}
    about = comment(origin, laws, kernels)
    default = f' = "{names[0]}"' if len(names) == 1 else ""
    header = HEADER.format(**common, comment=about, abi=_cpp.kernels.ABI, default=default)
    functions = FUNCTIONS.format(
        **common,
        kernels=",\n".join(f"    &{d}" for d in descriptors),
        constants="".join(_constants(name, next(law for law in laws if law.name == name)) for name in names),
    )
    includes = "#include <stdexcept>\n"
    preamble = emit.preamble([i for k in kernels for i in k.integrals])
    if not apart:
        quiet = ["#pragma GCC diagnostic push", '#pragma GCC diagnostic ignored "-Wunused-but-set-variable"']
        head = "\n".join([*quiet, includes + preamble])
        return f"{header}\n{head}{''.join(code)}{functions}#undef IMPACT_LANES\n#pragma GCC diagnostic pop\n", ""
    body = "".join(code) + f"\n#if IMPACT_LANES <= 1{functions}#endif\n"
    return header, f'{about}\n#include "{stem}.h"\n{includes}{preamble}{body}'


def _constants(name: str, law: OwnLaw) -> str:
    rows = ", ".join(
        f"{{{emit.literal(n)}, {{{', '.join(repr(v) for v in values)}}}}}" for n, values in sorted(law.values.items())
    )
    return f'  if (law == "{name}")\n    return {{{rows}}};\n'
