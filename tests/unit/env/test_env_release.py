# SPDX-License-Identifier: MIT
"""make TARGET RELEASE=0.11 takes another DOLFINx, which env/build_dolfinx.sh builds; what both say if they cannot."""

import shutil
import subprocess

import pytest


@pytest.fixture
def make(sandbox, checkout):
    """make(*words, **variables) -> the process: the Makefile of this checkout, with stand-ins for other programs."""
    shutil.copy(checkout / "Makefile", sandbox.checkout)

    def run(*words, **variables):
        return subprocess.run(
            ["make", *words], cwd=sandbox.checkout, env={**sandbox.env, **variables}, capture_output=True, text=True
        )

    return run


def environment(text):
    return dict(line.split("=", 1) for line in text.splitlines() if "=" in line)


def test_release_names_the_prefix_in_the_cache(sandbox, make):
    prefix = sandbox.prefix(sandbox.cache / "dolfinx-0.11")
    sandbox.stub("bash", "exec /bin/bash -c env")
    done = make("shell", "RELEASE=0.11")
    assert environment(done.stdout).get("IMPACT_DOLFINX") == str(prefix), done.stderr
    done = make("shell", "RELEASE=0.11", IMPACT_CACHE=str(sandbox.cache), XDG_CACHE_HOME="/nowhere")
    assert environment(done.stdout).get("IMPACT_DOLFINX") == str(prefix), done.stderr


@pytest.mark.parametrize("release", [(), ("RELEASE=0.9",)], ids=["none", "0.9"])
def test_without_a_release_it_is_debian_s(sandbox, make, release):
    sandbox.stub("bash", "exec /bin/bash -c env")
    done = make("shell", *release)
    assert done.returncode == 0 and "IMPACT_DOLFINX" not in done.stdout, done.stderr


def test_a_release_that_is_missing_names_the_command_that_makes_it(sandbox, make):
    done = make("test", "RELEASE=0.11")
    where = f"{sandbox.cache}/dolfinx-0.11"
    assert done.returncode == 2 and done.stdout == ""
    assert f"""'env/run --no-build env/build_dolfinx.sh 0.11 "{where}" SOURCES'""" in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_inside_the_environment_the_release_was_chosen(make):
    """make test-here, which make test calls there, must not look for it again."""
    assert make("-n", "test-here", "RELEASE=0.11", IMPACT_ROUTE="root", IMPACT_CACHE="/nowhere").returncode == 0


def test_types_are_checked_with_debian_s_dolfinx_alone(sandbox, make):
    sandbox.stub("python3", 'echo "python3 $*" >>"$CALLS"')
    done = make("types-here", IMPACT_DOLFINX="/opt/dolfinx-0.11")
    assert done.returncode == 0 and "types are checked with DOLFINx 0.9 alone" in done.stderr
    assert sandbox.calls("python3") == []
    assert make("types-here").returncode == 0
    assert any("-m mypy" in call for call in sandbox.calls("python3"))


@pytest.fixture
def sources(tmp_path):
    """Folders that look like those of DOLFINx 0.11 and what it needs."""
    for name in ("basix", "ffcx", "ufl", "dolfinx/python"):
        (tmp_path / "sources" / name).mkdir(parents=True)
    (tmp_path / "sources/dolfinx/python/pyproject.toml").write_text('[project]\nversion = "0.11.0.post0"\n')
    return tmp_path / "sources"


@pytest.fixture
def build(checkout, tmp_path):
    def run(release, sources, prefix=tmp_path / "prefix"):
        command = [checkout / "env" / "build_dolfinx.sh", release, prefix, sources]
        return subprocess.run(command, capture_output=True, text=True)

    return run


def test_the_build_says_how_it_is_used(checkout):
    done = subprocess.run([checkout / "env" / "build_dolfinx.sh", "0.11"], capture_output=True, text=True)
    assert done.returncode == 2 and "env/build_dolfinx.sh RELEASE PREFIX SOURCES" in done.stderr


def test_the_build_refuses_what_it_cannot_build(build, sources, tmp_path):
    def said(*words):
        done = build(*words)
        assert done.returncode == 1 and len(done.stderr.splitlines()) == 1, done.stderr
        return done.stderr

    assert "0.10 or 0.11, not '0.12'" in said("0.12", sources)
    assert "is DOLFINx 0.11, not 0.10" in said("0.10", sources)
    (sources / "ufl").rmdir()
    assert f"there is no folder {sources}/ufl" in said("0.11", sources)
    (sources / "ufl").mkdir()
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "letter").touch()
    assert "holds something else" in said("0.11", sources, tmp_path / "full")
    assert not (tmp_path / "prefix").exists()


def test_a_finished_build_is_left_as_it_is(build, sources, tmp_path):
    prefix = tmp_path / "prefix"
    (prefix / "build").mkdir(parents=True)
    (prefix / "pyvenv.cfg").touch()
    (prefix / "build" / "complete").write_text("0.11\n")
    done = build("0.11", sources)
    assert (done.returncode, done.stderr) == (0, f"build_dolfinx: {prefix} has DOLFINx 0.11 already\n")
