# SPDX-License-Identifier: MIT
"""Materials of one's own whose local equations have no solution beyond a limit."""

import ufl

import dolfinx_impact as di
from dolfinx_impact.forms.inelastic import Update

E, NU = 2.0, 0.3


class LimitedStretch:
    """Linear elasticity; x^2 = 1 - (e/limit)^2 has no solution for a stretch e along the first axis beyond the limit.

    The history counts evaluations that were committed, and holds the stretch.

    Args:
        limit: the limit [1].
        of_step: whether e is the change of the stretch in the step.
    """

    history = {"count": (), "stretch": ()}
    unknown = ()

    def __init__(self, limit, of_step):
        self.limit, self.of_step = limit, of_step

    def respond(self, strain, history, unknown):
        mu, lmbda = E / (2 * (1 + NU)), E * NU / ((1 + NU) * (1 - 2 * NU))
        now = strain[0, 0]
        e = now - history["stretch"] if self.of_step else now
        return Update(
            stress=lmbda * ufl.tr(strain) * ufl.Identity(3) + 2 * mu * strain,
            outputs={"count": history["count"] + 1, "stretch": now},
            stored=lmbda / 2 * ufl.tr(strain) ** 2 + mu * ufl.inner(strain, strain),
            residual=unknown**2 - 1 + (e / self.limit) ** 2,
            start=ufl.as_ufl(1.0),
        )


class Limited(di.InelasticMaterial):
    """Material of LimitedStretch.

    Args:
        limit: limit of the stretch [1].
        of_step: whether the limit is that of a step.
    """

    average = False

    def __init__(self, limit, of_step=False):
        super().__init__(E, NU, 1.0, "plane_strain")
        self.limit, self.of_step = limit, of_step

    def response(self, mesh):
        return LimitedStretch(self.limit, self.of_step)


class LargestOfCell(di.InelasticMaterial):
    """Linear elasticity whose history is the largest dilatation so far at a point, and in its cell.

    Args:
        stiffening: factor of the cell's largest dilatation in the stress; static problems take 0 only [1].
        hypothesis: hypothesis of the body.
    """

    average = False
    history = {"of_point": (), "of_cell": ()}

    def __init__(self, stiffening=0.0, hypothesis="plane_strain"):
        super().__init__(E, NU, 1.0, hypothesis)
        self.stiffening = stiffening

    def respond(self, strain, history, unknown):
        mu, lmbda = E / (2 * (1 + NU)), E * NU / ((1 + NU) * (1 - 2 * NU))
        dilatation = ufl.tr(strain)
        largest = ufl.max_value(history["of_cell"], di.cell_max(dilatation))
        stress = lmbda * dilatation * ufl.Identity(3) + 2 * mu * strain
        return Update(
            stress=(1 + self.stiffening * largest) * stress if self.stiffening else stress,
            outputs={"of_point": ufl.max_value(history["of_point"], dilatation), "of_cell": largest},
            stored=lmbda / 2 * dilatation**2 + mu * ufl.inner(strain, strain),
        )
