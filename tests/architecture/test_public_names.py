# SPDX-License-Identifier: MIT
"""Public names and signatures are those of public_names.txt: a change of them is seen in review."""

import dataclasses
import enum

import public_names
import pytest


def test_public_names_are_those_of_the_list():
    changes = public_names.difference(public_names.read(), public_names.lines())
    assert not changes, (
        "public names or signatures are not those of tests/architecture/public_names.txt (- listed, + there):\n"
        + "\n".join(changes)
        + "\nIf this is meant, docs/compatibility.md says how; then `make public-names` writes the list anew."
    )


def test_the_list_has_what_users_call():
    listed = public_names.read()
    assert len(listed) > 300
    for name in ("dolfinx_impact.StaticProblem(", "dolfinx_impact.ExplicitProblem.advance(", "dolfinx_impact.theory"):
        assert any(line.startswith(name) for line in listed), name
    assert listed == sorted(listed)


class Parent:
    def kept(self, a, *, b=1):
        """A method that is inherited."""


class Child(Parent):
    level = 3

    def __init__(self, x, y=2.0, *args, z="text", **more):
        pass

    @property
    def fixed(self):
        """Read only."""

    @property
    def free(self):
        """Can be set."""

    @free.setter
    def free(self, value):
        pass

    @classmethod
    def make(cls, path, how=len):
        """A second way to make one."""

    def _hidden(self):
        pass


class Kind(enum.Enum):
    open, stick = 0, 1


def test_signatures_have_names_and_defaults_and_no_types(monkeypatch):
    monkeypatch.setattr(public_names, "OWN", (Child.__module__,))
    assert public_names.signature(Child) == "(x, y=2.0, *args, z='text', **more)"
    assert list(public_names.members("m.Child", Child)) == [
        "m.Child.fixed", "m.Child.free, can be set", "m.Child.kept(a, *, b=1)", "m.Child.level",
        "m.Child.make(path, how=<len>)",
    ]  # fmt: skip
    assert public_names._default(Kind.stick) == "Kind.stick"
    assert public_names._default(object()) == "<object>"
    fields = dataclasses.make_dataclass("Fields", [("names", list, dataclasses.field(default_factory=list))])
    assert public_names.signature(fields) == "(names=<made anew>)"


@pytest.mark.parametrize(
    "old, new, change",
    [
        ("a.f(x)", "a.f(x, y=1)", ["- a.f(x)", "+ a.f(x, y=1)"]),
        ("a.f(x)", None, ["- a.f(x)"]),
        (None, "a.g()", ["+ a.g()"]),
        ("a.f(x)", "a.f(x)", []),
    ],
)
def test_differences_are_told(old, new, change):
    same = ["a.same"]
    listed, there = same + [old] * (old is not None), same + [new] * (new is not None)
    assert public_names.difference(listed, there) == change


def test_names_of_the_pages_are_found_with_their_module(tmp_path):
    (tmp_path / "docs" / "api").mkdir(parents=True)
    text = ".. currentmodule:: dolfinx_impact.io\n.. autoclass:: A\n.. autofunction:: dolfinx_impact.f\n"
    (tmp_path / "docs" / "api" / "a.md").write_text(text)
    assert public_names.shown(tmp_path) == ["dolfinx_impact.io.A", "dolfinx_impact.f"]
    with pytest.raises(ImportError):
        public_names.found("no_such_package.name")
