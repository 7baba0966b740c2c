#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# env/build_wheel.sh SOURCES BUILD: a wheel of this package for DOLFINx 0.11 from the package index
# (dolfinx-solver-real), in BUILD: one file for Python 3.12 and newer, on x86-64 with glibc and libstdc++ as new as here
# (Debian 13, Ubuntu 24.04). It is built from a copy of the sources, whose dependencies are those of the wheel
# (env/wheel_metadata.py), and checked: stable interface, no folder of this machine in a search path, no second DOLFINx
# among the dependencies. SOURCES: see env/fetch_wheel_sources.sh. `env/run --no-build env/build_wheel.sh ...` brings
# Debian 13's compiler.
set -euo pipefail

checkout=$(CDPATH='' cd -- "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/.." && pwd -P)
[ $# = 2 ] || { sed -n '3,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 2; }
"$checkout/env/make_wheel_prefix.sh" "$1" "$2"
build=$(readlink -f -- "$2")
venv=$build/venv python=$build/venv/bin/python
unset PYTHONPATH PYTHONHOME LD_LIBRARY_PATH LD_PRELOAD PETSC_DIR PETSC_ARCH SLEPC_DIR VIRTUAL_ENV

# Compilations are found again by ccache only under the same paths.
copy=$build/copy
rm -rf "$copy" && mkdir -p "$copy"
(cd "$checkout" && cp -rp pyproject.toml README.md LICENSE cpp forms meshes python demos "$copy/")
find "$copy" -name __pycache__ -prune -exec rm -rf {} +
python3 "$checkout/env/wheel_metadata.py" "$copy/pyproject.toml"

echo "build_wheel: compiling (log: $build/wheel.log)"
rm -f "$build"/dolfinx_impact-*.whl
# site-packages/../.. is the environment's lib, where the MPI of the index is.
PATH=$venv/bin:$PATH CMAKE_PREFIX_PATH=$build/prefix "$venv/bin/pip" --disable-pip-version-check wheel --verbose \
  --no-deps --no-build-isolation --no-index -w "$build" \
  --config-settings=wheel.py-api=cp312 --config-settings=build-dir="$build/release" \
  "--config-settings=cmake.define.IMPACT_WHEEL_LIBRARIES=dolfinx_solver/lib;basix/lib;dolfinx_solver_real.libs;../.." \
  "$copy" >"$build/wheel.log" 2>&1 || { tail -n 40 "$build/wheel.log" >&2; exit 1; }

wheel=$(ls "$build"/dolfinx_impact-*.whl)
[[ $wheel == *-cp312-abi3-* ]] ||
  { echo "build_wheel: $wheel is not for the stable interface of Python 3.12" >&2; exit 1; }
python3 - "$wheel" "$build" <<'PYTHON'
import re, subprocess, sys, tempfile, zipfile
from pathlib import Path

wheel, build = sys.argv[1:]
with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(wheel) as archive:
    archive.extractall(folder)
    metadata = next(Path(folder).glob("*.dist-info/METADATA")).read_text()
    for name in ("fenics-dolfinx", "petsc4py", "slepc4py"):
        assert not re.search(rf"^Requires-Dist: {name}\b", metadata, re.MULTILINE), f"the wheel asks for {name}"
    assert "Requires-Dist: dolfinx-solver-real==0.11.0.post0\n" in metadata, metadata
    libraries = sorted(Path(folder).rglob("*.so"))
    assert [p.name for p in libraries] == ["_cpp.abi3.so", "libdolfinx_impact.so", "_reference.abi3.so"], libraries
    newest = {}
    for path in libraries:
        text = subprocess.run(["readelf", "-dVW", path], check=True, capture_output=True, text=True).stdout
        found = re.search(r"\((RPATH|RUNPATH)\).*\[(.*)\]", text)
        assert found is None or all(part.startswith("$ORIGIN") for part in found[2].split(":")), found[2]
        assert found is None or found[1] == "RPATH", f"{path.name} has a RUNPATH"
        for kind, version in re.findall(r"Name: (GLIBC|GLIBCXX)_([0-9.]+)", text):
            newest[kind] = max(newest.get(kind, (0,)), tuple(map(int, version.split("."))))
        needed = re.findall(r"\(NEEDED\).*\[(.*)\]", text)
        print(f"{path.relative_to(folder)}: {path.stat().st_size / 1e6:.1f} MB, needs {' '.join(needed)}")
    print(", ".join(f"{kind}_{'.'.join(map(str, number))}" for kind, number in sorted(newest.items())), "or newer")
print(f"build_wheel: {wheel}, {Path(wheel).stat().st_size / 1e6:.1f} MB")
PYTHON
