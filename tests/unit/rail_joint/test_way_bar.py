# SPDX-License-Identifier: MIT
"""Progress of a passage, and materials of end posts."""

import io
import sys
from types import SimpleNamespace

import pytest
from mpi4py import MPI

from impact_studies.rail_joint import EndPost, RailJoint
from impact_studies.rail_joint.parameters import END_POSTS
from impact_studies.rail_joint.way_bar import WayBar


@pytest.mark.parametrize("wanted", [True, False])
def test_the_place_of_the_wheel_is_shown(wanted, monkeypatch):
    out = io.StringIO()
    monkeypatch.setattr(sys, "stdout", out)
    monkeypatch.setattr("impact_studies.rail_joint.way_bar.PAUSE", 0.0)
    monkeypatch.setattr("dolfinx_impact.common.progress_lines.FIRST", 0.0)
    joint = RailJoint()
    with WayBar(MPI.COMM_SELF, joint, wanted) as bar:
        bar(SimpleNamespace(time=-joint.begin / joint.speed, step=321))  # the axle is over the joint
    text = out.getvalue()
    assert ("axle at   +0.0 mm" in text and "step 321" in text) == wanted
    assert bool(text.strip()) == wanted


@pytest.mark.parametrize("name", END_POSTS)
def test_materials_of_end_posts(name):
    post = RailJoint(end_post=name).post
    assert post == EndPost(*END_POSTS[name]) and post.E > 0.0 and 0.0 < post.nu < 0.5 and post.density > 500.0
