# SPDX-License-Identifier: MIT
"""The compiled module, for type checkers: its names are those of cpp/bindings, without types."""

from typing import Any

def __getattr__(name: str) -> Any: ...
