# SPDX-License-Identifier: MIT
"""Blocks of code of a page: which there are, and what becomes of each when the page is tested."""

import re
from dataclasses import dataclass

MARK = re.compile(r"<!-- not run: (\S.*?) -->")
DEMO = re.compile(r"(?:env/run )?dolfinx-impact demo (\w+)(?: --ranks \d+)?(?: +#.*)?")
# What Sphinx itself puts in place of such a block.
DIRECTIVE = re.compile(r"\{[\w-]+\}")


@dataclass
class Block:
    """A block of a page.

    Attributes:
        line: number of its first line.
        language: after the fence, empty for indented blocks.
        text: its lines, without indent.
        reason: why it is not run, or None.
    """

    line: int
    language: str
    text: str
    reason: str | None

    @property
    def file(self):
        """Name in a first line such as "# my_form.py": the block is that file; else None."""
        found = re.match(r"# (\w+\.\w+)\n", self.text)
        return found[1] if found else None

    def is_run(self, demos):
        """Is it run: as a part of the page's scripts, or because tests/demos runs every demo?"""
        if self.language:
            return self.language in ("python", "bash") or self.file is not None
        found = [DEMO.fullmatch(line) for line in self.text.splitlines()]
        return all(match and match[1] in demos for match in found)


def blocks(text):
    """All blocks of a page in Markdown, fenced or indented, but for directives, formulas and lists."""
    found, lines, k = [], text.splitlines(), 0
    reason, formula, listed, blank = None, False, False, True
    while k < len(lines):
        line = lines[k]
        fence = re.match(r"(`{3,})(.*)$", line)
        if fence:
            end = next(i for i in range(k + 1, len(lines)) if lines[i].startswith(fence[1]))
            language = fence[2].strip()
            if not DIRECTIVE.match(language):
                body = "".join(f"{row}\n" for row in lines[k + 1 : end])
                found.append(Block(k + 2, language or "text", body, reason))
            reason, k, blank = None, end + 1, False
            continue
        if line.strip() == "$$":
            formula = not formula
        elif line.startswith("    ") and blank and not formula and not listed:
            end = k
            while end < len(lines) and (lines[end].startswith("    ") or not lines[end].strip()):
                end += 1
            body = "\n".join(row[4:] for row in lines[k:end]).rstrip() + "\n"
            found.append(Block(k + 1, "", body, reason))
            reason, k, blank = None, end, True
            continue
        elif line.strip():
            mark = MARK.fullmatch(line.strip())
            reason = mark[1] if mark else None
            listed = bool(re.match(r"\s*([-*]|\d+\.) ", line)) or (listed and line.startswith(" "))
        blank = not line.strip()
        k += 1
    return found
