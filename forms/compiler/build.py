# SPDX-License-Identifier: MIT
"""Build driver: writes the C++ sources of the registry's table into a folder, and the table itself.

Usage: python3 -m forms.compiler.build --list | --list-vectors | --list-laws | --list-floats | --output DIR
"""

import argparse
import multiprocessing
from pathlib import Path

from ..registry import IN_FLOAT, TABLE
from . import emit, float_source, frontend


def _write(path, text):
    """Write only what changed, so that the build tool recompiles only what changed."""
    if not path.exists() or path.read_text() != text:
        path.write_text(text)


def _generate(job):
    number, folder = job
    row = TABLE[number]
    built = row.build()
    integrals = frontend.form_integrals(built.form, row.name, built.names, row.hypothesis, built.law)
    text, names = emit.source(integrals, row.symbol)
    _write(folder / f"{row.symbol}.cpp", text)
    if row in IN_FLOAT:
        _write(folder / f"{row.symbol}_float.cpp", float_source.source(integrals[0], names[0]))
    return names


def table_source(names):
    """C++ source of the table of descriptors."""
    out = ['#include "dolfinx_impact/kernels/Kernel.h"\n#include <cstddef>\n']
    out += [f'extern "C" const impact_kernel {n};' for n in names]
    listed = ",\n  ".join("&" + n for n in names)
    table = f"extern const impact_kernel* const generated_table[] = {{\n  {listed}}};"
    size = f"extern const std::size_t generated_table_size = {len(names)};"
    out.append(f"namespace dolfinx_impact::kernels\n{{\n{table}\n{size}\n}} // namespace dolfinx_impact::kernels\n")
    return "\n".join(out)


def generate(folder):
    """Write all sources; returns the names of the descriptors."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    jobs = [(i, folder) for i in range(len(TABLE))]
    with multiprocessing.Pool(min(2, multiprocessing.cpu_count())) as pool:
        names = [n for group in pool.map(_generate, jobs, chunksize=4) for n in group]
    _write(folder / "table.cpp", table_source(names))
    _write(folder / "float_table.cpp", float_source.table_source([f"{row.symbol}_0" for row in IN_FLOAT]))
    (folder / "stamp").write_text("generated\n")
    return names


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--list", action="store_true", help="print the file names and stop")
    parser.add_argument("--list-vectors", action="store_true", help="the same of kernels that have eight lanes")
    parser.add_argument("--list-laws", action="store_true", help="those of kernels with internal variables")
    parser.add_argument("--list-floats", action="store_true", help="those of kernels in single precision")
    parser.add_argument("--output", help="folder for the sources")
    args = parser.parse_args()
    if args.list_floats:
        print(";".join(f"{row.symbol}_float.cpp" for row in IN_FLOAT), end="")
    elif args.list_laws:
        laws = [(row, row.build().law) for row in TABLE]
        print(";".join(f"{row.symbol}.cpp" for row, law in laws if law is not None and law.history), end="")
    elif args.list or args.list_vectors:
        # Kernels of matrices are called for one or four cells at a time: with eight lanes their files are empty.
        rows = [row for row in TABLE if args.list or len(row.build().form.arguments()) < 2]
        print(";".join(f"{row.symbol}.cpp" for row in rows), end="")
    elif args.output:
        generate(args.output)
    else:
        parser.error("--list, --list-vectors, --list-laws, --list-floats or --output is needed")


if __name__ == "__main__":
    main()
