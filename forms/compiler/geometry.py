# SPDX-License-Identifier: MIT
"""Sizes of cells and facets: those that UFL leaves as they are where cells are not affine, those that kernels read from
the nodes."""

import basix
import numpy as np
import ufl
from ufl.algorithms.map_integrands import map_integrand_dags
from ufl.corealg.map_dag import map_expr_dag
from ufl.corealg.multifunction import MultiFunction
from ufl.corealg.traversal import unique_pre_traversal

from .words import find, in_words


LENGTHS = (
    ufl.classes.CellDiameter,
    ufl.classes.MinCellEdgeLength,
    ufl.classes.MaxCellEdgeLength,
    ufl.classes.MinFacetEdgeLength,
    ufl.classes.MaxFacetEdgeLength,
)


class _FacetAreas(MultiFunction):
    """Areas of facets in terms of determinants."""

    expr = MultiFunction.reuse_if_untouched

    def terminal(self, o):
        return o

    def facet_area(self, o):
        domain = ufl.domain.extract_unique_domain(o)
        if domain.is_piecewise_linear_simplex_domain() or not has_straight_edges(domain):
            return o
        return abs(ufl.classes.FacetJacobianDeterminant(domain)) * ufl.classes.ReferenceFacetVolume(domain)


class _Sizes(_FacetAreas):
    """Volumes of cells, too."""

    def cell_volume(self, o):
        domain = ufl.domain.extract_unique_domain(o)
        if domain.is_piecewise_linear_simplex_domain():
            return o
        # The mean of 1/|det J| over a cell is the reference volume over the volume, by the form's own rule.
        return ufl.classes.ReferenceCellVolume(domain) / ufl.cell_avg(1 / abs(ufl.JacobianDeterminant(domain)))


def check_sizes(name, form):
    """ValueError, in the user's words, for sizes that neither UFL nor kernels know on cells of this kind."""
    for integral in form.integrals():
        domain = integral.ufl_domain()
        average = find(integral.integrand(), ufl.classes.FacetAvg)
        if average is not None:
            raise ValueError(f"{name}: {in_words(average)} is not supported, ufl.cell_avg in integrals over dx is")
        if domain.is_piecewise_linear_simplex_domain():
            continue
        cell, degree = str(domain.ufl_cell()), geometry_degree(domain)
        for o in unique_pre_traversal(integral.integrand()):
            unknown = isinstance(o, ufl.classes.FacetArea) and not has_straight_edges(domain)
            if unknown or (degree > 1 and isinstance(o, LENGTHS)):
                raise ValueError(
                    f"{name}: {in_words(o)} is not known on cells of kind {cell} and degree {degree}, whose facets or "
                    "edges are not straight: give the size as a function of the cell, fem.functionspace(mesh, "
                    '("DG", 0)), with values of mesh.h'
                )
            if isinstance(o, ufl.classes.Circumradius):
                raise ValueError(
                    f"{name}: {in_words(o)} is that of straight triangles and tetrahedra, the cells are of kind {cell} "
                    f"and degree {degree}: take ufl.CellDiameter(mesh)"
                )
            if isinstance(o, ufl.classes.CellVolume) and integral.integral_type() != "cell":
                raise ValueError(
                    f"{name}: {in_words(o)} of {cell} cells is known in integrals over dx, not over facets: take "
                    "ufl.CellDiameter(mesh)"
                )


def has_straight_edges(domain):
    """Are the facets of a mesh straight edges?"""
    return str(domain.ufl_cell()) in ("triangle", "quadrilateral") and geometry_degree(domain) == 1


def geometry_degree(domain):
    """Degree of the geometry of a UFL mesh, per direction."""
    element = domain.ufl_coordinate_element()
    return int((element.sub_elements[0] if element.block_size > 1 else element).basix_element.degree)


def with_sizes(form_or_expression):
    """A form or expression in which volumes and areas of cells that are not affine are written by determinants."""
    if isinstance(form_or_expression, ufl.Form):
        return map_integrand_dags(_Sizes(), form_or_expression)
    return map_expr_dag(_Sizes(), form_or_expression)


def with_facet_areas(form):
    """A form in which areas of straight facets of cells that are not affine are written by determinants."""
    return map_integrand_dags(_FacetAreas(), form)


def vertex_dofs(coordinate_element):
    """Numbers of a cell's nodes at its vertices."""
    scalar = coordinate_element.sub_elements[0] if coordinate_element.block_size > 1 else coordinate_element
    return [dofs[0] for dofs in scalar.entity_dofs[0]]


def cell_edges(cell):
    """Vertices of a cell's edges."""
    return basix.topology(cell)[1]


def facet_edge_differences(cell):
    """Entry [facet][edge][vertex]: 1 at the first vertex of an edge of a facet, -1 at its second one."""
    topology = basix.topology(cell)
    dim = len(topology) - 1
    facet_edges = []
    for vertices in topology[dim - 1]:
        facet_edges.append([e for e in topology[1] if set(e) <= set(vertices)])
    num_edges = max(map(len, facet_edges))
    values = np.zeros((len(facet_edges), num_edges, len(topology[0])))
    for f, edges in enumerate(facet_edges):
        for k, (a, b) in enumerate(edges):
            values[f, k, a], values[f, k, b] = 1.0, -1.0
    return values
