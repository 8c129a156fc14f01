# ruff: noqa: E402 - a package that may be missing is asked for first
"""Home moves of the population without a word on the load: ageing is corrected, and no load is taken for it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import pytest
from tests.tools import require_package

require_package("musclewire_robustness", "pip install ./studies/robustness")

from musclewire_robustness.characterizing import slow_loop
from musclewire_robustness.plant import open_plant
from musclewire_robustness.population import PopulationWire, drawn_wire, held_out_seeds
from musclewire_robustness.settings import Condition

from musclewire.errors import FitRejectedError, RecordingError
from musclewire.experiment import HomeSweep, plan_for, run_on_rig
from musclewire.identify import fit, homed_model
from musclewire.sensing import SensingModel
from musclewire.signals import Recording

CONDITIONS = {
    "nothing": Condition(name="nothing", bar="none"),
    "R +1 %": Condition(name="R", bar="none", resistance_factor=1.01),
    "R -1 %": Condition(name="R", bar="none", resistance_factor=0.99),
    "load +50 %": Condition(name="load", bar="none", load_fraction=0.5),
    "load -50 %": Condition(name="load", bar="none", load_fraction=-0.5),
}
# The same loads by the stage, at which the instruments are zeroed anew.
PRETENSIONS = {"pretension +50 %, zeroed anew": 1.5, "pretension -50 %, zeroed anew": 0.5}


def with_pretension(wire: PopulationWire, ratio: float) -> PopulationWire:
    pretension = wire.bench.pretension_n
    changed = pretension.model_copy(update={"value": ratio * pretension.value})
    return wire._replace(bench=wire.bench.model_copy(update={"pretension_n": changed}))


def swept(wire: PopulationWire, condition: Condition, model: SensingModel) -> Recording:
    plant = open_plant(wire, condition.model_copy(update={"home": True}), run=3)
    plant.disturbance.change_at(-1.0e3)  # long ago: it is there from the first sample on
    with plant.rig as rig:
        plan = plan_for(rig, model)
        return run_on_rig(rig, HomeSweep(rig, plan), plan.duration_s)


def outcome(model: SensingModel, sweep: Recording) -> str:
    """Return what a home move without a word on the load makes of a sweep."""
    try:
        return "corrected" if homed_model(model, sweep).home.corrected else "kept"
    except (FitRejectedError, RecordingError):
        return "refused"


def judged(seeds: Sequence[int]) -> Counter[tuple[str, str]]:
    """Return how often each change was corrected, kept or refused, and print it."""
    found: Counter[tuple[str, str]] = Counter()
    for seed in seeds:
        wire = drawn_wire(seed)
        model = fit(slow_loop(wire))
        for name, condition in CONDITIONS.items():
            found[name, outcome(model, swept(wire, condition, model))] += 1
        for name, ratio in PRETENSIONS.items():
            found[name, outcome(model, swept(with_pretension(wire, ratio), CONDITIONS["nothing"], model))] += 1
    for name in (*CONDITIONS, *PRETENSIONS):
        print(f"{name}: " + ", ".join(f"{found[name, one]} {one}" for one in ("corrected", "kept", "refused")))
    return found


def accepted(found: Counter[tuple[str, str]], name: str) -> int:
    return found[name, "corrected"] + found[name, "kept"]


@pytest.mark.slow
def test_a_wires_ageing_is_corrected_and_half_its_load_refused() -> None:
    found = judged(held_out_seeds()[:1])
    assert found["nothing", "kept"] == found["R +1 %", "corrected"] == found["R -1 %", "corrected"] == 1
    assert not sum(accepted(found, name) for name in ("load +50 %", "load -50 %", *PRETENSIONS))


@pytest.mark.full
def test_ageing_of_24_wires_is_corrected_and_half_their_load_refused() -> None:
    found = judged(held_out_seeds())
    assert found["nothing", "kept"] == 24
    assert found["R +1 %", "corrected"] + found["R -1 %", "corrected"] >= 44
    assert accepted(found, "load +50 %") + accepted(found, "load -50 %") <= 1
    assert sum(accepted(found, name) for name in PRETENSIONS) <= 1
