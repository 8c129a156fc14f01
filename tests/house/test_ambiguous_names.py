"""A check of names finds what has several meanings or none."""

from __future__ import annotations

import ast

from checks.ambiguous_names import findings_in


def found_in(**sources: str) -> list[tuple[str, str]]:
    """Return kind and name of what is found in files given by their text."""
    return [(one.kind, one.name) for one in findings_in({name: ast.parse(text) for name, text in sources.items()})]


def test_a_class_name_of_two_files_is_found_once() -> None:
    assert found_in(a="class Drive: ...", b="class Drive: ...", c="class Board: ...") == [("class", "Drive")]


def test_a_class_that_is_defined_twice_in_one_file_has_one_home() -> None:
    assert found_in(a="if True:\n    class Drive: ...\nelse:\n    class Drive: ...") == []


def test_a_method_whose_name_is_a_particle_is_found_under_its_class() -> None:
    assert found_in(a="class Rig:\n    def take(self): ...\n    def take_sample(self): ...") == [
        ("function", "a:Rig.take")
    ]


def test_a_parameter_whose_name_is_a_particle_is_found_in_its_function() -> None:
    assert found_in(a="def follow(of, state): ...") == [("parameter", "a:follow(of)")]
