"""Libraries as they are exported and as they are compiled, once for all tests."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from emulation.exported_library.on_this_machine import HostLibrary
from tests.extras.board.export.export_parts import SLOW_LOOP, Exported, compiled, export, usual_gains, usual_model

from musclewire.experiment import characterize
from musclewire.identify import fit
from musclewire.rigs import open_rig
from musclewire.sensing import SensingModel


@pytest.fixture(scope="session")
def model() -> SensingModel:
    """The model of the simulated wire, with slow loop and gains."""
    with open_rig("simulated", seed=1) as rig:
        return fit(characterize(rig))


@pytest.fixture(scope="session")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Exported]:
    """A library of the usual model by the name of its rule base, or "filter" for one with that, written once.

    "inverse-model" is one with the filter and that controller.
    """
    known: dict[str, Exported] = {}

    def of(rule_base: str) -> Exported:
        if rule_base not in known:
            folder = tmp_path_factory.mktemp("library")
            if rule_base in ("filter", "inverse-model"):
                model, gains = usual_model(slow_loop=SLOW_LOOP), usual_gains() if rule_base != "filter" else None
                known[rule_base] = export(folder, model=model, settings=gains, estimator="filter")
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
