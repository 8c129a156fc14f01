"""Facts of a run are read from its recording; a missing one is one line: which, of which recording, what to do."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from musclewire.controllers import staircase
from musclewire.errors import RecordingError
from musclewire.experiment import control_metrics, elapsed
from musclewire.identify import fit, required_quantity
from musclewire.judge import resistance_reading
from musclewire.signals import MetadataValue, Recording, RunFacts, reference_quantity
from musclewire.signals._run_facts import NumberFact

NUMBERS = [name for name, fact in vars(RunFacts).items() if isinstance(fact, NumberFact)]


def recorded(**metadata: MetadataValue) -> Recording:
    """Return 40 samples of a wire with every column that the users of facts read."""
    time_s = 0.05 * np.arange(1, 41)
    strain = 0.02 + 0.01 * np.sin(time_s)
    columns = {
        "time_s": time_s,
        "drive_voltage_v": 1.0 + 0 * time_s,
        "wire_voltage_v": 0.9 - 0.1 * time_s,
        "shunt_voltage_v": 0.1 + 0 * time_s,
        "displacement_m": 0.07 * strain,
        "force_n": 2.0 + strain,
        "wire_temperature_k": 300.0 + 0 * time_s,
        "estimated_strain": strain,
        "target_strain": strain,
        "valid": 1.0 + 0 * time_s,
    }
    return Recording(columns, metadata)


@pytest.mark.parametrize("name", NUMBERS)
def test_a_missing_number_is_one_line_that_names_it_the_recording_and_the_remedy(name: str) -> None:
    bare = recorded(wire="flexinol-100")
    with pytest.raises(
        RecordingError, match=rf"40 rows, flexinol-100\) does not state {name}, the .*{name}="
    ) as raised:
        getattr(bare.facts, name)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("value", ["fast", True, float("nan"), float("inf")])
def test_what_is_no_number_is_refused(name: str, value: MetadataValue) -> None:
    with pytest.raises(RecordingError, match=rf"states {name} = .*no number"):
        getattr(recorded(**{name: value}).facts, name)


@pytest.mark.parametrize("name", NUMBERS)
def test_a_negative_number_is_refused_and_zero_if_something_is_divided_by_it(name: str) -> None:
    with pytest.raises(RecordingError, match=f"states {name} = -1"):
        getattr(recorded(**{name: -1}).facts, name)
    if vars(RunFacts)[name].may_be_zero:
        assert getattr(recorded(**{name: 0}).facts, name) == 0.0
    else:
        with pytest.raises(RecordingError, match="give a number above 0"):
            getattr(recorded(**{name: 0}).facts, name)


USERS: dict[str, tuple[dict[str, MetadataValue], str, Callable[[Recording], object]]] = {
    "time in the closed loop": ({"approach_s": 0.0}, "sample_period_s", elapsed),
    "its approach": ({"sample_period_s": 0.05}, "approach_s", elapsed),
    "metrics": (
        {"leg_length_m": 0.07},
        "sample_period_s",
        lambda recording: control_metrics(recording, "strain", staircase(0.02, 0.03, 0.01)),
    ),
    "resistance": ({}, "shunt_resistance_ohm", resistance_reading),
    "strain": ({"shunt_resistance_ohm": 1.0}, "leg_length_m", lambda one: required_quantity(one, "strain")),
    "a fit": ({"leg_length_m": 0.07}, "shunt_resistance_ohm", fit),
}


@pytest.mark.parametrize("user", USERS)
def test_who_needs_a_fact_says_that_it_is_missing_instead_of_inventing_it(user: str) -> None:
    metadata, missing, ask = USERS[user]
    with pytest.raises(RecordingError, match=missing) as raised:
        ask(recorded(**metadata))
    assert "\n" not in str(raised.value)


def test_a_foreign_file_may_leave_out_legs_wires_load_and_end() -> None:
    facts = recorded(wire_length_m=0.14).facts
    assert (facts.legs, facts.wires, facts.load, facts.cut_off) == (1.0, 1.0, (), "")
    assert facts.leg_length_m == 0.14
    assert recorded(wire_length_m=0.14, legs=2).facts.leg_length_m == 0.07
    assert recorded().facts.leg_length_or_none_m is None


def test_force_without_a_stated_pretension_counts_from_the_least_force() -> None:
    force = reference_quantity(recorded(), "force")
    assert force is not None
    assert force.min() == 0.0


def test_what_ended_early_and_what_is_pulled_are_read_as_stated() -> None:
    facts = recorded(ended="stopped", load="pretensioner, finger", wires=2, wire=100).facts
    assert (bool(facts.cut_off), facts.load, facts.wires) == (True, ("pretensioner", "finger"), 2.0)
    assert facts.text("wire", "name of the wire") == "100"
    with pytest.raises(RecordingError, match="does not state rig, the rig's name"):
        facts.text("rig", "rig's name")
