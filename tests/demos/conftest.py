# SPDX-License-Identifier: MIT
"""The command, in a process of its own and in that of the tests; demos have processes that do not outlive the test."""

import os
import signal
import subprocess
import sys
import threading

import pytest

from dolfinx_impact import cli

FAST = {"IMPACT_DEMO_FAST": "1"}


@pytest.fixture
def command(tmp_path):
    """command(*arguments) -> (exit status, output, errors) of `dolfinx-impact`, as a shell starts it."""

    def run(*arguments):
        done = subprocess.run(
            [sys.executable, "-m", "dolfinx_impact.cli", *map(str, arguments)],
            cwd=tmp_path,
            env={**os.environ, **FAST},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=100,
        )
        return done.returncode, done.stdout, done.stderr

    return run


@pytest.fixture
def impact(tmp_path, monkeypatch, capfd):
    """impact(*arguments, timeout=300, env=None) -> (exit status, output, errors) of the command.

    It runs in the tests' process, which has imported the package already; a demo has a process of its own all the same.
    """
    started = []

    class Session(subprocess.Popen):
        """The demo and its ranks can be ended together."""

        def __init__(self, *args, **kwargs):
            super().__init__(*args, stdin=subprocess.DEVNULL, start_new_session=True, **kwargs)
            started.append(self)

    def end():
        late.append(True)
        for process, how in ((p, how) for p in started for how in (signal.SIGTERM, signal.SIGKILL)):
            try:
                if process.poll() is None:
                    os.killpg(process.pid, how)  # mpirun ends its ranks
                    process.wait(10)
            except (ProcessLookupError, subprocess.TimeoutExpired):
                pass

    late = []

    def run(*arguments, timeout=300, env=None):
        with monkeypatch.context() as patch:
            patch.chdir(tmp_path)
            patch.setattr(cli.subprocess, "Popen", Session)
            for name, value in {**FAST, **(env or {})}.items():
                patch.setenv(name, value)
            capfd.readouterr()
            timer = threading.Timer(timeout, end)
            timer.start()
            try:
                status = cli.main([str(a) for a in arguments])
            except SystemExit as ended:  # argparse
                status = ended.code
            finally:
                timer.cancel()
                if any(p.poll() is None for p in started):  # the test itself is interrupted
                    end()
        output, errors = capfd.readouterr()
        if late:
            pytest.fail(f"{arguments} did not end within {timeout} s:\n{output}\n{errors}")
        return status, output, errors

    return run
