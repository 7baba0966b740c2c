# SPDX-License-Identifier: MIT
"""Bodies with internal variables on 1, 2 and 3 ranks."""

import inelastic_checks
import pytest
from on_ranks import rank_tests

import dolfinx_impact as di

test_one_rank, test_several_ranks = rank_tests(inelastic_checks)


def test_an_elastic_problem_has_no_history():
    problem = inelastic_checks.thrown(material=di.LinearElastic(2.0, 0.3, 1.0, "plane_strain"))
    with pytest.raises(ValueError, match="no material of the problem has internal variables"):
        problem.history["plastic_strain"]
    with pytest.raises(KeyError, match="no material has the internal variable 'damage': there are plastic_strain"):
        inelastic_checks.thrown(material=inelastic_checks.steel()).history["damage"]
