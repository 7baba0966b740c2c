# SPDX-License-Identifier: MIT
"""Static problems on 1, 2 and 3 ranks, and what StaticProblem refuses."""

import static_problem_checks
import pytest
from on_ranks import rank_tests
import ufl
from dolfinx import fem

import dolfinx_impact as di


test_one_rank, test_several_ranks = rank_tests(static_problem_checks)


def test_material_or_residual():
    domain = static_problem_checks.body("triangle")
    V = static_problem_checks.space(domain)
    u, law = fem.Function(V, name="u"), di.LinearElastic(1.0, 0.3, hypothesis="plane_strain")
    residual = di.operators.internal_force_form(u, ufl.TestFunction(V), law)
    with pytest.raises(ValueError, match="either a material or a residual"):
        di.StaticProblem(u)
    with pytest.raises(ValueError, match="either a material or a residual"):
        di.StaticProblem(u, law, residual=residual)
    with pytest.raises(ValueError, match="per mass needs a density"):
        di.StaticProblem(u, residual=residual, loads=[di.BodyForce((0, 1))])
    with pytest.raises(ValueError, match="plane_strain, plane_stress or axisymmetric"):
        di.StaticProblem(u, di.LinearElastic(1.0, 0.3))


def test_loads_share_their_tags():
    domain = static_problem_checks.body("triangle")
    u = fem.Function(static_problem_checks.space(domain), name="u")
    loads = [di.Traction(static_problem_checks.facets_at(domain, x=1.0), 1, (0.0, 1.0)) for _ in range(2)]
    with pytest.raises(ValueError, match="share one subdomain_data.*one MeshTags"):
        di.StaticProblem(u, di.LinearElastic(1.0, 0.3, hypothesis="plane_strain"), loads=loads)
