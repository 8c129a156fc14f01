"""A wire of a study is the wire of the rig that the same values make; ideal readings are a rig's without its errors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.extras.studies.unit.study_parts import study_of

from musclewire.errors import CallerError
from musclewire.extras.studies import Workers, sweep
from musclewire.extras.studies._varied_rig import VariedRig, keys_of
from musclewire.identify import fit, loop_gaps
from musclewire.parameters import GrainQuantiles, load_alloy, load_bench, load_wire, wire_file_text
from musclewire.rigs import RigConfiguration, open_rig
from musclewire.wire import constants_from

HERE = Workers(processes=1)
NO_ERRORS = {
    "acquisition_noise_v": 1e-12,
    "acquisition_bits": 50.0,
    "displacement_noise_m": 0.0,
    "force_noise_n": 0.0,
    "endpoint_noise_m": 0.0,
    "endpoint_force_noise_n": 0.0,
}
LOADS: list[list[dict[str, Any]]] = [
    [],
    [{"part": "spring", "stiffness": 400.0}, {"part": "spring", "stiffness": 100.0, "slack": 0.001}],
    [{"part": "weight", "force": 1.2}],
    [{"part": "pretensioner", "stiffness": 386.2}, {"part": "finger", "finger": "lan-fan-2010"}],
    [{"part": "blocked"}],
]


@settings(max_examples=20)
@given(
    load=st.sampled_from(LOADS),
    values=st.fixed_dictionaries(
        {
            "pretension": st.floats(0.2, 2.5),
            "diameter_m": st.floats(0.9e-4, 1.1e-4),
            "ambient_temperature_k": st.floats(280.0, 310.0),
            "martensite_temperature_k": st.floats(315.0, 335.0),
            "new_wire": st.booleans(),
        }
    ),
)
def test_its_constants_are_those_of_the_rig_to_the_bit(load: list[dict[str, Any]], values: dict[str, Any]) -> None:
    if load and load[0]["part"] == "weight":
        values = {name: value for name, value in values.items() if name != "pretension"}
    configuration = RigConfiguration.model_validate({"load": load} if load else {})
    rig = VariedRig(configuration, "test", values)
    alone = rig.wire(values).constants
    with rig.open(values, 1) as opened:
        inside = opened.device.wires.constants  # type: ignore[attr-defined]  # a rig shows no one its constants
    assert alone.numbers.tobytes() == inside.numbers.tobytes()
    assert np.array_equal(alone.load_table_n, inside.load_table_n)


@pytest.mark.parametrize("rig", ["simulated", "finger"])
def test_ideal_readings_are_those_of_a_rig_without_errors(rig: str) -> None:
    """Both ways to the same loop: through instruments, converter and protection, and past them."""
    base: dict[str, Any] = {"simulated": {}, "finger": {"wire": "finger-100um", "bench": "finger", "load": LOADS[3]}}[
        rig
    ]
    keep = [
        "strain_gap",
        "force_gap",
        "displacement_gap",
        "resistance_min_ohm",
        "resistance_max_ohm",
        "stroke",
        "strain",
    ]
    study = study_of(
        rig={**base, "settings": NO_ERRORS},
        parameters={"run.readings": {"values": ["ideal", "rig"]}},
        run={"kind": "characterize", "cycles": 1, "period": "30 s", "keep": keep},
    )
    result = sweep(study, workers=HERE)
    assert result.errors == ("", "")
    for name, column in result.columns.items():
        assert column[0] == pytest.approx(column[1], rel=1e-6, abs=1e-9), name


def test_the_gaps_are_those_of_loop_gaps_and_the_fit_is_fits() -> None:
    from musclewire.extras.studies._characterize_runs import CharacterizeOptions, drive_v, loop_numbers
    from musclewire.extras.studies._ideal_runs import ideal_run

    options = CharacterizeOptions(cycles=1, period=60.0, fit=True)
    wire = VariedRig(RigConfiguration(), "test", []).wire({})
    found = ideal_run(wire, drive_v(options, wire))
    names = frozenset({"strain_gap", "force_gap", "displacement_gap", "fit_rmse", "fit_order"})
    numbers = loop_numbers(found.recording, options, names)
    gaps, model = loop_gaps(found.recording), fit(found.recording)
    assert numbers == {
        "strain_gap": gaps.strain_gap,
        "force_gap": gaps.force_gap,
        "displacement_gap": gaps.displacement_gap,
        "fit_rmse": model.rmse_average,
        "fit_order": model.order,
    }


def test_what_ideal_readings_leave_out_is_said_for_each_run() -> None:
    result = sweep(study_of(rig={"surroundings": {"draught": 0.1}}), workers=HERE)
    assert result.failed == 2
    assert all("moving air" in text and 'readings = "rig"' in text for text in result.errors)


def test_the_readings_of_a_run_are_its_own_whatever_the_others_have() -> None:
    """Ideal readings and a rig's differ by noise; runs of both in one chunk must not share one way."""
    study = study_of(parameters={"run.readings": {"values": ["ideal", "rig", "ideal"]}})
    together = sweep(study, workers=HERE)
    apart = sweep(study, workers=Workers(processes=1, runs_per_chunk=1))
    assert together.columns["stroke"].tolist() == apart.columns["stroke"].tolist()
    assert together.columns["stroke"][0] == together.columns["stroke"][2] != together.columns["stroke"][1]


def test_a_name_that_nothing_on_the_rig_has_is_refused_with_the_nearest() -> None:
    with pytest.raises(CallerError, match=r"did you mean 'surroundings\.draught'"):
        VariedRig(RigConfiguration(), "test", ["surroundings.draugt"])
    assert "load.spring.stiffness" not in keys_of(RigConfiguration())


def test_a_number_of_a_study_that_no_wire_survives_is_refused_unless_the_file_confirms_it() -> None:
    with pytest.raises(CallerError, match="study: wire_length 60 m"):
        VariedRig(RigConfiguration(), "study", ["wire_length"]).wire({"wire_length": 60.0})
    beyond = VariedRig(RigConfiguration(beyond_catalogue=True), "study", ["wire_length"])
    assert beyond.wire({"wire_length": 60.0}).spool.bench["wire_length_m"] == 60.0


def test_a_study_that_varies_the_length_drives_each_wire_by_its_own_amplitude() -> None:
    varied = VariedRig(RigConfiguration(), "study", ["wire_length"])
    for length_m in (0.06, 0.14, 0.2):
        wire = varied.wire({"wire_length": length_m}).spool.wire
        with open_rig("simulated", wire_length_m=length_m) as rig:
            own = (rig.drive_amplitude_v, rig.maximum_voltage_v)
        assert (wire["drive_amplitude_v"], wire["maximum_voltage_v"]) == own
    stated = VariedRig(RigConfiguration(drive_amplitude=3.0), "study", ["wire_length"])
    assert stated.wire({"wire_length": 0.06}).spool.wire["drive_amplitude_v"] == 3.0


def test_varying_what_measured_quantiles_replace_is_an_error(tmp_path: Path) -> None:
    table = GrainQuantiles(
        fraction=(0.0, 0.17, 0.5, 0.9, 1.0), offset=(-4.7, -1.0, 0.0, 1.4, 4.0), kind="measured", source="an isobar"
    )
    alloy, wire = load_alloy("flexinol").model_copy(update={"grain_quantiles": table}), load_wire("paper-100um")
    path = tmp_path / "mine.toml"
    path.write_text(wire_file_text("mine", "", wire, alloy, {}), "utf-8")
    configuration = RigConfiguration(kind="simulated", wire=str(path))
    own = VariedRig(configuration, "mine", ["martensite_barrier_k"]).wire({"martensite_barrier_k": 10.0})
    measured = constants_from(alloy, wire, load_bench("paper")).distribution_cells
    assert np.array_equal(own.constants.distribution_cells, measured)
    with pytest.raises(CallerError, match="'grain_skew' has no effect"):
        VariedRig(configuration, "mine", ["grain_skew"]).wire({"grain_skew": 0.1})
