# SPDX-License-Identifier: MIT
"""Tags of the integrals of a form."""

import ufl


def check_measures(form: ufl.Form) -> None:
    """Refuse a form whose integrals over one kind of entity have different tags.

    Args:
        form: UFL form.

    Raises:
        ValueError: they have.
    """
    for measure, data in next(iter(form.subdomain_data().values())).items():
        if any(d is not data[0] for d in data):  # DOLFINx takes one set of tags for each kind, or none
            raise ValueError(
                f"the {measure} integrals must share one subdomain_data: put the tags of all loads into one MeshTags"
            )
