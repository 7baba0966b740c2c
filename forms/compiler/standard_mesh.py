# SPDX-License-Identifier: MIT
"""Forms as they would be on a mesh whose nodes are placed by Basix's default.

Meshes of gmsh and XDMF have nodes of the variant "equispaced", those that DOLFINx makes itself have "gll_warped". Up
to degree 2 both are the same nodes, hence the same kernels; their elements, and so UFL's signatures, are different.
"""

import basix
import basix.ufl
import numpy as np
import ufl
from ufl.corealg.map_dag import map_expr_dag
from ufl.corealg.multifunction import MultiFunction

SAME_NODES = 2  # highest degree at which these variants have the same nodes
VARIANTS = ("equispaced", "gll_isaac", "gll_centroid")  # not Bernstein's, which has no nodes


def standard_element(element):
    """The coordinate element with nodes of the default variant, if the nodes are the same; else the element itself.

    Args:
        element: coordinate element of a UFL mesh.
    """
    own = element.sub_elements[0] if element.block_size > 1 else element
    if getattr(own, "element_family", None) != basix.ElementFamily.P or own.dtype != np.float64:
        return element  # of another package, for one
    if own.degree > SAME_NODES or own.lagrange_variant.name not in VARIANTS:
        return element
    return basix.ufl.element("Lagrange", own.cell_type.name, own.degree, shape=element.reference_value_shape)


class MeshWithCell(ufl.Mesh):
    """A mesh that keeps its cell: elements of Basix make it anew, with all its faces, for each of UFL's questions.

    Args:
        element: coordinate element.
        ufl_id: number of the mesh in UFL.
    """

    def __init__(self, element, ufl_id):
        super().__init__(element, ufl_id=ufl_id)
        self._cell = element.cell

    def ufl_cell(self):
        return self._cell


class StandardMesh(MultiFunction):
    """Replaces meshes in expressions and forms by standard ones, and functions by ones on them.

    Args:
        domains: UFL meshes.
    """

    expr = MultiFunction.reuse_if_untouched

    def __init__(self, domains):
        super().__init__()
        self.domains = {}
        for domain in domains:
            element = getattr(domain, "ufl_coordinate_element", lambda: None)()
            new = element if element is None else standard_element(element)
            if new is not element:
                self.domains[domain] = MeshWithCell(new, domain.ufl_id())
        self.functions, self.spaces = {}, {}

    def space(self, V):
        """The space on a standard mesh."""
        domain = self.domains.get(V.ufl_domain())
        if domain is None:
            return V
        key = domain, V.ufl_element()
        if key not in self.spaces:
            self.spaces[key] = ufl.FunctionSpace(*key)
        return self.spaces[key]

    def coefficient(self, o):
        V = o.ufl_function_space()
        if V.ufl_domain() not in self.domains:
            return o
        return self.functions.setdefault(o, ufl.Coefficient(self.space(V), count=o.count()))

    def constant(self, o):
        domain = self.domains.get(o.ufl_domain())
        return o if domain is None else ufl.Constant(domain, o.ufl_shape, count=o.count())

    def argument(self, o):
        V = o.ufl_function_space()
        return o if V.ufl_domain() not in self.domains else ufl.Argument(self.space(V), o.number(), o.part())

    def geometric_quantity(self, o):
        domain = self.domains.get(ufl.domain.extract_unique_domain(o))
        return o if domain is None else type(o)(domain)

    def form(self, form):
        """A form on standard meshes; the form itself where all of its meshes are."""
        if not self.domains:
            return form
        integrals = [
            i.reconstruct(integrand=map_expr_dag(self, i.integrand()), domain=self.domains.get(i.ufl_domain()))
            for i in form.integrals()
        ]
        return ufl.Form(integrals)
