# SPDX-License-Identifier: MIT
"""The command, in a process of its own that does not outlive the test."""

import os
import signal
import subprocess
import sys

import pytest


@pytest.fixture
def impact(tmp_path):
    """impact(*arguments, timeout=300, env=None) -> (exit status, output, errors) of dolfinx-impact."""

    def run(*arguments, timeout=300, env=None):
        command = [sys.executable, "-m", "dolfinx_impact.cli", *map(str, arguments)]
        process = subprocess.Popen(
            command,
            cwd=tmp_path,
            env={**os.environ, "IMPACT_DEMO_FAST": "1", **(env or {})},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        try:
            output, errors = process.communicate(timeout=timeout)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGTERM)  # mpirun ends its ranks
            try:
                output, errors = process.communicate(timeout=10)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                output, errors = process.communicate()
            pytest.fail(f"{command} did not end within {timeout} s:\n{output}\n{errors}")
        return process.returncode, output, errors

    return run
