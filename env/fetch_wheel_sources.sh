#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# env/fetch_wheel_sources.sh SOURCES [DOLFINX SPDLOG]: fill the folder SOURCES with what env/build_wheel.sh needs, by
# pip from the package index: the wheel dolfinx-solver-real with all that it and this package need, for this Python, in
# SOURCES/wheels; PETSc's and SLEPc's sources, for their headers. The headers of DOLFINx 0.11.0.post0 and spdlog 1.10.0
# are in no package of the index: DOLFINX and SPDLOG are checkouts of those tags; without these arguments
# SOURCES/dolfinx and SOURCES/spdlog have to be there. What is there already is not fetched again.
set -euo pipefail

[ $# = 1 ] || [ $# = 3 ] || { sed -n '3,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 2; }
mkdir -p "$1/wheels" "$1/sdist"
sources=$(readlink -f -- "$1")
if [ $# = 3 ]; then
  ln -sfnT "$(readlink -f -- "$2")" "$sources/dolfinx"
  ln -sfnT "$(readlink -f -- "$3")" "$sources/spdlog"
fi
pip() { python3 -m pip --disable-pip-version-check "$@"; }
pip download --quiet -d "$sources/wheels" --find-links "$sources/wheels" --only-binary=:all: \
  dolfinx-solver-real==0.11.0.post0 "nanobind==2.12.*" "scikit-build-core>=0.10" pathspec \
  scipy matplotlib rich h5py "pydantic>=2" jinja2 gmsh pyvista
for source in petsc-3.25.5 slepc-3.25.1; do
  [ -d "$sources/$source" ] && continue
  [ -e "$sources/sdist/$source.tar.gz" ] ||
    pip download --quiet -d "$sources/sdist" --no-deps --no-binary :all: --no-build-isolation \
      "${source%-*}==${source#*-}"
  tar xzf "$sources/sdist/$source.tar.gz" -C "$sources"
done
for folder in dolfinx/cpp/dolfinx spdlog/include/spdlog; do
  [ -d "$sources/$folder" ] || { echo "fetch_wheel_sources: there is no folder $sources/$folder" >&2; exit 1; }
done
