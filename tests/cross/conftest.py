# SPDX-License-Identifier: MIT
"""Kernels of sabotaged forms stay out of the user's cache."""

import functools

import pytest
from dolfinx_impact.assembly import jit


@pytest.fixture(scope="session")
def cache_of_the_session(tmp_path_factory):
    return tmp_path_factory.mktemp("kernels")


@pytest.fixture
def own_cache(cache_of_the_session, monkeypatch):
    """Kernels compiled in this test go to a folder that the tests throw away. They run for a moment only: -O1 compiles
    them in half the time."""
    monkeypatch.setenv("IMPACT_JIT_CACHE", str(cache_of_the_session))
    monkeypatch.setattr(jit, "FLAGS", ["-O1" if flag == "-O3" else flag for flag in jit.FLAGS])
    monkeypatch.setattr(jit, "_compiler", functools.lru_cache(jit._compiler.__wrapped__))  # it remembers the flags
    return cache_of_the_session
