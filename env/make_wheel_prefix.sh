#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# env/make_wheel_prefix.sh SOURCES BUILD: what a wheel of this package is built against, in the folder BUILD:
#   BUILD/venv     a virtual environment with the wheel dolfinx-solver-real, nanobind 2.12 and scikit-build-core
#   BUILD/prefix   headers and libraries of that DOLFINx, with DOLFINXConfig.cmake: the wheel itself has no headers
# SOURCES is the folder that env/fetch_wheel_sources.sh fills. What is there already is not made again. PETSc is only
# configured, about a minute, for its petscconf.h; nothing of the sources is compiled. docs/wheel.md says why each
# version.
set -euo pipefail

[ $# = 2 ] || { sed -n '3,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 2; }
mkdir -p "$2"
sources=$(readlink -f -- "$1") build=$(readlink -f -- "$2")
venv=$build/venv python=$build/venv/bin/python prefix=$build/prefix
for folder in wheels dolfinx/cpp/dolfinx spdlog/include petsc-3.25.5 slepc-3.25.1/include; do
  [ -d "$sources/$folder" ] || { echo "make_wheel_prefix: there is no folder $sources/$folder" >&2; exit 1; }
done
# Another MPI, PETSc or Python of the system must not reach in.
unset PYTHONPATH PYTHONHOME LD_LIBRARY_PATH LD_PRELOAD PETSC_DIR PETSC_ARCH SLEPC_DIR VIRTUAL_ENV

if [ ! -e "$venv/.complete" ]; then
  rm -rf "$venv"
  python3 -m venv "$venv"
  "$venv/bin/pip" --disable-pip-version-check install --quiet --no-index --find-links "$sources/wheels" \
    dolfinx-solver-real==0.11.0.post0 "nanobind==2.12.*" "scikit-build-core>=0.10" pathspec
  "$python" -c 'import sys; sys.exit(sys.version_info < (3, 12))'
  touch "$venv/.complete"
fi
site=$("$python" -c 'import sysconfig; print(sysconfig.get_path("platlib"))')

if [ ! -e "$build/petsc/arch-real/include/petscconf.h" ]; then # by the wheel's own options, which libpetsc tells
  rm -rf "$build/petsc"
  cp -rL "$sources/petsc-3.25.5" "$build/petsc"
  (cd "$build/petsc" && python3 ./configure PETSC_ARCH=arch-real --with-mpi=1 --with-cc="$venv/bin/mpicc" \
    --with-cxx="$venv/bin/mpicxx" --with-fc=0 --with-scalar-type=real --with-precision=double --with-64-bit-indices=0 \
    --with-64-bit-blas-indices=0 --with-debugging=0 --with-shared-libraries=1 --with-openmp=0 \
    --with-fortran-bindings=0 --with-x=0 --with-make-np=1) >"$build/petsc_configure.log" 2>&1 ||
    { tail -n 25 "$build/petsc_configure.log" >&2; exit 1; }
fi

rm -rf "$prefix"
mkdir -p "$prefix/include" "$prefix/lib/cmake/dolfinx"
ln -s "$sources/dolfinx/cpp/dolfinx" "$sources/spdlog/include/spdlog" "$site/basix/include/basix" \
  "$site/ffcx/codegeneration/ufcx.h" "$build"/petsc/include/* "$sources"/slepc-3.25.1/include/slepc* \
  "$venv"/include/mpi*.h "$prefix/include/"
for header in "$build"/petsc/arch-real/include/*.h; do ln -sf "$header" "$prefix/include/"; done
# SLEPc's configure would need a PETSc that is built; its public headers read nothing else from this file.
echo '#define SLEPC_LIB_DIR ""' >"$prefix/include/slepcconf.h"
# HDF5: Debian's headers for a parallel library of the same release; <mpi.h> is the wheel's, which is found first.
for header in "${HDF5_INCLUDE:-/usr/include/hdf5/openmpi}"/{H5,hdf5}*.h; do
  [ -e "$header" ] ||
    { echo "make_wheel_prefix: HDF5's headers are not in ${header%/*}: set HDF5_INCLUDE" >&2; exit 1; }
  ln -s "$header" "$prefix/include/"
done
# The linker's names for the wheel's libraries; what is written into ours are their sonames.
for library in "$site"/dolfinx_solver/lib/lib*.so* "$site/basix/lib/libbasix.so" "$venv/lib/libmpi.so.12"; do
  name=${library##*/}
  ln -sf "$library" "$prefix/lib/$name"
  [ "$name" = "${name%%.so*}.so" ] || ln -sf "$library" "$prefix/lib/${name%%.so*}.so"
done
signature=$("$python" -c 'import ffcx.codegeneration as c; print(c.get_signature())')
cat >"$prefix/lib/cmake/dolfinx/DOLFINXConfig.cmake" <<CMAKE
get_filename_component(_prefix "\${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
set(DOLFINX_VERSION 0.11.0.0)
if(NOT TARGET dolfinx)
  add_library(dolfinx INTERFACE IMPORTED)
  target_compile_features(dolfinx INTERFACE cxx_std_20)
  target_include_directories(dolfinx SYSTEM INTERFACE \${_prefix}/include)
  # What DOLFINx's own build sets; and spdlog's code, which is in the library.
  target_compile_definitions(dolfinx INTERFACE HAS_PETSC HAS_SLEPC DOLFINX_VERSION="0.11.0" DOLFINX_GIT_COMMIT_HASH=""
    UFCX_SIGNATURE="$signature" MDSPAN_USE_PAREN_OPERATOR=1 MDSPAN_USE_BRACKET_OPERATOR=0 SPDLOG_COMPILED_LIB)
  target_link_libraries(dolfinx INTERFACE \${_prefix}/lib/libdolfinx.so \${_prefix}/lib/libpetsc.so
    \${_prefix}/lib/libslepc.so \${_prefix}/lib/libopenblas.so \${_prefix}/lib/libhdf5.so \${_prefix}/lib/libbasix.so
    \${_prefix}/lib/libmpi.so)
endif()
CMAKE
cat >"$prefix/lib/cmake/dolfinx/DOLFINXConfigVersion.cmake" <<CMAKE
set(PACKAGE_VERSION 0.11.0.0)
set(PACKAGE_VERSION_COMPATIBLE TRUE)
CMAKE
echo "make_wheel_prefix: $prefix"
