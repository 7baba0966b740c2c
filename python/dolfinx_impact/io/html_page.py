# SPDX-License-Identifier: MIT
"""HTML pages from the templates of a package."""

from pathlib import Path
from typing import Any

from .hdf5 import write_whole


def write_page(path: Path, package: str, template: str, **values: Any) -> None:
    """Write a page; the former file stays until the new one is complete. Texts are escaped.

    Args:
        path: file to write.
        package: name of the package that has the template in its folder `templates`.
        template: name of the template, Jinja's language.
        values: by the names that the template has for them.

    Raises:
        jinja2.UndefinedError: the template has a name that is not given.
        OSError: the file cannot be written.
    """
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader(package), autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True,
        lstrip_blocks=True, keep_trailing_newline=True,
    )  # fmt: skip
    write_whole(path, environment.get_template(template).render(values))
