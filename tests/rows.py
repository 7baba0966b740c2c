# SPDX-License-Identifier: MIT
"""Which rows of a table of tests are slow: those that its marker `long_rows` names, or that `covering` does without."""

import inspect
import itertools


def tables(items, marker):
    """Tests with a marker, table by table: lists of rows."""
    found = {}
    for item in items:
        if item.get_closest_marker(marker) is not None:
            found.setdefault((item.parent.nodeid, item.originalname), []).append(item)
    return list(found.values())


def long_rows(items):
    """Tests for whose parameters the `where` of their marker holds."""
    for item in itertools.chain(*tables(items, "long_rows")):
        where = item.get_closest_marker("long_rows").kwargs["where"]
        if where(**{name: item.callspec.params[name] for name in inspect.signature(where).parameters}):
            yield item


def covering_array(rows, strength):
    """Places of few rows that cover the table: values that occur together in any row do so in one of these.

    Most faults show for one value, or where two values meet: D. R. Kuhn, D. R. Wallace and A. M. Gallo, Software fault
    interactions and implications for software testing, IEEE Trans. Softw. Eng. 30 (2004) 418-421. The row that covers
    most combinations that are new comes next, the first one of several.

    Args:
        rows: Dictionaries name -> hashable value, all with the same names in the same order.
        strength: Number of values that are taken together: 1 for each value by itself, 2 for every pair.
    """
    combinations = [set(itertools.combinations(row.items(), strength)) for row in rows]
    missing, chosen = set().union(*combinations), []
    while missing:
        best = max(range(len(rows)), key=lambda place: len(combinations[place] & missing))
        chosen.append(best)
        missing -= combinations[best]
    return sorted(chosen)


def beyond_covering(items):
    """Tests with the marker `covering` that are not in the covering array of their table."""
    for table in tables(items, "covering"):
        (strength,) = table[0].get_closest_marker("covering").args
        rows = [{name: repr(value) for name, value in item.callspec.params.items()} for item in table]
        assert 1 <= strength <= len(rows[0]), f"{table[0].nodeid}: the table has {len(rows[0])} parameters"
        chosen = set(covering_array(rows, strength))
        yield from (item for place, item in enumerate(table) if place not in chosen)
