#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# env/try_package.sh BUILD WHEELS [DEMO...]: does `pip install` of the wheel in BUILD give a package that works? As an
# ordinary user, in a fresh virtual environment of this Python with nothing of the caller's environment, without a
# network:
#   - pip install dolfinx_impact, from BUILD and the folder WHEELS (env/fetch_wheel_sources.sh)
#   - without a compiler: `dolfinx-impact info`, a static and an explicit demo on one and two ranks; a form that is
#     compiled at run time is refused in one sentence
#   - with the system's compiler: each DEMO (hertz bar_on_wall rail_joint without) on one and two ranks
# Prints each fact as "holds" or "FAILS"; exit status 0 if all hold. Started as root, it becomes the user nobody.
# `env/run --no-build env/try_package.sh ...` has Debian 13's Python; RANKS="1 2" are the numbers of ranks.
set -euo pipefail

[ $# -ge 2 ] || { sed -n '3,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 2; }
build=$(readlink -f -- "$1") wheels=$(readlink -f -- "$2")
shift 2
[ $# -gt 0 ] || set -- hertz bar_on_wall rail_joint
ls "$build"/dolfinx_impact-*-abi3-*.whl >/dev/null || { echo "try_package: there is no wheel in $build" >&2; exit 1; }
work=$(mktemp -d /tmp/try_package.XXXXXX)
trap 'rm -rf "$work"' EXIT
# Another user may not read the caller's folders.
mkdir "$work/wheels" "$work/home" "$work/tools"
cp "$build"/dolfinx_impact-*.whl "$wheels"/*.whl "$work/wheels/"
user=()
if [ "$(id -u)" = 0 ]; then
  chown -R nobody "$work"
  user=(setpriv --reuid=nobody --regid=nogroup --clear-groups)
fi
# Programs that a virtual environment and MPI's launcher may call, and no compiler.
for tool in sh bash env cat hostname uname dirname basename readlink sed grep ldconfig; do
  path=$(command -v "$tool" || true)
  [ -z "$path" ] || ln -s "$path" "$work/tools/$tool"
done
venv=$work/venv
clean() { # PATH COMMAND...: as the user, with nothing of the environment
  local path=$1; shift
  (cd "$work/home" &&
    exec timeout 1800 "${user[@]}" env -i PATH="$path" HOME="$work/home" LC_ALL=C.UTF-8 TMPDIR="$work/home" "$@")
}
bare=$venv/bin:$work/tools full=$venv/bin:/usr/bin:/bin
failed=0
fact() { # NAME COMMAND...
  local name=$1 start=$SECONDS; shift
  if "$@" >"$work/log" 2>&1; then echo "holds  $name ($((SECONDS - start)) s)"; else
    echo "FAILS  $name:"; tail -n 15 "$work/log" | cut -c1-300; failed=1
  fi
}
refused() { # WORDS COMMAND...: it ends with one sentence, not with a compiler's error alone
  local words=$1 status=0; shift
  clean "$bare" "$@" || status=$?
  [ "$status" != 0 ] && tail -n 1 "$work/log" | grep "RuntimeError: $words"
}
form='
import dolfinx_impact, ufl
from dolfinx import mesh
from mpi4py import MPI
from dolfinx_impact.assembly.ffcx_form import ffcx_form
square = mesh.create_unit_square(MPI.COMM_SELF, 2, 2)
ffcx_form(ufl.SpatialCoordinate(square)[0] * ufl.dx)'
one_of_each() { # libraries of the kind that must be in a process once, and not from the system
  clean "$full" python -c 'import dolfinx_impact, pathlib, re
maps = pathlib.Path("/proc/self/maps").read_text()
for name in ("mpi", "petsc", "slepc", "dolfinx", "basix", "hdf5"):
    found = sorted(set(re.findall(rf"/\S*/lib{name}[-.]\S*", maps)))
    print(name, found)
    own = [f for f in found if "/h5py.libs/" not in f]  # h5py brings an HDF5 of its own, under a hashed name
    assert len(own) == 1 and "/site-packages/" in own[0] or name == "mpi" and "/venv/lib/" in own[0], found'
}

fact "virtual environment" clean "$full" python3 -m venv "$venv"
fact "pip install, as $(clean "$full" id -un)" clean "$full" pip --disable-pip-version-check install --no-index \
  --find-links "$work/wheels" "dolfinx_impact[viz]"
[ "$failed" = 0 ] || exit 1
fact "each library once" one_of_each
fact "without a compiler: info" clean "$bare" dolfinx-impact info
for ranks in ${RANKS:-1 2}; do
  for demo in bar_on_wall hertz; do
    fact "without a compiler: $demo, ranks: $ranks" clean "$bare" dolfinx-impact demo "$demo" --ranks "$ranks"
  done
done
fact "without a compiler: a form of DOLFINx is refused in one sentence" refused "no C compiler was found" \
  python -c "$form"
fact "without a compiler: a kernel that is made at run time, too" refused "no C++ compiler was found" \
  dolfinx-impact demo own_form --output "$work/home/refused"
for demo in "$@"; do
  for ranks in ${RANKS:-1 2}; do
    fact "$demo, ranks: $ranks" clean "$full" dolfinx-impact demo "$demo" --ranks "$ranks"
    { grep -v '^$' "$work/log" || true; } | tail -n 4 | cut -c1-160 | sed 's/^/         /'
  done
done
exit "$failed"
