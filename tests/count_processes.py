# SPDX-License-Identifier: MIT
"""Let every process of this Python count the lines it runs when COVERAGE_PROCESS_START names a file of settings.

A file *.pth in the folder of packages is read when Python starts: first the folder in which coverage lies, which is
another one where a virtual environment uses the packages of the system, then the call.
"""

import pathlib
import subprocess
import sys
import sysconfig

import coverage


def write(folder):
    """Write the file."""
    lies_in = pathlib.Path(coverage.__file__).resolve().parents[1]
    file = pathlib.Path(folder) / "count_processes.pth"
    file.write_text(f"{lies_in}\nimport coverage; coverage.process_startup()\n")


if __name__ == "__main__":
    write(sysconfig.get_path("purelib"))
    # A file that cannot be read is a warning on standard error, and nothing would be counted.
    said = subprocess.run([sys.executable, "-c", ""], capture_output=True, text=True, check=True).stderr
    if said:
        raise SystemExit(f"processes cannot be counted:\n{said}")
