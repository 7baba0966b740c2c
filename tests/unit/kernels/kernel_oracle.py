# SPDX-License-Identifier: MIT
"""FFCx's own C kernels beside ours: generation, compilation, and random cells to compare them on.

Both sides are compiled here with little optimisation: what is compared is the code the two generators write.
"""

import contextlib
import ctypes
import multiprocessing
import re
import shutil
import subprocess
import zlib
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import basix
import basix.ufl
import ffcx.codegeneration
import ffcx.naming
import ffcx.options
import numpy as np
import pytest

import dolfinx_impact
from dolfinx_impact import compat
from dolfinx_impact.forms import registry
from dolfinx_impact.forms.compiler import emit, frontend

KINDS = ("cell", "exterior_facet", "interior_facet")
# FFCx's own defaults round tables at 1e-6; both sides must see the same tables.
OPTIONS = {k: v[1] for k, v in ffcx.options.FFCX_DEFAULT_OPTIONS.items()} | {
    "scalar_type": "float64",
    "sum_factorization": False,
    "table_rtol": 1e-13,
    "table_atol": 1e-14,
}
# The last pointer, to data of the caller's own, is one that kernels of FFCx 0.9 do not look at.
FUNCTION = ctypes.CFUNCTYPE(
    None,
    *[ctypes.POINTER(ctypes.c_double)] * 4,
    ctypes.POINTER(ctypes.c_int),
    ctypes.POINTER(ctypes.c_uint8),
    ctypes.c_void_p,
)
ACCESS = """
extern ufcx_form {name};
void* {access}(int kind, int id)
{{
  for (int i = {name}.form_integral_offsets[kind]; i < {name}.form_integral_offsets[kind + 1]; ++i)
    if ({name}.form_integral_ids[i] == id)
      return (void*){name}.form_integrals[i]->tabulate_tensor_float64;
  return 0;
}}
"""
ACCESS_EXPRESSION = (
    "\nextern ufcx_expression {name};\nvoid* {access}(void) {{ return (void*){name}.tabulate_tensor_float64; }}\n"
)


def _processor():
    """What -march=native depends on, as a compiler flag: ccache takes the flag itself for the same everywhere."""
    found = re.search(r"^(flags|Features)\s*:.*$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    return f"-DPROCESSOR={zlib.crc32(found.group().encode() if found else b'')}"


def _run(command, folder):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]


def _compile(compiler, flags, include, source, text):
    """An object of a source, by ccache where there is one: seen from its own folder, no name tells which run it is."""
    source.write_text(text)
    folder, headers = source.parent, f"include_{compiler}"
    try:
        (folder / headers).symlink_to(include)
    except FileExistsError:  # another form's
        assert (folder / headers).resolve() == include.resolve()
    launcher = ["ccache"] if shutil.which("ccache") else []
    unit = source.with_suffix(".o")
    _run(
        [*launcher, compiler, *flags, _processor(), f"-I{headers}", "-fPIC", "-w", "-c", source.name, "-o", unit.name],
        folder,
    )
    return unit


def _link(units, library):
    """A library of objects in one folder. FFCx names a kernel by its form, which several hypotheses may share."""
    options = ["-shared", "-Wl,-z,muldefs", "-o", library.name, "-lmvec", "-lm"]
    _run(["g++", *(unit.name for unit in units), *options], library.parent)
    return str(library)


def _ffcx_object(ufl_object, stem):
    """Object of FFCx's C kernels, and the name of the function that gives access to them."""
    is_expression = isinstance(ufl_object, tuple)
    naming = ffcx.naming.expression_name if is_expression else lambda f, p: ffcx.naming.form_name(f, 0, p)
    name = naming(ufl_object, "oracle")
    key = id(ufl_object[0]) if is_expression else id(ufl_object)
    text = compat.ffcx_source(ufl_object, dict(OPTIONS), {key: name}, "oracle")
    access = f"oracle_{stem.name}"
    text += (ACCESS_EXPRESSION if is_expression else ACCESS).format(name=name, access=access)
    include = Path(ffcx.codegeneration.__file__).parent
    return _compile("gcc", ["-O0", "-ffp-contract=off"], include, stem.with_suffix(".c"), text), access


def write_ffcx(ufl_object, stem):
    """FFCx's C kernels of a form, or of a pair (expression, points), as a library, and their access, for Oracle."""
    unit, access = _ffcx_object(ufl_object, stem)
    return _link([unit], stem.with_suffix(".so")), access


def _our_object(integrals, stem):
    """Object of our C++ kernels, all widths of this machine, and the names of their descriptors."""
    text, names = emit.source(integrals, "impact_" + stem.name)
    include = Path(dolfinx_impact.__file__).parent / "include"
    flags = ["-std=c++20", "-O1", "-march=native", "-ffp-contract=fast", "-fno-math-errno"]
    return _compile("g++", flags, include, stem.with_suffix(".cpp"), text), names


def write_ours(integrals, stem):
    """Our C++ kernels as a library; returns (path, names of the descriptors)."""
    unit, names = _our_object(integrals, stem)
    return _link([unit], stem.with_suffix(".so")), names


def _job(arguments):
    folder, number, spec, with_ours = arguments
    built = registry.build(*spec)
    ours = None
    if with_ours:
        integrals = frontend.form_integrals(built.form, spec[0], built.names, spec[4])
        ours = _our_object(integrals, folder / f"o{number}")
    return _ffcx_object(built.form, folder / f"k{number}"), ours


@contextlib.contextmanager
def two_processes():
    """Two processes that write and compile kernels.

    FFCx goes through sets: with the same hashes it writes the same lines again, which ccache knows.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONHASHSEED", "0")
        with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
            yield pool


def build_many(specs, folder, with_ours):
    """Kernels of many rows (name, cell, degree, geometry degree, hypothesis), compiled by two processes at once.

    Returns:
        Row -> (FFCx's library and access, our library and names of the descriptors or None): one library of each side
        holds all rows, as linking takes longer than the compilation that ccache remembers.
    """
    jobs = [(folder, i, s, with_ours) for i, s in enumerate(specs)]
    with two_processes() as pool:
        made = list(pool.map(_job, jobs, chunksize=1))
    theirs = _link([unit for (unit, _), _ in made], folder / "ffcx.so")
    ours = _link([unit for _, (unit, _) in made], folder / "ours.so") if with_ours else None
    return {
        spec: ((theirs, access), (ours, of_ours[1]) if with_ours else None)
        for spec, ((_, access), of_ours) in zip(specs, made)
    }


class Oracle:
    """FFCx's kernels from libraries of `write_ffcx`; those of several forms are added up."""

    def __init__(self, *libraries):
        """Pairs (library, access), as `write_ffcx` returns them."""
        self._access = [getattr(ctypes.CDLL(path), access) for path, access in libraries]
        for access in self._access:
            access.restype = ctypes.c_void_p

    def tensor(self, kernel, w, c, x, entity=0):
        """Element tensor of one cell by FFCx, for the integral that `kernel` (ours) belongs to."""
        which = ()
        if kernel.integral_type != "expression":
            which = KINDS.index(kernel.integral_type), kernel.subdomains[0]
        addresses = [a for a in (access(*which) for access in self._access) if a]
        assert addresses, "FFCx wrote no such integral"
        A, number = np.zeros(int(np.prod(kernel.shape))), np.array([entity], dtype=np.intc)
        doubles = [a.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for a in (A, w, c, x)]
        for address in addresses:
            FUNCTION(address)(*doubles, number.ctypes.data_as(ctypes.POINTER(ctypes.c_int)), None, None)
        return A


def aligned(shape):
    """Zeroed array whose first entry stands at a multiple of 64 bytes."""
    size = int(np.prod(shape))
    raw = np.zeros(size + 8)
    start = -raw.ctypes.data % 64 // 8
    return raw[start : start + size].reshape(shape)


def random_cell(kernel, rng, shift=0.0):
    """Node coordinates (nodes, 3) of a turned and distorted cell of the kernel's kind."""
    cell = getattr(basix.CellType, kernel.cell)
    points = basix.create_element(
        basix.ElementFamily.P, cell, kernel.geometry_degree, basix.LagrangeVariant.gll_warped
    ).points
    dim = points.shape[1]
    turn = np.linalg.qr(rng.normal(size=(dim, dim)))[0]
    x = np.zeros((len(points), 3))
    distortion = 0.08 / kernel.geometry_degree**2  # more can turn a quadratic cell inside out
    x[:, :dim] = points @ turn + distortion * rng.uniform(-1, 1, size=points.shape)
    x[:, 0] += shift
    return x


VALUES = {"E": 2.1, "nu": 0.3, "density": 1.7, "alpha": 0.4, "beta": 0.7, "k": 1.9, "p": 0.8}


def constants(kernel, rng):
    """Constants of a kernel: material parameters by name, the others random."""
    c = np.zeros(sum(entry["size"] for entry in kernel.constants))
    for entry in kernel.constants:
        part = slice(entry["offset"], entry["offset"] + entry["size"])
        c[part] = VALUES.get(entry["name"], rng.uniform(0.5, 1.5, size=entry["size"]))
    return c


def difference(kernel, oracle, rng, amplitude=0.05, shift=0.0, low=None):
    """Largest difference of our kernel from FFCx's, over widths and local facets, relative to the largest entry.

    Every lane has a cell and coefficients of its own. amplitude: of the coefficients, about zero; low: lower bound of
    coefficients that must be positive, instead.
    """
    c = constants(kernel, rng)
    size_w = sum(e["num_dofs"] for e in kernel.coefficients)
    cell = getattr(basix.CellType, kernel.cell)
    num_facets = len(basix.topology(cell)[-2]) if kernel.integral_type == "exterior_facet" else 1
    worst = 0.0
    assert kernel.widths[0] == 1
    for lanes in kernel.widths:
        cells = [random_cell(kernel, rng, shift) for _ in range(lanes)]
        draw = (-amplitude, amplitude) if low is None else (low, low + 1.0)
        fields = [rng.uniform(*draw, size=size_w) for _ in range(lanes)]
        x, w = aligned((cells[0].size, lanes)), aligned((size_w, lanes))
        for lane in range(lanes):
            x[:, lane], w[:, lane] = cells[lane].ravel(), fields[lane]
        for facet in range(num_facets):
            A = aligned((int(np.prod(kernel.shape)), lanes))
            kernel.tabulate(A.reshape(-1), w.reshape(-1), c, x.reshape(-1), entity=facet, lanes=lanes)
            for lane in range(lanes):
                expected = oracle.tensor(kernel, fields[lane], c, cells[lane].ravel(), facet)
                scale = np.max(np.abs(expected))
                assert np.all(np.isfinite(A[:, lane])) and scale > 0
                worst = max(worst, np.max(np.abs(A[:, lane] - expected)) / scale)
    return worst
