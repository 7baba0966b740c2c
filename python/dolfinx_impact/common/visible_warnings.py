# SPDX-License-Identifier: MIT
"""Warnings where a person sees them."""

import logging


def undo_capture() -> None:
    """Let warnings go to the terminal again, unless something handles them as log records.

    Importing FFCx, which DOLFINx does, sends all warnings of Python to the logger "py.warnings". Without a handler it
    drops them, those of this package as well.
    """
    logger: logging.Logger | None = logging.getLogger("py.warnings")
    while logger is not None:
        if any(not isinstance(handler, logging.NullHandler) for handler in logger.handlers):
            return
        logger = logger.parent if logger.propagate else None
    logging.captureWarnings(False)
