# SPDX-License-Identifier: MIT
"""Why a form differs from an operator of the hand-written solver: it is fitted by parts that people get wrong."""
