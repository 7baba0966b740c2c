#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# env/try_wheel.sh WHEELS DOLFINX PETSC SLEPC SPDLOG FMT [BUILD]: can a C++ module share types and libraries with
# DOLFINx 0.11 from the wheel dolfinx-solver-real? Builds the module of env/wheel_probe against that wheel in a virtual
# environment of its own, runs it on one and two ranks, and prints each fact as "holds" or "FAILS"; exit status 0 if all
# hold. docs/wheel.md says what was found. `env/run --no-build env/try_wheel.sh ...` brings Debian 13's compiler.
#
#   WHEELS   files of `pip download -d WHEELS dolfinx-solver-real==0.11.0.post0 nanobind==2.12.0`, for this Python
#   DOLFINX  folder with dolfinx/mesh/Mesh.h of 0.11.0.post0: cpp/ of the source, or usr/include of libdolfinx-dev
#   PETSC    source of PETSc 3.25.5; a copy is configured, about a minute, and nothing of it is compiled
#   SLEPC    source of SLEPc 3.25
#   SPDLOG   source of spdlog 1.10.0, and
#   FMT      source of fmt 8.1.1: the versions that libdolfinx was linked to; their functions are inline in part
#   BUILD    where to build, and to find the logs; build/wheel_probe
set -euo pipefail

checkout=$(CDPATH='' cd -- "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/.." && pwd -P)
[ $# -ge 6 ] || { sed -n '3,/^set/{/^#/s/^# \{0,1\}//p}' "$checkout/env/try_wheel.sh"; exit 2; }
for folder in "${@:1:6}"; do [ -d "$folder" ] || { echo "try_wheel: there is no folder $folder" >&2; exit 2; }; done
for i in 1 2 3 4 5 6; do folders[i]=$(readlink -f -- "${!i}"); done
mkdir -p "${7:-$checkout/build/wheel_probe}"
build=$(readlink -f -- "${7:-$checkout/build/wheel_probe}")
# What the system has of MPI, PETSc and Python packages must not reach in.
unset PYTHONPATH PYTHONHOME LD_LIBRARY_PATH LD_PRELOAD PETSC_DIR PETSC_ARCH SLEPC_DIR VIRTUAL_ENV
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 XDG_CACHE_HOME=$build/cache PYTHONDONTWRITEBYTECODE=1
venv=$build/venv python=$build/venv/bin/python

step() { # NAME COMMAND...: quiet when it works, the end of its log when not
  local name=$1 log=$build/${1// /_}.log start=$SECONDS; shift
  if "$@" >"$log" 2>&1; then echo "done   $name ($((SECONDS - start)) s)"; else
    echo "FAILS  $name; the log is $log:"; tail -n 25 "$log"; exit 1
  fi
}

make_venv() {
  [ -x "$python" ] || python3 -m venv "$venv"
  "$venv/bin/pip" --disable-pip-version-check install --no-index --find-links "${folders[1]}" \
    dolfinx-solver-real==0.11.0.post0 nanobind==2.12.0
  "$python" -c 'import sys; sys.exit(sys.version_info < (3, 12))'
}

configure_petsc() { # petscconf.h by the wheel's own options; packages that PETSc calls do not show in its headers
  [ -e "$build/petsc/arch-real/include/petscconf.h" ] && return
  rm -rf "$build/petsc"
  cp -r "${folders[3]}" "$build/petsc"
  cd "$build/petsc"
  python3 ./configure PETSC_ARCH=arch-real --with-mpi=1 --with-cc="$venv/bin/mpicc" --with-cxx="$venv/bin/mpicxx" \
    --with-fc=0 --with-scalar-type=real --with-precision=double --with-64-bit-indices=0 --with-64-bit-blas-indices=0 \
    --with-debugging=0 --with-shared-libraries=1 --with-openmp=0 --with-fortran-bindings=0 --with-x=0 --with-make-np=1
}

build_module() {
  # Beside the packages of the wheel, as a module of ours would be installed; the path is relative to it. An RPATH, like
  # that of the wheel's libraries: LD_LIBRARY_PATH does not come before it.
  cmake -S "$checkout/env/wheel_probe" -B "$build/module" -DPython_EXECUTABLE="$python" -DSITE="$site" \
    -DNANOBIND="$site/nanobind/cmake" -DDOLFINX="${folders[2]}" -DPETSC="$build/petsc" -DSLEPC="${folders[4]}" \
    -DSPDLOG="${folders[5]}/include" -DFMT="${folders[6]}/include"
  cmake --build "$build/module" -j1
  mkdir -p "$site/wheel_probe"
  cp "$build/module/_exchange.abi3.so" "$site/wheel_probe/"
  touch "$site/wheel_probe/__init__.py"
}

same_tags() { # of nanobind: modules with other tags do not see each other's types
  local tags
  tags=$(for module in "$site"/{basix/_basixcpp,dolfinx/cpp,wheel_probe/_exchange}.abi3.so; do
    grep -aoE '\bv[0-9]+_system_[a-z0-9_]*stable' "$module" | head -n 1; done | sort -u)
  echo "$tags"
  [ "$(echo "$tags" | wc -l)" = 1 ]
}

step "wheel and nanobind in a virtual environment" make_venv
site=$("$python" -c 'import sysconfig; print(sysconfig.get_path("platlib"))')
step "PETSc configured with the MPI of the wheel" configure_petsc
step "module compiled and linked" build_module
step "one tag of nanobind" same_tags
failed=0
for ranks in 1 2; do
  timeout 600 "$venv/bin/mpiexec" -n "$ranks" "$python" "$checkout/env/wheel_probe/exchange.py" || failed=1
done
exit "$failed"
