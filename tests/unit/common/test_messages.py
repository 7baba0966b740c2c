# SPDX-License-Identifier: MIT
"""Messages at the levels of DOLFINx's log, and as records of Python's logger."""

import logging

import pytest
from dolfinx import log
from mpi4py import MPI

from dolfinx_impact.common.messages import INITIAL_PENETRATION, LOG, DolfinxLogHandler, inform, progress_is_shown, warn
from dolfinx_impact.statics.load_steps import StepLog


@pytest.fixture
def level():
    """Function that sets the level of DOLFINx's log by name; it is set back in the end."""
    before = log.get_log_level()
    yield lambda name: log.set_log_level(getattr(log.LogLevel, name))
    log.set_log_level(before)


@pytest.mark.parametrize("name, seen", (("DEBUG", "iw"), ("INFO", "iw"), ("WARNING", "w"), ("ERROR", ""), ("OFF", "")))
def test_what_is_seen_at_which_level(name, seen, level, capfd):
    level(name)
    inform("did {this} 100 %")
    warn("lost contact")
    INITIAL_PENETRATION.warning("overlaps")
    text = "".join(capfd.readouterr())
    assert ("[info] did {this} 100 %" in text) == ("i" in seen)
    assert ("[warning] lost contact" in text) == ("w" in seen)
    assert ("[warning] overlaps" in text) == ("w" in seen)
    assert len(text.splitlines()) == (len(seen) + 1 if seen else 0)  # once each, nothing else
    assert progress_is_shown() == ("w" in seen)


@pytest.mark.parametrize("name, verbose, lines", (("INFO", False, 1), ("WARNING", False, 0), ("OFF", True, 1)))
def test_lines_of_iterations(name, verbose, lines, level, capfd):
    """At INFO they are DOLFINx's log's; what is asked for by `verbose` is printed at every level."""
    level(name)
    StepLog(MPI.COMM_SELF, verbose).iteration(2, 0.5, 2.0, 7, 1)
    text = "".join(capfd.readouterr())
    assert text.count("iteration  2: residual 5.000e-01") == lines == len(text.splitlines())


def test_records_of_pythons_logger(level, caplog):
    """A program that handles the records has them whatever DOLFINx's level is."""
    level("OFF")
    with caplog.at_level(logging.INFO, logger="dolfinx_impact"):
        inform("did this")
        warn("lost contact")
    found = [(r.levelname, r.getMessage()) for r in caplog.records]
    assert found == [("INFO", "did this"), ("WARNING", "lost contact")]


def test_records_reach_the_log_once():
    """Importing the module once more adds no second handler."""
    assert [type(handler) for handler in LOG.handlers].count(DolfinxLogHandler) == 1


@pytest.mark.parametrize("number, word", ((10, "info"), (20, "info"), (30, "warning"), (40, "error"), (50, "error")))
def test_levels_of_records(number, word, level, capfd):
    level("DEBUG")
    record = logging.LogRecord("name", number, "file", 1, "what %s", ("happened",), None)
    DolfinxLogHandler().emit(record)
    assert f"[{word}] what happened" in "".join(capfd.readouterr())
    level("INFO")
    DolfinxLogHandler().emit(record)
    assert ("what happened" in "".join(capfd.readouterr())) == (number >= logging.INFO)
