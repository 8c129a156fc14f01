"""Rig files with kind = "python:module:Class": who imports the module that one names, by the sources of everything."""

from __future__ import annotations

import ast

from tests.places import PACKAGE


def test_only_opening_a_rig_and_many_loops_may_import() -> None:
    """By the sources: nothing else passes ``may_import=True`` or calls what imports.

    The process of a bench opens the rig that ``musclewire serve`` was given on the command line, and no other.
    """
    found = set()
    for path in PACKAGE.rglob("*.py"):
        text = path.read_text("utf-8")
        if "may_import" not in text and "imported_kind" not in text:
            continue
        for node in ast.walk(ast.parse(text)):
            named = isinstance(node, ast.keyword) and node.arg == "may_import"
            allowed = named and isinstance(node.value, ast.Constant) and node.value.value is True
            called = isinstance(node, ast.Call) and getattr(node.func, "id", "") == "imported_kind"
            if allowed or called:
                found.add(path.relative_to(PACKAGE).as_posix())
    assert found == {"rigs/_configuration.py", "experiment/_many_loops.py", "extras/live/_bench/opening.py"}
