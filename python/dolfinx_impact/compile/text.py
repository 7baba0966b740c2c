# SPDX-License-Identifier: MIT
"""Text of the header and the source with the kernels of a file."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from .. import _cpp
from ..forms.compiler import emit
from .kernel_source import KernelSource
from .origin import Origin
from .own_law import OwnLaw

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


def comment(origin: Origin, laws: Sequence[OwnLaw], kernels: Sequence[KernelSource]) -> str:
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
    kernels: Sequence[KernelSource],
    apart: bool,
    advance: Callable[[KernelSource], None] = lambda kernel: None,
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
