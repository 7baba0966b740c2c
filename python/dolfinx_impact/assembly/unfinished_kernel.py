# SPDX-License-Identifier: MIT
"""What to do about a kernel in the cache of DOLFINx whose compilation was broken off."""

import re


def advice(error: TimeoutError) -> str:
    """One sentence about the error of FFCx that waits for a kernel: a process that is killed while it compiles leaves
    a file for which all later ones wait in vain.

    Args:
        error: as FFCx raises it.
    """
    file = re.search(r"remove (\S.*\.c)\)", str(error))
    what = "the unfinished file in the cache of DOLFINx" if file is None else file[1]
    return (
        "a kernel is not ready: another process compiles it, or was killed while it did; start again, and if that does "
        f"not help remove {what}"
    )
