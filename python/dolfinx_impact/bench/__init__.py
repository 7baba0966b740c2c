# SPDX-License-Identifier: MIT
"""Timings, each as a ratio to something that is run side by side."""
