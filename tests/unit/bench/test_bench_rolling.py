# SPDX-License-Identifier: MIT
"""Rows of the cost of creep forces: made only if all that is timed gives the same forces."""

import pytest

from impact_studies.bench import rolling
from impact_studies.creep.model import CreepModel


@pytest.mark.slow
def test_rows():
    point, curve = rolling.rolling_rows(cells=2, points=4, reach=3.0)
    assert point["baseline"] == curve["baseline"] > 0.0
    assert 0.0 < point["value"] and 0.0 < curve["value"]
    assert point["name"].startswith("creep point") and "4 points" in curve["name"]


@pytest.mark.slow
def test_another_contact_makes_no_row(monkeypatch):
    right = CreepModel.rolling
    # The model itself is made with the right friction: the third problem is the timed point.
    made = []

    def wrong(self, friction):
        made.append(friction)
        return right(self, 0.5 * friction if len(made) == 3 else friction)

    monkeypatch.setattr(CreepModel, "rolling", wrong)
    monkeypatch.setattr(CreepModel, "standing", lambda self: right(self, 0.0))
    with pytest.raises(RuntimeError, match="no timing counts"):
        rolling.rolling_rows(cells=2, points=4, reach=3.0)
