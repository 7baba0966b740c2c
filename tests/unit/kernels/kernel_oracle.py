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
import ffcx.compiler
import ffcx.naming
import ffcx.options
import numpy as np
import pytest

import dolfinx_impact
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
FUNCTION = ctypes.CFUNCTYPE(
    None, *[ctypes.POINTER(ctypes.c_double)] * 4, ctypes.POINTER(ctypes.c_int), ctypes.POINTER(ctypes.c_uint8)
)
ACCESS = """
extern ufcx_form {name};
void* oracle(int kind, int id)
{{
  for (int i = {name}.form_integral_offsets[kind]; i < {name}.form_integral_offsets[kind + 1]; ++i)
    if ({name}.form_integral_ids[i] == id)
      return (void*){name}.form_integrals[i]->tabulate_tensor_float64;
  return 0;
}}
"""
ACCESS_EXPRESSION = (
    "\nextern ufcx_expression {name};\nvoid* oracle(void) {{ return (void*){name}.tabulate_tensor_float64; }}\n"
)


def _processor():
    """What -march=native depends on, as a compiler flag: ccache takes the flag itself for the same everywhere."""
    found = re.search(r"^(flags|Features)\s*:.*$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    return f"-DPROCESSOR={zlib.crc32(found.group().encode() if found else b'')}"


def _compile(compiler, flags, include, source, text):
    """A library of a source, by ccache where there is one: seen from its own folder, no name tells which run it is."""
    source.write_text(text)
    folder, headers = source.parent, f"include_{compiler}"
    try:
        (folder / headers).symlink_to(include)
    except FileExistsError:  # another form's
        assert (folder / headers).resolve() == include.resolve()
    launcher = ["ccache"] if shutil.which("ccache") else []
    library, unit = source.with_suffix(".so"), source.with_suffix(".o")
    for command in (
        [*launcher, compiler, *flags, _processor(), f"-I{headers}", "-fPIC", "-w", "-c", source.name, "-o", unit.name],
        [compiler, "-shared", unit.name, "-o", library.name, "-lmvec", "-lm"],
    ):
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr[-2000:]
    return library


def write_ffcx(ufl_object, stem):
    """FFCx's C kernels of a form, or of a pair (expression, points), as a library."""
    is_expression = isinstance(ufl_object, tuple)
    naming = ffcx.naming.expression_name if is_expression else lambda f, p: ffcx.naming.form_name(f, 0, p)
    name = naming(ufl_object, "oracle")
    key = id(ufl_object[0]) if is_expression else id(ufl_object)
    _, text = ffcx.compiler.compile_ufl_objects([ufl_object], dict(OPTIONS), {key: name}, "oracle")
    text += (ACCESS_EXPRESSION if is_expression else ACCESS).format(name=name)
    include = Path(ffcx.codegeneration.__file__).parent
    return _compile("gcc", ["-O0", "-ffp-contract=off"], include, stem.with_suffix(".c"), text)


def write_ours(integrals, stem):
    """Our C++ kernels as a library, all widths of this machine; returns (path, names of the descriptors)."""
    text, names = emit.source(integrals, "impact_" + stem.name)
    include = Path(dolfinx_impact.__file__).parent / "include"
    flags = ["-std=c++20", "-O1", "-march=native", "-ffp-contract=fast", "-fno-math-errno"]
    return _compile("g++", flags, include, stem.with_suffix(".cpp"), text), names


def _job(arguments):
    folder, number, spec, with_ours = arguments
    built = registry.build(*spec)
    stem = Path(folder) / f"k{number}"
    ours = None
    if with_ours:
        integrals = frontend.form_integrals(built.form, spec[0], built.names, spec[4])
        path, names = write_ours(integrals, Path(folder) / f"o{number}")
        ours = str(path), names
    return str(write_ffcx(built.form, stem)), ours


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
    """Libraries of many rows (name, cell, degree, geometry degree, hypothesis), by two processes at once."""
    jobs = [(str(folder), i, s, with_ours) for i, s in enumerate(specs)]
    with two_processes() as pool:
        return dict(zip(specs, pool.map(_job, jobs, chunksize=1)))


class Oracle:
    """FFCx's kernels from libraries of `write_ffcx`; those of several forms are added up."""

    def __init__(self, *libraries):
        self.libraries = [ctypes.CDLL(str(path)) for path in libraries]
        for library in self.libraries:
            library.oracle.restype = ctypes.c_void_p

    def tensor(self, kernel, w, c, x, entity=0):
        """Element tensor of one cell by FFCx, for the integral that `kernel` (ours) belongs to."""
        which = ()
        if kernel.integral_type != "expression":
            which = KINDS.index(kernel.integral_type), kernel.subdomains[0]
        addresses = [a for a in (library.oracle(*which) for library in self.libraries) if a]
        assert addresses, "FFCx wrote no such integral"
        A, number = np.zeros(int(np.prod(kernel.shape))), np.array([entity], dtype=np.intc)
        doubles = [a.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for a in (A, w, c, x)]
        for address in addresses:
            FUNCTION(address)(*doubles, number.ctypes.data_as(ctypes.POINTER(ctypes.c_int)), None)
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
