"""The textbook examples in the docstrings, which doctest cannot find behind Numba's dispatchers by itself."""

from __future__ import annotations

import doctest
import importlib
import pkgutil
from types import ModuleType

import pytest

import musclewire.physics

MODULES = [f"musclewire.physics.{item.name}" for item in pkgutil.iter_modules(musclewire.physics.__path__)]


def examples_of(module: ModuleType) -> list[doctest.DocTest]:
    """Return the doctests of a module, those of its own compiled functions included."""
    finder = doctest.DocTestFinder()
    found = {test.name: test for test in finder.find(module)}
    for name, item in vars(module).items():
        python_function = getattr(item, "py_func", None)
        if python_function is not None and python_function.__module__ == module.__name__:
            for test in finder.find(python_function, f"{module.__name__}.{name}", module=module, globs=vars(module)):
                found[test.name] = test
    return [test for test in found.values() if test.examples]


@pytest.mark.parametrize("name", MODULES)
def test_the_examples_give_what_they_print(name: str) -> None:
    runner = doctest.DocTestRunner()
    printed: list[str] = []
    for test in examples_of(importlib.import_module(name)):
        runner.run(test, out=printed.append, clear_globs=False)
    assert not runner.summarize(verbose=False).failed, "".join(printed)


def test_the_examples_are_found_at_all() -> None:
    assert MODULES
    examples = [e for name in MODULES for test in examples_of(importlib.import_module(name)) for e in test.examples]
    assert len(examples) >= 10
    behind_dispatchers = examples_of(importlib.import_module("musclewire.physics._heat"))
    assert {test.name.rsplit(".", 1)[1] for test in behind_dispatchers} >= {
        "air_dynamic_viscosity_pa_s",
        "nusselt_churchill_chu",
    }
