# SPDX-License-Identifier: MIT
"""Benchmarks: each timing is stated as a ratio to a baseline that is measured in the same run."""
