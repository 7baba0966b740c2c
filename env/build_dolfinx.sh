#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# env/build_dolfinx.sh RELEASE PREFIX SOURCES: build DOLFINx RELEASE (0.10, 0.11) in Debian 13, against its real PETSc
# and SLEPc, Open MPI, HDF5, ADIOS2 and SCOTCH, into the new folder PREFIX. Enter Debian 13 with env/run:
#
#   env/run --no-build env/build_dolfinx.sh 0.11 ~/.cache/dolfinx_impact/dolfinx-0.11 SOURCES
#   make test RELEASE=0.11    # or IMPACT_DOLFINX=PREFIX env/run CMD
#
#   SOURCES  folder with the four sources of that release, in basix, ffcx, ufl and dolfinx; they are only read
#   PREFIX   becomes a virtual environment of Python over Debian's packages, in which this release hides Debian's 0.9;
#            it also holds the C++ headers, libraries and CMake files
#
# About 35 minutes on two cores. One that was interrupted goes on where it stopped, with the sources as they were; a
# finished PREFIX is left as it is. The logs are PREFIX/build/STEP.log. JOBS=N builds N files at a time (all cores).
set -euo pipefail

say() { printf 'build_dolfinx: %s\n' "$*" >&2; }
die() { say "$*"; exit 1; }
[ $# = 3 ] || { sed -n '3,/^set/{/^#/s/^# \{0,1\}//p}' "$0" >&2; exit 2; }

# What the caller's shell says of Python, PETSc and CMake must not reach in.
if [ -z "${BUILD_DOLFINX_CLEAN-}" ]; then
  exec env -i BUILD_DOLFINX_CLEAN=1 PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
    HOME="${HOME:-/tmp}" LC_ALL=C.UTF-8 TMPDIR="${TMPDIR:-/tmp}" ${JOBS:+JOBS="$JOBS"} \
    ${CCACHE_DIR:+CCACHE_DIR="$CCACHE_DIR"} \
    ${IMPACT_PROGRESS_SECONDS:+IMPACT_PROGRESS_SECONDS="$IMPACT_PROGRESS_SECONDS"} /bin/bash "$0" "$@"
fi

release=$1
case $release in
  0.10 | 0.11) ;;
  *) die "RELEASE is 0.10 or 0.11, not '$release'" ;;
esac
for package in basix ffcx ufl dolfinx; do
  [ -d "$3/$package" ] || die "there is no folder $3/$package: SOURCES holds basix, ffcx, ufl and dolfinx"
done
sources=$(readlink -f -- "$3")
found=$(sed -n 's/^version = "\([0-9]*\.[0-9]*\).*/\1/p' "$sources/dolfinx/python/pyproject.toml" | head -n 1)
[ "$found" = "$release" ] || die "$sources/dolfinx is DOLFINx ${found:-of an unknown release}, not $release"
[ "$(. /etc/os-release && echo "${VERSION_CODENAME-}")" = trixie ] ||
  die "this is not Debian 13: env/run --no-build enters it"
for tool in cmake ninja ccache python3 mpiexec; do
  command -v $tool >/dev/null || die "$tool is not installed: env/packages.txt lists what is needed"
done
[ ! -e "$2" ] || [ -e "$2/pyvenv.cfg" ] || [ -z "$(ls -A "$2")" ] || die "$2 holds something else: name a new folder"
mkdir -p "$2/build" || die "cannot write in $2"
prefix=$(readlink -f -- "$2")
. "$(dirname -- "$0")/progress"
progress_name=build_dolfinx

python=$prefix/bin/python3 build=$prefix/build jobs=${JOBS:-$(nproc)}
export PATH=$prefix/bin:$PATH CMAKE_GENERATOR=Ninja CMAKE_BUILD_PARALLEL_LEVEL=$jobs CMAKE_PREFIX_PATH=$prefix
export CMAKE_CXX_COMPILER_LAUNCHER=ccache CMAKE_C_COMPILER_LAUNCHER=ccache CCACHE_BASEDIR=$build CCACHE_NOHASHDIR=1
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_btl=self,sm
export PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1

# step NAME COMMAND...: COMMAND in a subshell, once; NAME.log has what it printed.
steps=8 number=0
step() {
  local name=$1 log=$build/$1.log start=$SECONDS status; shift
  number=$((number + 1))
  if [ -e "$build/$name.done" ]; then say "[$number/$steps] $name: done before"; return; fi
  say "[$number/$steps] $name"
  : >"$log"
  begin_progress install_state "$log"
  set +e # in "... || status=$?" the commands of a step would go on after one that failed
  (set -e; "$@") </dev/null >"$log" 2>&1 7>&-
  status=$?
  set -e
  end_progress
  if [ $status != 0 ]; then
    tail -n 40 "$log" >&2
    die "$name failed; the whole log is $log. Run this again to go on from there"
  fi
  touch "$build/$name.done"
  say "[$number/$steps] $name: $((SECONDS - start)) s"
}

begin() {
  rm -rf "$build/sources"
  mkdir "$build/sources"
  for package in basix ffcx ufl dolfinx; do cp -r "$sources/$package" "$build/sources/"; done
  [ -x "$python" ] || /usr/bin/python3 -m venv --system-site-packages "$prefix" --without-pip
  # Debian has SCOTCH without the CMake file that DOLFINx looks for.
  mkdir -p "$prefix/lib/cmake/SCOTCH"
  cat >"$prefix/lib/cmake/SCOTCH/SCOTCHConfig.cmake" <<'END'
# Targets of Debian's SCOTCH, which brings no CMake file.
find_path(SCOTCH_INCLUDE_DIR ptscotch.h PATH_SUFFIXES scotch REQUIRED)
find_package(MPI REQUIRED COMPONENTS CXX)
foreach(name scotcherr ptscotcherr scotch ptscotch)
  find_library(SCOTCH_${name}_LIBRARY ${name} REQUIRED)
  if(NOT TARGET SCOTCH::${name})
    add_library(SCOTCH::${name} UNKNOWN IMPORTED)
    set_target_properties(
      SCOTCH::${name} PROPERTIES IMPORTED_LOCATION ${SCOTCH_${name}_LIBRARY}
                                 INTERFACE_INCLUDE_DIRECTORIES ${SCOTCH_INCLUDE_DIR})
  endif()
endforeach()
target_link_libraries(SCOTCH::ptscotch INTERFACE SCOTCH::scotch SCOTCH::ptscotcherr MPI::MPI_CXX)
set(SCOTCH_FOUND TRUE)
END
  cat >"$prefix/lib/cmake/SCOTCH/SCOTCHConfigVersion.cmake" <<'END'
file(STRINGS /usr/include/scotch/scotch.h lines REGEX "#define SCOTCH_(VERSION|RELEASE|PATCHLEVEL) ")
string(REGEX REPLACE "[^0-9]*([0-9]+)[^0-9]+([0-9]+)[^0-9]+([0-9]+).*" "\\1.\\2.\\3" PACKAGE_VERSION "${lines}")
if(PACKAGE_VERSION VERSION_GREATER_EQUAL PACKAGE_FIND_VERSION)
  set(PACKAGE_VERSION_COMPATIBLE TRUE)
endif()
END
}

pip_install() {
  "$python" -m pip --disable-pip-version-check install --verbose --no-build-isolation --no-index --no-deps \
    --no-cache-dir --force-reinstall "$@"
}

cmake_install() { # SOURCE NAME OPTION...: a C++ library
  local source=$1 name=$2; shift 2
  cmake -S "$source" -B "$build/$name" -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$prefix" \
    -DCMAKE_INSTALL_LIBDIR=lib -DPython3_EXECUTABLE="$python" "$@"
  cmake --build "$build/$name"
  cmake --install "$build/$name" >/dev/null
}

basix_library() { cmake_install "$build/sources/basix/cpp" basix; }

basix_python() { pip_install --config-settings=build-dir="$build/basix_python" "$build/sources/basix/python"; }

# Several sources are compiled as one: their common headers are most of the work.
dolfinx_library() {
  cmake_install "$build/sources/dolfinx/cpp" dolfinx -DDOLFINX_BASIX_PYTHON=OFF -DDOLFINX_ENABLE_PETSC=ON \
    -DDOLFINX_ENABLE_SLEPC=ON -DDOLFINX_ENABLE_SCOTCH=ON -DDOLFINX_ENABLE_ADIOS2=ON -DDOLFINX_ENABLE_PARMETIS=OFF \
    -DDOLFINX_ENABLE_KAHIP=OFF -DDOLFINX_ENABLE_SUPERLU_DIST=OFF \
    -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=8
}

dolfinx_python() {
  # Not for the files of nanobind, which is compiled there, too.
  echo 'cmake_language(DEFER CALL set_target_properties cpp PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 3)' \
    >"$build/unity.cmake"
  pip_install --config-settings=build-dir="$build/dolfinx_python" \
    --config-settings=cmake.define.CMAKE_PROJECT_INCLUDE="$build/unity.cmake" "$build/sources/dolfinx/python"
  # Debian's library of PETSc has another name.
  sed -i 's/"libpetsc\.dylib"/"libpetsc_real.so"/' "$prefix"/lib/python3.*/site-packages/dolfinx/fem/petsc.py
}

# -u'' = 1 with u = x (1 - x) / 2 on the boundary of the square: the quadratic element has it exactly.
check() {
  cd "$build"
  for ranks in 1 2; do
    timeout 600 mpiexec -n "$ranks" "$python" - "$release" <<'END'
import sys
from pathlib import Path

import basix
import ffcx
import numpy as np
import ufl
from mpi4py import MPI
from petsc4py import PETSc

import dolfinx
from dolfinx import fem, mesh
from dolfinx.fem import petsc

for package in (dolfinx, basix, ffcx, ufl):
    assert Path(package.__file__).is_relative_to(sys.prefix), f"{package.__name__} is {package.__file__}"
assert dolfinx.__version__.startswith(sys.argv[1] + "."), dolfinx.__version__
assert petsc.get_petsc_lib().name == "libpetsc_real.so"
assert dolfinx.has_petsc and dolfinx.has_slepc and dolfinx.has_adios2 and dolfinx.has_ptscotch
square = mesh.create_unit_square(MPI.COMM_WORLD, 16, 16)
space = fem.functionspace(square, ("Lagrange", 2))
u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
exact = fem.Function(space)
exact.interpolate(lambda x: x[0] * (1 - x[0]) / 2)
facets = mesh.locate_entities_boundary(square, 1, lambda x: np.isclose(x, 0).any(0) | np.isclose(x[:2], 1).any(0))
condition = fem.dirichletbc(exact, fem.locate_dofs_topological(space, 1, facets))
a, rhs = fem.form(ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx), fem.form(fem.Constant(square, 1.0) * v * ufl.dx)
matrix = petsc.assemble_matrix(a, [condition])
matrix.assemble()
vector = petsc.assemble_vector(rhs)
petsc.apply_lifting(vector, [a], [[condition]])
vector.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
condition.set(vector.array_w)
solver = PETSc.KSP().create(MPI.COMM_WORLD)
solver.setOperators(matrix)
solver.setType("preonly")
solver.getPC().setType("lu")
solver.getPC().setFactorSolverType("mumps")
solution = fem.Function(space)
solver.solve(vector, solution.x.petsc_vec)
solution.x.scatter_forward()
error = np.abs(solution.x.array - exact.x.array).max()
assert error < 1e-12, error
print(f"DOLFINx {dolfinx.__version__}: Poisson on {square.comm.size} ranks, largest error {error:.1e}")
END
  done
}

if [ -e "$prefix/build/complete" ]; then say "$prefix has DOLFINx $(cat "$prefix/build/complete") already"; exit 0; fi
start=$SECONDS
step begin begin
step ufl pip_install "$build/sources/ufl"
step basix_library basix_library
step basix_python basix_python
step ffcx pip_install "$build/sources/ffcx"
step dolfinx_library dolfinx_library
step dolfinx_python dolfinx_python
step check check
grep -h '^DOLFINx ' "$build/check.log" >&2
rm -rf "$build"/{sources,basix,basix_python,dolfinx,dolfinx_python}
echo "$release" >"$build/complete"
say "DOLFINx $release is in $prefix ($(((SECONDS - start + 30) / 60)) minutes); IMPACT_DOLFINX=$prefix env/run uses it"
