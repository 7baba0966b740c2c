# SPDX-License-Identifier: MIT
"""Rows of static bodies: residual and tangent of our kernels are those of FFCx's C, which the row itself checks."""

import pytest

from impact_studies.bench import statics


@pytest.mark.parametrize("law", statics.LAWS, ids=lambda law: law.law_class.name)
def test_rows_of_a_body(law, monkeypatch):
    rows = statics.body_rows((("hexahedron", 1, 3),), law)
    assert [r["name"].split()[1] for r in rows] == ["residual", "tangent"]
    assert all(r["ratio"] > 0.0 for r in rows)
    monkeypatch.setattr(statics, "TOLERANCE", 0.0)
    with pytest.raises(RuntimeError, match="differ by"):
        statics.body_rows((("hexahedron", 1, 3),), law)
