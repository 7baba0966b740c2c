# SPDX-License-Identifier: MIT
"""What a comparison of the level history sees when one side runs a scenario that was changed."""

from dataclasses import replace

from impact_verify import runs_in_time
from impact_verify.report import Report
from impact_verify.scenarios import our_adapter


def changed(case, **changes):
    """A scenario with other values, of its own or of its scheme."""
    of_scheme = {name: changes.pop(name) for name in list(changes) if hasattr(case.scheme, name)}
    return replace(case, scheme=replace(case.scheme, **of_scheme), **changes)


def failed(case, steps, **changes):
    """Quantities that fail when our side runs a changed case."""
    mine, ours = changed(case, **changes), our_adapter.run
    report = Report()
    try:
        our_adapter.run = lambda _, steps: ours(mine, steps)
        runs_in_time.compare(report, case, steps)
    finally:
        our_adapter.run = ours
    return {row.name.split(" of the ")[0] for row in report.rows if not row.passed}
