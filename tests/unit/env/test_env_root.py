# SPDX-License-Identifier: MIT
"""env/run's root route: built once, under a lock, never half; and what it says when it cannot be built."""

import os
import re
import signal
import time

import pytest

pytestmark = pytest.mark.waits


def wait_for(condition, seconds=20):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


@pytest.mark.alone
def test_the_first_start_builds_and_the_second_does_not(sandbox):
    first = sandbox.run("true")
    assert first.returncode == 0, first.stderr_text
    assert "2 minutes" in first.stderr_text
    (root,) = sandbox.roots()
    start = time.monotonic()
    second = sandbox.run("true")
    assert time.monotonic() - start < 2.0  # the promise of the issue
    assert (second.returncode, second.stderr_text) == (0, "")
    assert len(sandbox.calls("mmdebstrap")) == 1
    assert sandbox.calls("enter") == [f"enter {root}"] * 2
    assert sandbox.leftovers() == []


def test_the_list_reaches_mmdebstrap_without_comments(sandbox):
    sandbox.packages("# why\nalpha beta\n\ngamma # this one\n")
    sandbox.run("true")
    (call,) = sandbox.calls("mmdebstrap")
    assert "--include=alpha,beta,gamma trixie " in call


def test_the_key_follows_the_packages_and_nothing_else(sandbox):
    sandbox.run("true")
    sandbox.packages("# other words\nalpha\n\nbeta\n")
    sandbox.run("true")
    assert len(sandbox.roots()) == 1
    sandbox.packages("alpha\nbeta\ngamma\n")
    sandbox.run("true")
    assert len(sandbox.roots()) == 2
    assert len(sandbox.calls("mmdebstrap")) == 2


def test_a_failing_build_says_so_and_leaves_nothing(sandbox):
    failed = sandbox.run("true", FAKE_MMDEBSTRAP_STATUS=25)
    assert failed.returncode == 1
    assert "the mirror is on fire" in failed.stderr_text  # the end of mmdebstrap's own log
    assert "the root could not be made" in failed.stderr_text and ".log" in failed.stderr_text
    assert sandbox.roots() == [] and sandbox.leftovers() == []
    assert sandbox.run("true").returncode == 0
    assert len(sandbox.roots()) == 1


@pytest.mark.parametrize("whole_session", [True, False], ids=["everything killed", "only env/run killed"])
def test_a_killed_build_is_not_taken_for_a_finished_one(sandbox, whole_session):
    process = sandbox.start("true", FAKE_MMDEBSTRAP_SECONDS=2 if not whole_session else 60)
    wait_for(sandbox.leftovers)
    (os.killpg if whole_session else os.kill)(process.pid, signal.SIGKILL)
    process.communicate()
    assert sandbox.roots() == []
    # What is left of the first build still holds the lock until it ends: the next one waits, then starts afresh.
    again = sandbox.run("true")
    assert again.returncode == 0, again.stderr_text
    assert len(sandbox.roots()) == 1 and sandbox.leftovers() == []
    assert len(sandbox.calls("mmdebstrap")) == 2


@pytest.mark.parametrize("sig", [signal.SIGTERM, signal.SIGHUP])
def test_a_build_asked_to_stop_stops(sandbox, sig):
    sandbox.stub("mmdebstrap", 'mkdir -p "${!#}"; echo $$ >"$CALLS"; exec sleep 60')
    process = sandbox.start("true")
    wait_for(lambda: sandbox.calls_file.exists() and sandbox.calls_file.read_text().strip())
    builder = int(sandbox.calls_file.read_text())
    os.kill(process.pid, sig)
    process.communicate(timeout=20)
    assert process.returncode == 128 + sig
    assert sandbox.roots() == []
    with pytest.raises(ProcessLookupError):
        os.kill(builder, 0)


def test_two_first_starts_build_once(sandbox):
    first = sandbox.start("echo", "first", FAKE_MMDEBSTRAP_SECONDS=2)
    wait_for(sandbox.leftovers)
    second = sandbox.run("echo", "second", FAKE_MMDEBSTRAP_SECONDS=2)
    out, _ = first.communicate(timeout=20)
    assert (out, first.returncode) == ("first\n", 0)
    assert (second.stdout_text, second.returncode) == ("second\n", 0)
    assert "waiting" in second.stderr_text
    assert len(sandbox.calls("mmdebstrap")) == 1


def test_a_running_command_does_not_hold_the_lock(sandbox):
    long = sandbox.start("sleep", "30")
    wait_for(lambda: sandbox.calls("enter"))
    sandbox.packages("alpha\nanother\n")
    start = time.monotonic()
    assert sandbox.run("true").returncode == 0
    assert time.monotonic() - start < 15
    os.killpg(long.pid, signal.SIGKILL)
    long.communicate()


def test_no_right_to_mount(sandbox):
    answer = sandbox.run("true", FAKE_MOUNT_STATUS=1)
    assert answer.returncode == 1
    assert "may not mount" in answer.stderr_text and "env/Containerfile" in answer.stderr_text
    assert sandbox.calls("mmdebstrap") == []  # found out before two minutes of work


def test_no_room(sandbox):
    answer = sandbox.run("true", FAKE_FREE_MB=100)
    assert answer.returncode == 1
    assert "100 MB free" in answer.stderr_text and "IMPACT_CACHE" in answer.stderr_text
    assert sandbox.calls("mmdebstrap") == []


def test_a_cache_that_cannot_be_written(sandbox, tmp_path):
    (tmp_path / "a file").write_text("in the way")
    answer = sandbox.run("true", XDG_CACHE_HOME=tmp_path / "a file")
    assert answer.returncode == 1
    assert "cannot write in" in answer.stderr_text and "IMPACT_CACHE" in answer.stderr_text


def test_mmdebstrap_is_installed_when_missing(sandbox):
    text = (sandbox.bin / "mmdebstrap").read_text()
    (sandbox.bin / "mmdebstrap").unlink()
    failed = sandbox.run("true", FAKE_APT_STATUS=100)
    assert failed.returncode == 1 and "mmdebstrap is missing" in failed.stderr_text
    body = text.replace("#!/bin/bash\n", "", 1)
    sandbox.stub("apt-get", f"cat >{str(sandbox.bin / 'mmdebstrap')!r} <<'END'\n#!/bin/bash\n{body}\nEND\n"
                 f"chmod +x {str(sandbox.bin / 'mmdebstrap')!r}")  # fmt: skip
    assert sandbox.run("true").returncode == 0
    assert len(sandbox.calls("mmdebstrap")) == 1


def test_a_root_of_an_old_list_goes_after_30_days(sandbox):
    sandbox.run("true")
    (old,) = sandbox.roots()
    long_ago = time.time() - 31 * 86400
    os.utime(old, (long_ago, long_ago))
    sandbox.run("true")  # entered today: it stays
    sandbox.packages("alpha\ngamma\n")
    sandbox.run("true")
    assert old in sandbox.roots()
    os.utime(old, (long_ago, long_ago))
    sandbox.packages("alpha\ndelta\n")
    sandbox.run("true")
    assert not old.exists() and len(sandbox.roots()) == 2


def test_the_cache_folder_is_where_it_was_asked_for(sandbox, tmp_path):
    sandbox.run("true", cwd=tmp_path, IMPACT_CACHE="relative place")
    assert list((tmp_path / "relative place").glob("root-*/.complete"))
    sandbox.run("true", XDG_CACHE_HOME=None)
    assert list((tmp_path / ".cache" / "dolfinx_impact").glob("root-*/.complete"))


COUNTED = """
mkdir -p "${!#}/var/lib/dpkg" "${!#}/var/cache/apt/archives"
cd "${!#}"
echo "I: downloading packages with apt..."
touch var/cache/apt/archives/{1..HALF}.deb; sleep 3
echo "I: installing remaining packages inside the chroot..."
for i in {1..ALL}; do
  if [ $i -le HALF ]; then echo "Status: install ok installed"; else echo "Status: install ok unpacked"; fi
done >var/lib/dpkg/status
sleep 3"""


def test_a_root_in_the_making_reports_its_progress(sandbox):
    """Downloaded, unpacked, set up: a third each. First half of the packages are downloaded; then half are set up."""
    packages = int(re.search(r"^root_packages=(\d+)", (sandbox.checkout / "env" / "run").read_text(), re.M)[1])
    half = packages // 2
    sandbox.stub("mmdebstrap", COUNTED.replace("ALL", str(packages)).replace("HALF", str(half)))
    answer = sandbox.run("true", IMPACT_PROGRESS_SECONDS=1)
    assert answer.returncode == 0, answer.stderr_text
    lines = [line for line in answer.stderr_text.splitlines() if " % " in line]
    for report in (
        rf"env/run: root: 16 % \(0 of about {packages} packages, downloading packages with apt\.\.\.\), \d+ s",
        rf"env/run: root: 83 % \({half} of about {packages} packages, installing remaining packages inside .*\), \d+ s",
    ):
        assert any(re.fullmatch(report, line) for line in lines), lines
    assert len(lines) <= 8


def test_progress_ends_with_env_run(sandbox):
    """Killed alone, env/run leaves mmdebstrap behind, but nothing that holds the pipes of its caller open."""
    process = sandbox.start("true", FAKE_MMDEBSTRAP_SECONDS=30, IMPACT_PROGRESS_SECONDS=1)
    wait_for(sandbox.leftovers)
    time.sleep(1.5)  # the watcher is at work
    os.kill(process.pid, signal.SIGKILL)
    process.communicate(timeout=10)  # TimeoutExpired if something else writes there
    os.killpg(process.pid, signal.SIGKILL)
