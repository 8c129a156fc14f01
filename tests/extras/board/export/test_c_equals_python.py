"""The exported C does what Python does: over golden vectors, long random runs, random models and settings."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from emulation.exported_library.on_this_machine import MAX_DIFFERENCE, HostLibrary, largest_differences
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from tests.extras.board.export.export_parts import RULE_BASES, Exported, compiled, export, models, settings_of

from musclewire.extras.board import exercise, golden_ticks
from musclewire.physics import wire_resistance

Libraries = Callable[[str], Exported]
Loaded = Callable[[str, bool], HostLibrary]
# At these a gain is not a continuous function of the error, so single precision may see the other side for one tick.
WITHOUT_JUMPS = [name for name in RULE_BASES if name != "liu-7x7-mirrored"]


def in_ci(*names: str) -> list[pytest.ParameterSet]:
    """Return all rule bases, those that are not named in the group full: to the C code a rule base is a table."""
    return [pytest.param(name, marks=() if name in names else pytest.mark.full) for name in RULE_BASES]


@pytest.mark.parametrize("double", [True, pytest.param(False, marks=pytest.mark.full)], ids=["double", "single"])
@pytest.mark.parametrize("rule_base", RULE_BASES)
def test_the_golden_vectors_hold(exported: Libraries, loaded: Loaded, rule_base: str, double: bool) -> None:
    reference = exported(rule_base).reference()
    found = largest_differences(loaded(rule_base, double), reference, golden_ticks(reference), relative=double)
    assert max(found.values()) <= MAX_DIFFERENCE[double], found


@pytest.mark.parametrize("rule_base", in_ci("zhao-1993", "liu-7x7"))
def test_a_long_random_run_with_faults_is_the_same_to_the_bit_but_for_an_exponential(
    exported: Libraries, loaded: Loaded, rule_base: str
) -> None:
    reference = exported(rule_base).reference()
    found = largest_differences(loaded(rule_base, True), reference, exercise(reference, 11, 8000), relative=True)
    if rule_base != "zhao-1993":
        assert set(found.values()) == {0.0}, found
    assert [found[name] for name in ("resistance_ohm", "estimate", "valid", "state", "event")] == [0.0] * 5
    assert max(found.values()) <= 1e-12, found


@pytest.mark.parametrize("rule_base", [one for one in in_ci("zhao-1993") if one.values[0] in WITHOUT_JUMPS])
def test_a_long_random_run_with_faults_is_close_in_single(exported: Libraries, loaded: Loaded, rule_base: str) -> None:
    reference = exported(rule_base).reference()
    found = largest_differences(loaded(rule_base, False), reference, exercise(reference, 12, 8000), relative=False)
    assert max(found.values()) <= MAX_DIFFERENCE[False], found


def test_the_exercise_reaches_every_event_that_two_voltages_can_show(exported: Libraries) -> None:
    reference = exported("zhao-1993").reference()
    # Over-temperature needs a wire that is driven for long, so one run is almost without faults.
    runs = exercise(reference, 16, 8000, fault_probability=0.05), exercise(reference, 17, 4000, fault_probability=0.001)
    seen = {tick.outcome.event for run in runs for tick in run}
    assert {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13} <= seen


@pytest.mark.slow
@given(data=st.data())
@settings(max_examples=8, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
def test_any_model_with_any_settings_equals_python_in_both_precisions(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    model = data.draw(models())
    chosen = data.draw(settings_of(model))
    one = export(tmp_path_factory.mktemp("library"), model=model, settings=chosen)
    for double, most in MAX_DIFFERENCE.items():
        reference = one.reference()
        loaded = compiled(one.library, tmp_path_factory.mktemp("compiled"), double=double)
        ticks = exercise(reference, data.draw(st.integers(0, 1000)), 200, fault_probability=0.02)
        found = largest_differences(loaded, reference, ticks, relative=double)
        assert max(found.values()) <= most, found


@pytest.mark.parametrize(("double", "kind"), [(True, np.float64), (False, np.float32)], ids=["double", "single"])
def test_the_exponential_is_within_two_units_of_the_last_place(loaded: Loaded, double: bool, kind: type) -> None:
    points = np.linspace(-4.0, 0.0, 20_001).astype(kind)
    exact = np.exp(points.astype(np.longdouble))
    ours = np.array([loaded("zhao-1993", double).exponential(float(x)) for x in points], dtype=np.longdouble)
    assert float(np.max(np.abs(ours - exact) / np.spacing(exact.astype(kind)))) < 2.0
    assert loaded("zhao-1993", double).exponential(0.0) == 1.0


@pytest.mark.parametrize(
    ("wire_v", "shunt_v"),
    [
        (math.nan, 1.0),
        (1.0, math.nan),
        (math.inf, 1.0),
        (1.0, math.inf),
        (1.0, 0.0),
        (0.0, 1.0),
        (-1.0, 1.0),
        (1.0, 5e-4),
    ],
)
def test_no_current_is_no_resistance_as_in_python(
    exported: Libraries, loaded: Loaded, wire_v: float, shunt_v: float
) -> None:
    python = wire_resistance(wire_v, shunt_v, exported("fixed").limits.shunt_resistance_ohm)
    assert loaded("fixed", True).resistance(wire_v, shunt_v) == python.resistance_ohm


@given(resistance_ohm=st.floats(allow_nan=True, allow_infinity=True))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_resistance_at_all_reads_as_in_python(exported: Libraries, loaded: Loaded, resistance_ohm: float) -> None:
    python = exported("fixed").model.estimate(resistance_ohm)
    assert loaded("fixed", True).estimate(resistance_ohm) == (python.value, python.valid)


def test_a_target_that_is_no_number_trips(loaded: Loaded) -> None:
    library = loaded("zhao-1993", False)
    library.start()
    library.sample(1.0, 0.06, 0.05)
    outcome = library.control(math.nan, 0.05)
    assert (outcome.state, outcome.event, outcome.drive_voltage_v) == (4, 14, 0.0)


def test_a_control_tick_without_any_sample_holds_the_drive(exported: Libraries, loaded: Loaded) -> None:
    reference = exported("zhao-1993").reference()
    library = loaded("zhao-1993", False)
    library.start()
    for tick in islice(exercise(reference, 3, 40, fault_probability=0.0), 40):
        before = library.tick(tick)
    after = library.control(0.02, 0.05)
    assert after.drive_voltage_v == before.drive_voltage_v
    assert after.valid is False


def test_the_library_takes_over_from_a_drive_of_the_hosts_without_a_jump(exported: Libraries, loaded: Loaded) -> None:
    limits = exported("zhao-1993").limits
    library = loaded("zhao-1993", True)
    library.start()
    drive_v = 0.5 * limits.maximum_voltage_v
    assert library.drive(drive_v).drive_voltage_v == drive_v
    resistance = exported("zhao-1993").model.resistance_ohm(0.02)
    current = drive_v / (resistance + limits.shunt_resistance_ohm)
    library.sample(current * resistance, current * limits.shunt_resistance_ohm, 0.05)
    assert library.control(0.02, 0.05).drive_voltage_v == pytest.approx(drive_v, rel=1e-9)


def test_a_wrong_path_for_the_folder_is_the_callers_fault(tmp_path: Path) -> None:
    from musclewire.errors import CallerError

    (tmp_path / "file").write_text("")
    with pytest.raises(CallerError, match="cannot write the library"):
        export(tmp_path / "file")
