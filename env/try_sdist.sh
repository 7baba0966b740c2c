#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# env/try_sdist.sh [FOLDER]: does the source distribution build without the checkout? Makes it, unpacks it in an empty
# folder, builds a wheel of it in a fresh virtual environment, and runs a demo from there. FOLDER, build/sdist without,
# then has the archive. `make sdist` runs this inside the environment, whose DOLFINx and build tools are used.
set -euo pipefail

checkout=$(CDPATH='' cd -- "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/.." && pwd -P)
mkdir -p "${1:-$checkout/build/sdist}"
target=$(readlink -f -- "${1:-$checkout/build/sdist}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python=$(PATH=${PATH//"$checkout/build/venv/bin:"/} command -v python3) # not the one that has the checkout's install
step() { # NAME COMMAND...: quiet when it works, the end of its log when not
  local name=$1 start=$SECONDS; shift
  if "$@" >"$work/log" 2>&1; then echo "sdist: $name ($((SECONDS - start)) s)"; else
    echo "sdist: $name: failed"; tail -n 30 "$work/log"; exit 1
  fi
}

rm -f "$target"/dolfinx_impact-*.tar.gz
step "archive made" "$python" -m build --sdist --no-isolation --outdir "$target" "$checkout"
archive=$(ls "$target"/dolfinx_impact-*.tar.gz)
mkdir "$work/source" "$work/wheel" "$work/run"
tar xzf "$archive" -C "$work/source"
source=$(ls -d "$work"/source/*)
[ ! -e "$source/.git" ] && [ ! -e "$source/build" ] || { echo "sdist: has files of the checkout" >&2; exit 1; }
export CCACHE_BASEDIR=$work
step "virtual environment" "$python" -m venv --system-site-packages "$work/venv"
pip=("$work/venv/bin/python" -m pip --disable-pip-version-check)
step "wheel built from the archive" "${pip[@]}" wheel --verbose --no-deps \
  --no-build-isolation --no-index -w "$work/wheel" "$source"
step "wheel installed" "${pip[@]}" install --no-deps --no-index "$work"/wheel/*.whl
rm -rf "$source"
cd "$work/run"
step "demo hertz" env PATH="$work/venv/bin:/usr/bin:/bin" dolfinx-impact demo hertz
grep "peak pressure" "$work/log"
[ -s results/hertz/hertz.png ]
echo "sdist: $archive, $(stat -c %s "$archive" | awk '{ printf "%.1f MB", $1 / 1e6 }')"
