# SPDX-License-Identifier: MIT
"""What a wheel needs instead of DOLFINx under its own name: `wheel_metadata.py PYPROJECT` changes that file, a copy.

The wheel `dolfinx-solver-real` has DOLFINx, petsc4py and slepc4py inside, without metadata of theirs. A wheel of ours
that named them would make pip look for a second DOLFINx, and `import dolfinx_solver` refuses an environment that has
one. The names of its libraries have hashes that change with each build, so exactly one version is named. A marker in
pyproject.toml cannot say this, as both kinds of DOLFINx are for the same systems; scikit-build-core's overrides do not
reach `project.dependencies`. So a build from a copy of the sources changes the list, and nothing else has to know.
"""

import re
import sys
from pathlib import Path

SOLVER = "dolfinx-solver-real==0.11.0.post0"
INSIDE = {"fenics-dolfinx", "petsc4py", "slepc4py"}
PYTHON = ">=3.12"


def name_of(requirement):
    """Name of the distribution that a requirement asks for, as indexes compare it."""
    return re.sub(r"[-_.]+", "-", re.match(r"[A-Za-z0-9._-]+", requirement).group()).lower()


def for_wheel(text):
    """The text of a pyproject.toml with the requirements of the wheel.

    Raises:
        ValueError: it has another form than expected.
    """
    found = re.search(r"^dependencies = \[(.*?)^\]", text, re.MULTILINE | re.DOTALL)
    if not found:
        raise ValueError("pyproject.toml has no list of dependencies over several lines")
    wanted = re.findall(r'"([^"]+)"', found.group(1))
    if not INSIDE <= {name_of(one) for one in wanted}:
        raise ValueError(f"{', '.join(sorted(INSIDE))} are not all among the dependencies: {wanted}")
    kept = [SOLVER, *(one for one in wanted if name_of(one) not in INSIDE)]
    lines = "".join(f'  "{one}",\n' for one in kept)
    text = f"{text[: found.start()]}dependencies = [\n{lines}]{text[found.end() :]}"
    text, count = re.subn(r'^requires-python = "[^"]*"', f'requires-python = "{PYTHON}"', text, flags=re.MULTILINE)
    if count != 1:
        raise ValueError("pyproject.toml has no line requires-python")
    return text


if __name__ == "__main__":
    path = Path(sys.argv[1])
    path.write_text(for_wheel(path.read_text()))
