# SPDX-License-Identifier: MIT
"""refresh.py BUILD SITE: bring an install up to date with sources that changed, where none came or went.

BUILD is CMake's build folder, SITE the folder that packages are installed in. What changed is compiled, and changed
files are copied: a few seconds less than building a wheel and installing it anew. env/inside calls it, in the checkout,
and leaves all other changes to pip.
"""

import filecmp
import pathlib
import shutil
import subprocess
import sys
import tomllib


def changed(source: pathlib.Path, target: pathlib.Path) -> bool:
    """Whether a file is not in the install as it is among the sources."""
    return not target.is_file() or not filecmp.cmp(source, target, shallow=False)


def refresh_python(checkout: pathlib.Path, site: pathlib.Path) -> list[pathlib.Path]:
    """Copy the files of the Python packages that changed, and return them; pyproject.toml says where packages lie."""
    settings = tomllib.loads((checkout / "pyproject.toml").read_text())
    copied = []
    for package, folder in settings["tool"]["scikit-build"]["wheel"]["packages"].items():
        for source in sorted((checkout / folder).rglob("*")):
            target = site / package / source.relative_to(checkout / folder)
            if source.is_file() and "__pycache__" not in source.parts and changed(source, target):
                # A file of its own in the place of the old one, which a running process may have open.
                fresh = target.with_name(target.name + ".new")
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(source, fresh)
                fresh.replace(target)
                copied.append(target)
    return copied


def main(build: str, site: str) -> None:
    subprocess.run(["cmake", "--build", build], check=True)
    subprocess.run(["cmake", "--install", build, "--prefix", site, "--strip"], check=True, stdout=subprocess.DEVNULL)
    for target in refresh_python(pathlib.Path.cwd(), pathlib.Path(site)):
        print("copied", target)


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except subprocess.CalledProcessError as error:
        sys.exit(error.returncode)
