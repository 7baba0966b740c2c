# SPDX-License-Identifier: MIT
"""The typed stub of the compiled module is that of the bindings."""

import importlib.util
import pathlib

import pytest

CHECKOUT = pathlib.Path(__file__).parents[2]
COMMITTED = CHECKOUT / "python" / "dolfinx_impact" / "_cpp"


def _writer():
    specification = importlib.util.spec_from_file_location("stub", CHECKOUT / "cpp" / "bindings" / "stub.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


FRESH = _writer().stubs()


def test_there_is_a_file_for_each_submodule():
    assert sorted(path.name for path in COMMITTED.glob("*.pyi")) == sorted(FRESH)


@pytest.mark.parametrize("name", sorted(FRESH))
def test_the_stub_is_that_of_the_bindings(name):
    assert (COMMITTED / name).read_text() == FRESH[name], f"{name} is stale: run `make stub` and commit its files"


@pytest.mark.parametrize("name", sorted(FRESH))
def test_signatures_have_no_names_of_cpp(name):
    """A type that is bound nowhere is printed by its name in C++, and one without parameters says nothing of them."""
    code = [line for line in FRESH[name].splitlines() if '"""' not in line]
    assert not [line for line in code if "::" in line or "std." in line]
    bare = ("dict", "list", "tuple", "Callable")
    assert not [
        line
        for line in code
        if any(
            f"{end} {word}{after}" in line for word in bare for end in (":", "->") for after in (",", ":", ")", " |")
        )
    ]
