# SPDX-License-Identifier: MIT
"""The rules of docs/architecture.md on this checkout."""

import statistics
import subprocess
import sys

import rules


def test_a_stage_includes_earlier_stages_only(checkout):
    assert rules.layer_violations(checkout) == []


def test_a_room_of_a_stage_includes_earlier_rooms_only(checkout):
    assert rules.room_violations(checkout) == []


def test_a_python_package_imports_earlier_packages_only(checkout):
    assert rules.package_violations(checkout) == []


def test_no_modules_import_each_other(checkout):
    assert rules.import_circles(checkout) == []


def test_packages_beside_the_library_stay_beside_it(checkout):
    assert rules.beside_violations(checkout) == []


def test_importing_the_library_loads_nothing_beside_it():
    code = "import sys, dolfinx_impact; print(' '.join({name.split('.')[0] for name in sys.modules}))"
    names = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "dolfinx_impact" in names and not {*rules.BESIDE, "impact_reference"} & set(names)


def test_the_order_of_the_packages_is_that_of_the_page(checkout):
    page = (checkout / "docs" / "architecture.md").read_text()
    places = [page.index(f"`{name}/`" if f"`{name}/`" in page else f"`{name}.py`") for name in rules.PACKAGES]
    assert places == sorted(places)


def test_releases_of_dolfinx_differ_in_the_layers_alone(checkout):
    assert rules.release_violations(checkout) == []


def test_mpi_is_imported_first(checkout):
    assert rules.mpi_later(checkout) == []


def test_the_hand_written_solver_shares_nothing(checkout):
    assert rules.reference_violations(checkout) == []


def test_forms_speak_ufl_only(checkout):
    assert rules.forms_violations(checkout) == []


def test_the_hand_written_solver_loads_nothing_foreign():
    """By sys.modules and by the shared libraries in the process, after a stiffness matrix could be computed."""
    code = """
import sys
import impact_reference
foreign = {"dolfinx", "dolfinx_impact", "basix", "ufl", "ffcx", "petsc4py", "mpi4py", "slepc4py", "cffi"}
found = sorted(foreign & {name.partition(".")[0] for name in sys.modules})
assert not found, found
paths = [line.rpartition(" ")[2].strip().lower() for line in open("/proc/self/maps")]
files = {path.rpartition("/")[2] for path in paths}  # folders have names of their owner's choice
found = [n for n in ("dolfinx", "basix", "petsc", "libmpi", "slepc") if any(n in file for file in files)]
assert not found and not any("dolfinx_impact/_cpp" in path for path in paths), found
assert any("_reference" in file for file in files)  # its own module: the search above looked at the right process
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_no_unsafe_floating_point_flags(checkout):
    assert rules.unsafe_flags(checkout) == []


def test_forms_are_compiled_where_leftovers_of_killed_processes_are_mended(checkout):
    assert rules.plain_forms(checkout) == []


def test_no_unfinished_words_in_public_headers(checkout):
    assert rules.unfinished_headers(checkout) == []


def test_files_stay_readable(checkout, record_property):
    counts = rules.line_counts(checkout)
    median = statistics.median(counts.values())
    record_property("median_lines", median)
    print(f"{len(counts)} source files, median {median:.0f} lines, longest {max(counts.values())}")
    long = {str(p): n for p, n in counts.items() if n > rules.LONG}
    record_property("long_files", long)  # a question, no rule: a class that does one thing stays in one file
    print("longer than", rules.LONG, "lines:", long)
    assert len(counts) > 20
    assert median < rules.LONG / 2


def test_folders_of_unit_tests_are_those_of_the_code(checkout):
    assert rules.unit_folder_violations(checkout) == []


def test_every_class_with_methods_is_named_by_a_test(checkout):
    assert rules.unnamed_classes(checkout) == []


def test_what_a_base_says_is_not_said_again(checkout):
    assert rules.repeated_docstrings(checkout) == []
    assert rules.repeated_comments(checkout) == []


def test_lines_of_pages_end_at_120_columns(checkout):
    assert rules.long_lines(checkout) == []


def test_pages_that_are_named_exist(checkout):
    assert rules.missing_pages(checkout) == []


def test_what_is_bound_is_called(checkout):
    assert rules.unused_bindings(checkout) == []


def test_nothing_was_left_at_the_top(checkout):
    assert rules.top_violations(checkout) == []


def test_no_machine_paths(checkout):
    assert rules.machine_paths(checkout) == []


def test_versions_agree(checkout):
    found = rules.versions(checkout)
    assert "pyproject.toml" in found and "CITATION.cff" in found
    assert len(set(found.values())) == 1, found


def test_demos_end_with_an_assert(checkout):
    assert rules.demos_without_assert(checkout) == []
