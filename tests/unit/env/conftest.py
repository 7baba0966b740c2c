# SPDX-License-Identifier: MIT
"""A checkout of its own for env/run, with stand-ins for the programs that would change the machine."""

import os
import pathlib
import shutil
import subprocess

import pytest

# Each stand-in notes its call in $CALLS. The environment's own python3 is a stand-in too: DOLFINx is there when
# $FAKE_DOLFINX exists. Nothing here depends on the system the tests run on.
STUBS = {
    "python3": """
case "$*" in
  *"import dolfinx"*) [ -e "$FAKE_DOLFINX" ] ;;
  "-m venv"*) venv=${!#}; mkdir -p "$venv/bin" "$venv/lib"; cp -- "$0" "$venv/bin/python3" ;;
  *sysconfig*) echo "$(cd -- "$(dirname -- "$0")/.." && pwd)/lib" ;;
  *env/refresh.py*) echo "refresh $*" >>"$CALLS"; echo "refresh was here"; exit ${FAKE_REFRESH_STATUS:-0} ;;
  *"-m pip"*) echo pip >>"$CALLS"; echo "pip was here"; sleep "${FAKE_PIP_SECONDS:-0}"; exit ${FAKE_PIP_STATUS:-0} ;;
esac""",
    "id": 'echo "${FAKE_UID:-0}"',
    "apt-get": """
echo "apt-get $*" >>"$CALLS"
case "$*" in *install*) [ "${FAKE_APT_STATUS:-0}" = 0 ] && touch "$FAKE_DOLFINX" ;; esac""",
    "mmdebstrap": """
echo "mmdebstrap $*" >>"$CALLS"
mkdir -p "${!#}/usr"
sleep "${FAKE_MMDEBSTRAP_SECONDS:-0}"
echo "E: the mirror is on fire"
exit "${FAKE_MMDEBSTRAP_STATUS:-0}" """,
    # "unshare --mount -- mount ..." asks whether mounting is allowed; otherwise the script that enters the root follows
    "unshare": """
shift 2
if [ "$1" = mount ]; then exit "${FAKE_MOUNT_STATUS:-0}"; fi
root=$5 checkout=$6; shift 7
[ -e "$root/.complete" ] || exit 99
echo "enter $root" >>"$CALLS"
exec /bin/bash "$checkout/env/inside" "$@" """,
    "df": 'printf "Filesystem blocks Used Available Use Mounted\\nx 1 1 %s 1 /\\n" "${FAKE_FREE_MB:-99999}"',
}


class Sandbox:
    def __init__(self, folder, source, commands):
        self.checkout = folder / "a checkout"
        self.cache = folder / "the cache" / "dolfinx_impact"
        self.calls_file = folder / "calls"
        self.dolfinx = folder / "dolfinx is there"
        self.bin = folder / "bin"
        shutil.copytree(source / "env", self.checkout / "env")
        self.packages("alpha\nbeta # and why\n")
        self.bin.mkdir()
        for name, text in STUBS.items():
            self.stub(name, text)
        self.env = {
            "PATH": f"{self.bin}:{commands}",
            "HOME": str(folder),
            "XDG_CACHE_HOME": str(self.cache.parent),
            "CALLS": str(self.calls_file),
            "FAKE_DOLFINX": str(self.dolfinx),
            "IMPACT_ENV": "root",
        }

    def stub(self, name, text):
        path = self.bin / name
        path.unlink(missing_ok=True)
        path.write_text("#!/bin/bash\n" + text + "\n")
        path.chmod(0o755)

    def prefix(self, folder, works=True):
        """A DOLFINx installed in a folder of its own; its python3 imports it, or not."""
        cmake = folder / "lib" / "cmake" / "dolfinx" / "DOLFINXConfig.cmake"
        for path in (cmake, folder / "bin" / "python3"):
            path.parent.mkdir(parents=True, exist_ok=True)
        cmake.touch()
        text = (self.bin / "python3").read_text().replace('[ -e "$FAKE_DOLFINX" ]', str(works).lower())
        (folder / "bin" / "python3").write_text(text)
        (folder / "bin" / "python3").chmod(0o755)
        return folder

    def packages(self, text):
        (self.checkout / "env" / "packages.txt").write_text(text)

    def start(self, *command, cwd="/", **env):
        """Begin an env/run with its output in pipes; a variable set to None is taken away."""
        wanted = {k: str(v) for k, v in {**self.env, **env}.items() if v is not None}
        return subprocess.Popen(
            [self.checkout / "env" / "run", *command],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=wanted,
            cwd=cwd,
            start_new_session=True,
        )

    def run(self, *command, stdin="", timeout=60, **kwargs):
        process = self.start(*command, **kwargs)
        try:
            process.stdout_text, process.stderr_text = process.communicate(stdin, timeout)
        finally:
            if process.poll() is None:
                os.killpg(process.pid, 9)
        return process

    def calls(self, name):
        lines = self.calls_file.read_text().splitlines() if self.calls_file.exists() else []
        return [line for line in lines if line.split()[0] == name]

    def roots(self):
        """Folders a start would take for a finished root."""
        return [p for p in self.cache.glob("root-*") if (p / ".complete").exists()]

    def leftovers(self):
        return list(self.cache.glob("root-*.partial"))


@pytest.fixture(scope="session")
def commands(tmp_path_factory):
    """Folder with all commands of this system, except those with a stand-in: nothing real is reached by accident."""
    found = tmp_path_factory.mktemp("commands")
    for folder in ("/usr/bin", "/bin", "/usr/sbin", "/sbin"):
        for command in os.scandir(folder):
            link = found / command.name
            if command.name not in STUBS and not link.is_symlink():
                link.symlink_to(command.path)
    return found


@pytest.fixture
def sandbox(tmp_path, checkout, commands):
    return Sandbox(pathlib.Path(tmp_path), checkout, commands)
