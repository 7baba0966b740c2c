# SPDX-License-Identifier: MIT
"""Objects that print as what their docstring says of them."""

import inspect


class Described:
    """Base class of parts of a problem, whose data do not fit in a line."""

    def __repr__(self) -> str:
        first = (inspect.getdoc(type(self)) or "").split("\n\n")[0].replace("\n", " ")
        return f"<{type(self).__name__}: {first}>"
