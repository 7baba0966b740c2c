# SPDX-License-Identifier: MIT
"""Kernels of sabotaged forms stay out of the user's cache."""

import pytest


@pytest.fixture(scope="session")
def cache_of_the_session(tmp_path_factory):
    return tmp_path_factory.mktemp("kernels")


@pytest.fixture
def own_cache(cache_of_the_session, monkeypatch):
    """Kernels compiled in this test go to a folder that the tests throw away."""
    monkeypatch.setenv("IMPACT_JIT_CACHE", str(cache_of_the_session))
    return cache_of_the_session
