"""Libraries as they are exported and as they are compiled, once for all tests."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from emulation.exported_library.on_this_machine import HostLibrary
from tests.extras.board.export.export_parts import SLOW_LOOP, Exported, compiled, export, usual_model


@pytest.fixture(scope="session")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Exported]:
    """A library of the usual model by the name of its rule base, or "filter" for one with that, written once."""
    known: dict[str, Exported] = {}

    def of(rule_base: str) -> Exported:
        if rule_base not in known:
            folder = tmp_path_factory.mktemp("library")
            if rule_base == "filter":
                known[rule_base] = export(folder, model=usual_model(slow_loop=SLOW_LOOP), estimator="filter")
            else:
                known[rule_base] = export(folder, rule_base=rule_base)
        return known[rule_base]

    return of


@pytest.fixture(scope="session")
def loaded(
    exported: Callable[[str], Exported], tmp_path_factory: pytest.TempPathFactory
) -> Callable[[str, bool], HostLibrary]:
    """The same, compiled by gcc for this machine, once for each precision."""
    known: dict[tuple[str, bool], HostLibrary] = {}

    def of(rule_base: str, double: bool) -> HostLibrary:
        if (rule_base, double) not in known:
            folder = tmp_path_factory.mktemp("compiled")
            known[rule_base, double] = compiled(exported(rule_base).library, folder, double=double)
        return known[rule_base, double]

    return of
