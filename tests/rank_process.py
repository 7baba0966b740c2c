# SPDX-License-Identifier: MIT
"""What each rank of a RankGroup runs: `rank_process.py ADDRESS` performs the requests that come through a socket.

A request is one line of JSON, and so is the reply. {"module": PATH, "check": NAME, "timeout": SECONDS} calls a function
of a module; {"script": PATH, "arguments": [...], "timeout": SECONDS} runs a script with its standard output in the
reply. A rank that waits for a request sleeps. Whatever a request raises is a reply: the rank goes on.
"""

import contextlib
import faulthandler
import gc
import importlib
import io
import json
import pathlib
import runpy
import socket
import sys
import traceback

from helper_folders import put_on_path
from idle_rank import keep_idle_as_asked
from mpi4py import MPI
from rotated_partitions import rotate_partitions


def call_check(module, check):
    """Import a module as pytest does, with its folder on the path, and call one of its functions."""
    path = pathlib.Path(module)
    if str(path.parent) not in sys.path:
        sys.path.insert(0, str(path.parent))
    known = path.stem in sys.modules
    found = importlib.import_module(path.stem)
    if not known:  # what it imported stays: the collections after each check need not look at it again
        gc.collect()
        gc.freeze()
    getattr(found, check)()
    return ""


def run_script(script, arguments):
    """Run a script as if it had been started with these arguments; returns what it printed."""
    output, before = io.StringIO(), (list(sys.argv), list(sys.path))
    sys.argv = [script, *arguments]
    sys.path.insert(0, str(pathlib.Path(script).parent))
    try:
        with contextlib.redirect_stdout(output):
            runpy.run_path(script, run_name="__main__")
    finally:
        sys.argv, sys.path[:] = before
    return output.getvalue()


def perform(request, timeout):
    """Reply to a request: what it printed, or the traceback of what it raised."""
    # A rank that hangs tells where, before it is killed.
    faulthandler.dump_traceback_later(0.9 * timeout, file=sys.__stderr__)
    try:
        return {"output": run_script(**request) if "script" in request else call_check(**request)}
    except BaseException:  # also SystemExit and KeyboardInterrupt: the ranks stay together
        return {"failure": traceback.format_exc()}
    finally:
        faulthandler.cancel_dump_traceback_later()


def main(address):
    put_on_path()
    keep_idle_as_asked()
    rotate_partitions()
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    connection.connect(address)
    stream = connection.makefile("rw")

    def send(message):
        stream.write(json.dumps(message) + "\n")
        stream.flush()

    send({"rank": MPI.COMM_WORLD.rank})
    for line in stream:
        request = json.loads(line)
        reply = perform(request, request.pop("timeout"))
        gc.collect()  # meshes and PETSc objects free their communicators at the same place on all ranks
        send(reply)


if __name__ == "__main__":
    main(sys.argv[1])
