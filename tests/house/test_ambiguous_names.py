"""A check of names finds what has several meanings or none."""

from __future__ import annotations

import ast

from checks.ambiguous_names import findings_in


def found_in(**sources: str) -> list[tuple[str, str]]:
    """Return kind and name of what is found in files given by their text."""
    return [(one.kind, one.name) for one in findings_in({name: ast.parse(text) for name, text in sources.items()})]


def test_names_of_two_homes_and_particles_are_found() -> None:
    assert found_in(a="class Drive: ...", b="class Drive: ...", c="class Board: ...") == [("class", "Drive")]
    assert found_in(a="if True:\n    class Drive: ...\nelse:\n    class Drive: ...") == []
    methods = "class Rig:\n    def take(self): ...\n    def take_sample(self): ..."
    assert found_in(a=methods, b="def follow(of, state): ...") == [
        ("function", "a:Rig.take"),
        ("parameter", "b:follow(of)"),
    ]
