# SPDX-License-Identifier: MIT
"""Messages of this package, at the level of DOLFINx's log: the one place that reads `dolfinx.log`.

| level of `dolfinx.log` | what is seen |
|---|---|
| INFO or less | also what every iteration did, among DOLFINx's own messages |
| WARNING (DOLFINx's default) | progress of what takes long, and warnings |
| ERROR or more, OFF | neither progress nor warnings |

The messages are records of Python's logger "dolfinx_impact", too, which programs can handle in their own way. What is
asked for explicitly (`verbose=True`) is printed at every level. Exceptions and Python's warnings are not messages.
"""

from __future__ import annotations

import logging

from dolfinx.cpp import log  # what `dolfinx.log` exports

LOG = logging.getLogger("dolfinx_impact")

#: Where contacts that overlap at the start are reported.
INITIAL_PENETRATION = logging.getLogger("dolfinx_impact.initial_penetration")


class DolfinxLogHandler(logging.Handler):
    """Hands the records of Python's logger on to DOLFINx's log, which has the level."""

    def emit(self, record: logging.LogRecord) -> None:
        """Write a record.

        Args:
            record: the record.
        """
        if record.levelno < logging.INFO and log.get_log_level().value > log.LogLevel.DEBUG.value:
            return
        level = log.LogLevel.INFO  # DOLFINx 0.9 writes no messages of the levels DEBUG and CRITICAL
        if record.levelno >= logging.ERROR:
            level = log.LogLevel.ERROR
        elif record.levelno >= logging.WARNING:
            level = log.LogLevel.WARNING
        log.log(level, record.getMessage())


if not any(isinstance(handler, DolfinxLogHandler) for handler in LOG.handlers):
    LOG.addHandler(DolfinxLogHandler())


def inform(text: str) -> None:
    """Write what an iteration, or the like, did: seen where the level of DOLFINx's log, or of Python's logger, is INFO.

    Args:
        text: the message.
    """
    if LOG.isEnabledFor(logging.INFO):
        LOG.info(text)
    else:  # Python's logger keeps it back by its own level, which is WARNING; DOLFINx's may be INFO all the same
        log.log(log.LogLevel.INFO, text)


def warn(text: str) -> None:
    """Write a warning that is about a run and not about a line of the user's script.

    Args:
        text: the message.
    """
    LOG.warning(text)


def progress_is_shown() -> bool:
    """Whether the level of DOLFINx's log lets progress of long work be shown."""
    return log.get_log_level().value <= log.LogLevel.WARNING.value
