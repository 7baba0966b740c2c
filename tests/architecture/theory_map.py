# SPDX-License-Identifier: MIT
"""Reader and checker of docs/theory.md."""

import re

VERDICTS = {"ok", "ok*", "typo", "sign", "wrong"}
EQUATIONS = [f"3.{n}" for n in range(1, 84)]


def rows(text):
    """(seed, formula, verdict, code, test) of every table row that begins with an equation number."""
    found = []
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if line.startswith("|") and re.fullmatch(r"3\.\d+", cells[0]):
            found.append(cells)
    return found


def complaints(text, root, forms):
    """What is wrong with the map. forms: the names of the catalogue, for verify: entries."""
    found = []
    table = rows(text)
    numbers = [row[0] for row in table]
    if numbers != EQUATIONS:
        missing = sorted(set(EQUATIONS) - set(numbers), key=lambda n: int(n[2:]))
        found.append(f"rows are not 3.1 to 3.83 in order, once each; missing: {missing}")
    for row in table:
        if len(row) != 5:
            found.append(f"{row[0]}: {len(row)} columns instead of 5 (write \\lvert for a bar in a formula)")
            continue
        seed, formula, verdict, code, test = row
        if not formula or verdict not in VERDICTS:
            found.append(f"{seed}: no formula, or verdict {verdict!r}")
        for column, cell in (("code", code), ("test", test)):
            entries = re.findall(r"`([^`]+)`", cell)
            if not entries and cell != "later":
                found.append(f"{seed}: {column} names nothing and does not say later")
            if entries and re.sub(r"`[^`]+`", "", cell).strip(", "):
                found.append(f"{seed}: {column} is more than a list: {cell}")
            found += [f"{seed}: {column}: {problem}" for e in entries if (problem := _check(e, column, root, forms))]
    return found


def _check(entry, column, root, forms):
    if entry.startswith("verify:"):
        if column == "code":
            return f"{entry} is no code"
        return None if entry.removeprefix("verify:") in forms else f"{entry} is not in the catalogue"
    path, _, name = entry.partition("::")
    if not (root / path).is_file():
        return f"{path} does not exist"
    if name and not re.search(rf"\b{re.escape(name)}\b", (root / path).read_text()):
        return f"{name} does not occur in {path}"
    return None
