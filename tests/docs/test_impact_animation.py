# SPDX-License-Identifier: MIT
"""The impact that moves on the start page is what docs/impact_animation.py makes of a run."""

import importlib.util

import numpy as np
from PIL import Image

COMPARED = (0, 8, 26, 55)  # before the impact, in it, at the largest deflection, after it
# Mean difference of a channel, of 255: the GIF has 256 colours. A ring that is drawn one step later differs by 2 and
# more, as the test shows.
SAME = 1.0


def distance(a, b):
    return np.abs(np.asarray(a, dtype=float) - np.asarray(b, dtype=float)).mean()


def test_the_script_makes_the_animation(checkout):
    path = checkout / "docs" / "figures" / "impact.gif"
    assert path.stat().st_size < 1.5e6
    for page, name in (("README.md", "docs/figures/impact.gif"), ("docs/index.md", "figures/impact.gif")):
        assert f"]({name})" in (checkout / page).read_text()
    spec = importlib.util.spec_from_file_location("impact_animation", checkout / "docs" / "impact_animation.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    committed = Image.open(path)
    assert committed.n_frames == script.FRAMES
    for number, made in zip(COMPARED, script.frames(COMPARED), strict=True):
        committed.seek(number)
        assert distance(made, committed.convert("RGB")) < SAME
        if number:
            committed.seek(number - 1)
            assert distance(made, committed.convert("RGB")) > 2 * SAME
