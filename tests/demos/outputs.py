# SPDX-License-Identifier: MIT
"""Printed output of two runs: words and numbers."""

import re

NUMBER = re.compile(r"[-+]?\b\d[\d.]*(?:e[-+]?\d+)?")


def words(text):
    """What is printed between the numbers, without spaces at the ends of lines."""
    return [re.sub(r"\s+", " ", line).strip() for line in NUMBER.sub("#", text).strip().splitlines()]


def numbers(text):
    """The numbers of a text."""
    return [float(number.rstrip(".")) for number in NUMBER.findall(text)]
