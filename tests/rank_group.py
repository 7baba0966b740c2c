# SPDX-License-Identifier: MIT
"""Ranks that stay: many checks, one start of mpirun."""

import json
import pathlib
import select
import shutil
import socket
import subprocess
import sys
import tempfile
import time

from processes import kill_session, mpi_environment, start_session


class RankFailure(Exception):
    """What the ranks that failed said."""


class RankGroup:
    """Ranks started by one mpirun that perform requests one after the other; see rank_process.py.

    A request fails when one rank raises, ends or does not reply in time. The ranks are then started anew for the next
    request: those that did not raise may still wait for the others, and messages may be on their way.
    """

    start_limit = 120.0  # seconds until all ranks have connected
    grace = 10.0  # seconds for the other ranks once one has failed

    def __init__(self, size):
        self.size = size
        self.starts = 0
        self._process, self._streams, self._folder = None, [], None

    def call(self, timeout, **request):
        """Perform a request on all ranks.

        Args:
            timeout: limit of this request [s].
            request: what rank_process.py documents.

        Returns:
            what each rank printed.

        Raises:
            RankFailure: with traceback, or lack of a reply, of every rank that failed, and what the ranks printed.
        """
        if self._process is None:
            self._start()
        printed = self._log.stat().st_size
        line = (json.dumps({**request, "timeout": timeout}) + "\n").encode()
        for stream in self._streams:
            try:
                stream.sendall(line)
            except OSError:
                pass  # the rank has ended: no reply comes
        try:
            replies = self._replies(timeout)
        except BaseException:  # Ctrl-C, the time limit of a test: replies to come are not those to the next request
            self.kill()
            raise
        if any("failure" in reply for reply in replies):
            self.kill(keep_log=True)
            text = [f"rank {rank}: {r['failure']}" for rank, r in enumerate(replies) if "failure" in r]
            with open(self._log, errors="replace") as log:
                log.seek(printed)
                text.append(f"printed by the {self.size} ranks:\n{log.read()}")
            self._clean()
            raise RankFailure("\n".join(text))
        return [reply["output"] for reply in replies]

    def close(self):
        """Let the ranks end by themselves; returns the exit status of mpirun, 0 if none is running."""
        if self._process is None:
            return 0
        for stream in self._streams:
            stream.close()
        try:
            status = self._process.wait(60)
        except subprocess.TimeoutExpired:
            status = None
        self.kill()
        return status

    def kill(self, keep_log=False):
        """End the ranks, whatever they do."""
        for stream in self._streams:
            stream.close()
        if self._process is not None:
            kill_session(self._process)
        self._process, self._streams = None, []
        if not keep_log:
            self._clean()

    def _clean(self):
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
        self._folder = None

    def _start(self):
        self.starts += 1
        self._folder = pathlib.Path(tempfile.mkdtemp(prefix="ranks-"))  # a socket's name is short
        self._log, address = self._folder / "log", self._folder / "socket"
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as listener:
            listener.bind(str(address))
            listener.listen(self.size)
            listener.settimeout(0.2)
            script = pathlib.Path(__file__).with_name("rank_process.py")
            command = ["mpirun", "-n", self.size, sys.executable, "-u", "-m", "mpi4py", script, address]
            with open(self._log, "wb") as out:
                self._process = start_session(command, out, mpi_environment())
            end = time.monotonic() + self.start_limit
            while len(self._streams) < self.size:
                try:
                    self._streams.append(listener.accept()[0])
                except TimeoutError:
                    if self._process.poll() is not None or time.monotonic() > end:
                        text = self._log.read_text(errors="replace")
                        self.kill()
                        raise RankFailure(f"{self.size} ranks could not be started:\n{text}") from None
        greetings = self._replies(self.start_limit)
        if any("failure" in greeting for greeting in greetings):
            self.kill()
            raise RankFailure(f"{self.size} ranks could not be started: {greetings}")
        order = sorted(range(self.size), key=lambda i: greetings[i]["rank"])
        self._streams = [self._streams[i] for i in order]

    def _replies(self, timeout):
        """One reply of each rank, in the order of the streams; {"failure": words} where none came."""
        end = time.monotonic() + timeout
        said = {stream: b"" for stream in self._streams}
        replies, waiting, late = {}, set(self._streams), f"did not finish within {timeout:g} s"
        while waiting:
            ready, _, _ = select.select(list(waiting), [], [], max(0.0, end - time.monotonic()))
            if not ready:
                break
            for stream in ready:
                try:
                    data = stream.recv(1 << 16)
                except ConnectionError:
                    data = b""
                said[stream] += data
                if said[stream].endswith(b"\n"):
                    replies[stream] = json.loads(said[stream])
                elif not data:
                    replies[stream] = {"failure": "ended"}
                if stream in replies:
                    waiting.remove(stream)
                    if "failure" in replies[stream] and time.monotonic() + self.grace < end:
                        end = time.monotonic() + self.grace
                        late = f"still ran {self.grace:g} s after another rank had failed"
        return [replies.get(stream, {"failure": late}) for stream in self._streams]
