"""The examples in the docstrings of `import musclewire as mw` do what they say."""

from __future__ import annotations

import doctest
import inspect
from pathlib import Path

import pytest

import musclewire

NAMES = {name: getattr(musclewire, name) for name in musclewire.__all__}
# The documentation of an alias or a number is that of its type.
OWN = {name: item for name, item in NAMES.items() if str(getattr(item, "__module__", "")).startswith("musclewire")}
EXAMPLES = [name for name, item in OWN.items() if ">>> " in (inspect.getdoc(item) or "")]


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_example_of_a_public_name_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # an example may write a file
    # An equation's example calls it by its name, as its module has it.
    (test,) = doctest.DocTestFinder(recurse=False).find(OWN[name], name, globs={name: OWN[name]})
    results = doctest.DocTestRunner().run(test)
    assert results.attempted > 0
    assert results.failed == 0
