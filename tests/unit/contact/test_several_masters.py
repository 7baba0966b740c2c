# SPDX-License-Identifier: MIT
"""Several masters for one slave; the checks on ranks are in several_masters_checks.py."""

import numpy as np
import pytest
import several_masters_checks
from dolfinx import mesh
from mpi4py import MPI
from on_ranks import rank_tests
from several_masters_checks import *  # noqa: F401, F403

import dolfinx_impact as di

test_one_rank, test_several_ranks = rank_tests(several_masters_checks)


@pytest.mark.parametrize(
    "master, error, text",
    [
        ([], ValueError, "the list of masters is empty"),
        ([4, 4], ValueError, "have a tag twice"),
        ([4, 3], ValueError, "same tag 3"),
        ([4, "top"], TypeError, "integer"),
        ([4, di.RigidPlane((0, 0), (0, 1))], TypeError, "make a pair with each rigid obstacle"),
    ],
)
def test_lists_that_are_no_masters(master, error, text):
    square = mesh.create_unit_square(MPI.COMM_SELF, 1, 1)
    tags = mesh.meshtags(square, 1, np.array([0], dtype=np.int32), np.array([3], dtype=np.int32))
    with pytest.raises(error, match=text):
        di.ContactPair(tags, 3, master)


def test_a_list_of_one_is_a_tag():
    square = mesh.create_unit_square(MPI.COMM_SELF, 1, 1)
    tags = mesh.meshtags(square, 1, np.array([0], dtype=np.int32), np.array([3], dtype=np.int32))
    pair = di.ContactPair(tags, 3, np.array([4]))
    assert pair.master == 4 and pair.name == "3 on 4"
