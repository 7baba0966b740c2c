# SPDX-License-Identifier: MIT
"""Cross-verification of the UFL side against the hand-written solver, level by level.

`cross_check` compares forms of the catalogue; `run.main` is the command line. Modules are imported on first use, so
that importing dolfinx_impact does not need the hand-written solver, SLEPc or matplotlib.
"""


def cross_check(form_or_name=None, **options):
    """Compare forms of the catalogue, or a user's file, with the hand-written solver; see verify.run.cross_check."""
    from .run import cross_check as check

    return check(form_or_name, **options)
