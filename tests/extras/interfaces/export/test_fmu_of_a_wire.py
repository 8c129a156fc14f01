"""The FMU of a wire: FMPy's check, Python's trajectory, inputs and parameters, its messages, its own sources."""

from __future__ import annotations

import math
import re
import subprocess
import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from tests.extras.board.export.export_parts import whole_model
from tests.extras.interfaces.export.fmu_parts import DISCARD, ERROR, Slave
from tests.tools import require_oracle, require_tool

import musclewire as mw
from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, NumericsError
from musclewire.rigs import FingerTendon, RigConfiguration, SimulatedDevice, open_simulated, rig_configuration
from musclewire.wire import (
    OneWire,
    StepControl,
    WireConstants,
    WireMeans,
    WireState,
    advance,
    resting_state,
    with_pretension,
)

pytestmark = pytest.mark.oracles
fmpy = require_oracle("fmpy")
build_platform_binary = require_oracle("fmpy.build").build_platform_binary
validate_fmu = require_oracle("fmpy.validation").validate_fmu

SAMPLE_S = 0.05
# What is asked for is 1e-9; what is found is the same bits, on machines with IEEE 754 arithmetic.
MAX_DIFFERENCE = 1e-9
FINGER = [{"part": "pretensioner", "stiffness": 386.2}, {"part": "finger", "finger": "lan-fan-2010"}]
RIGS: dict[str, str | RigConfiguration] = {
    "simulated": "simulated",
    "finger": "finger",
    "friction": RigConfiguration(settings={"guide_friction_n": 0.3, "guide_presliding_m": 1e-5}),
    "slack": RigConfiguration(settings={"guide_friction_n": 0.4, "pretension_n": 0.05}),
    "new": RigConfiguration(new_wire=True),
    "touch": RigConfiguration.model_validate(
        {
            "wire": "finger-100um",
            "bench": "finger",
            "load": [*FINGER, {"part": "contact", "stiffness": 200.0, "clearance": 0.003}],
        }
    ),
    # Twice the length of wire that the finger's curve is for.
    "too long": RigConfiguration.model_validate({"load": FINGER}),
}


class Wire(NamedTuple):
    """An exported wire and what Python computes it with."""

    fmu: Any
    device: SimulatedDevice
    constants: WireConstants


@pytest.fixture(scope="session")
def wires(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Wire]:
    """The FMU of each rig, written once."""
    known: dict[str, Wire] = {}

    def of(name: str) -> Wire:
        if name not in known:
            require_tool("gcc", "gcc libc6-dev")
            configuration, where = rig_configuration(RIGS[name])
            assert isinstance(configuration, RigConfiguration)
            device = open_simulated(configuration, where)
            wires = device.wires
            assert isinstance(wires, OneWire)
            known[name] = Wire(mw.export_fmu(RIGS[name], tmp_path_factory.mktemp("fmu")), device, wires.constants)
        return known[name]

    return of


def shown(
    state: WireState, means: WireMeans, of: WireConstants, tendon: FingerTendon | None = None
) -> dict[str, float]:
    """Return Python's numbers by the names of the FMU's outputs."""
    endpoint = {}
    for prefix, at_m in (("", state.connector_contraction * of.leg_length_m), ("mean_", means.displacement_m)):
        if tendon is not None:
            force_n = float(tendon.endpoint_force_n(at_m))
            endpoint[f"{prefix}endpoint_force_n"] = force_n
            endpoint[f"{prefix}endpoint_displacement_m"] = float(tendon.endpoint_m(at_m, force_n))
    return {
        **endpoint,
        "displacement_m": state.connector_contraction * of.leg_length_m,
        "force_n": state.stress_pa * of.legs * of.area_m2,
        "resistance_ohm": state.resistance_ohm,
        "temperature_k": state.temperature_k,
        "martensite_fraction": state.martensite_fraction,
        "r_phase_fraction": state.r_phase_fraction,
        "stress_pa": state.stress_pa,
        "contraction": state.contraction,
        "friction_force_n": state.friction_n,
        "slack_m": (state.connector_contraction - state.contraction) * of.leg_length_m,
        "heat_in_j": state.heat_in_j,
        "heat_out_j": state.heat_out_j,
        "cycles": state.cycles,
        "step_error_k": state.step_error_k,
        "mean_wire_voltage_v": means.wire_voltage_v,
        "mean_shunt_voltage_v": means.shunt_voltage_v,
        "mean_displacement_m": means.displacement_m,
        "mean_force_n": means.force_n,
    }


def rows_of_python(
    constants: WireConstants, drive: Iterable[float], step_s: float, tendon: FingerTendon | None = None
) -> list[dict[str, float]]:
    """Return Python's numbers after each sample."""
    state, rows = resting_state(constants), []
    for voltage in drive:
        state, means = advance(state, constants, voltage, SAMPLE_S, StepControl(fixed_s=step_s))
        rows.append(shown(state, means, constants, tendon))
    assert state.unsolved_steps == 0.0
    return rows


def rows_of_fmu(
    path: Path, drive: Iterable[float], step_s: float, folder: Path | None = None, **start: float
) -> list[dict[str, float]]:
    """Return the FMU's outputs after each communication step; ``folder`` is where it has been unpacked already."""
    rows = []
    with Slave(path, folder) as slave:
        slave.start(step_s=step_s, **start)
        for voltage in drive:
            slave.set(drive_voltage_v=voltage)
            slave.step(SAMPLE_S)
            rows.append(slave.outputs())
    return rows


def largest_differences(ours: list[dict[str, float]], python: list[dict[str, float]]) -> dict[str, float]:
    """Return the largest difference of each number, relative to its largest magnitude in the run."""
    found = {}
    for name in python[0]:
        full = max(abs(row[name]) for row in python) or 1.0
        found[name] = max(abs(one[name] - other[name]) for one, other in zip(ours, python, strict=True)) / full
    return found


def slow_loop(device: SimulatedDevice) -> FloatArray:
    """Return the drive of two slow cycles of 45 s: a loop of 90 s."""
    time_s = SAMPLE_S * np.arange(1800)
    return np.asarray(device.facts.drive_amplitude_v * np.sin(np.pi * time_s / 45.0) ** 2)


def drive_staircase(device: SimulatedDevice) -> FloatArray:
    """Return steps of the drive voltage up and down, 1.5 s each, with two jumps to the largest drive."""
    full = device.facts.drive_amplitude_v
    levels = [0.2, 0.5, 0.7, 0.8, 0.9, 1.0, 0.9, 0.75, 0.85, 0.6, 0.3, 1.0, 0.0, 0.7, 0.1]
    drive = np.repeat(full * np.array(levels), 30)
    drive[300:304] = drive[400:403] = device.facts.limits.maximum_voltage_v
    return drive


COURSES = {"loop of 90 s": slow_loop, "staircase": drive_staircase}


@pytest.mark.parametrize("name", RIGS)
def test_fmpy_finds_nothing_to_complain_of(wires: Callable[[str], Wire], name: str) -> None:
    assert validate_fmu(str(wires(name).fmu.path)) == []


@pytest.mark.parametrize("step_s", [pytest.param(0.01, id="10 ms"), 0.05])
@pytest.mark.parametrize("course", COURSES)
@pytest.mark.parametrize("name", [name for name in RIGS if name != "too long"])
def test_the_trajectory_is_python_s(wires: Callable[[str], Wire], name: str, course: str, step_s: float) -> None:
    wire = wires(name)
    drive = COURSES[course](wire.device)
    python = rows_of_python(wire.constants, drive, step_s, wire.device.mechanism.tendon)
    found = largest_differences(rows_of_fmu(wire.fmu.path, drive, step_s), python)
    assert max(found.values()) <= MAX_DIFFERENCE, found
    assert max(row["martensite_fraction"] for row in python) - min(row["martensite_fraction"] for row in python) > 0.3


@pytest.mark.parametrize("course", COURSES)
def test_with_steps_by_tolerance_the_trajectory_is_python_s_too(wires: Callable[[str], Wire], course: str) -> None:
    wire = wires("finger")
    drive = COURSES[course](wire.device)
    python = rows_of_python(wire.constants, drive, 0.0)
    found = largest_differences(rows_of_fmu(wire.fmu.path, drive, 0.0), python)
    assert max(found.values()) <= MAX_DIFFERENCE, found


def test_a_course_with_slack_is_among_them(wires: Callable[[str], Wire]) -> None:
    wire = wires("slack")
    rows = rows_of_python(wire.constants, drive_staircase(wire.device), 0.01)
    assert max(row["slack_m"] for row in rows) > 0.0
    assert min(row["stress_pa"] for row in rows) == 0.0


def test_an_object_is_touched_in_one_of_them(wires: Callable[[str], Wire]) -> None:
    wire = wires("touch")
    rows = rows_of_fmu(wire.fmu.path, slow_loop(wire.device)[:900], 0.05)
    assert max(row["endpoint_force_n"] for row in rows) > 0.01


def test_a_tendon_drawn_beyond_its_curve_is_an_error(wires: Callable[[str], Wire]) -> None:
    wire = wires("too long")
    with Slave(wire.fmu.path) as slave:
        slave.start()
        slave.set(drive_voltage_v=wire.device.facts.limits.maximum_voltage_v)
        with pytest.raises(Exception, match="fmi2DoStep"):
            step_often(slave, 200)
        assert re.match(r"caller: at .* s the tendon has travelled .* mm more than the f", slave.messages[-1][1])
        assert slave.get("displacement_m") < 1.4e-3


def step_often(slave: Slave, steps: int) -> None:
    for _ in range(steps):
        slave.step(SAMPLE_S)


def moving_air(of: WireConstants, index: int) -> tuple[dict[str, float], WireConstants]:
    """Air that moves and warms: the inputs at a sample, and the constants that they make of a wire's."""
    given = {"ambient_temperature_k": 295.15 + 0.05 * index, "convection_ratio": 1.0 + 0.5 * math.sin(0.1 * index)}
    factor = of.convection_factor * given["convection_ratio"]
    return given, of.replace(ambient_temperature_k=given["ambient_temperature_k"], convection_factor=factor)


def external_force(of: WireConstants, index: int) -> tuple[dict[str, float], WireConstants]:
    """A force at the connector, which Python calls more pretension of a wire already zeroed."""
    force_n = 0.4 * math.sin(0.05 * index)
    return {"external_force_n": force_n}, of.replace(pretension_n=of.pretension_n + force_n)


@pytest.mark.parametrize("inputs", [moving_air, external_force])
def test_inputs_that_change_are_python_s(
    wires: Callable[[str], Wire], inputs: Callable[[WireConstants, int], tuple[dict[str, float], WireConstants]]
) -> None:
    wire = wires("simulated")
    state = resting_state(wire.constants)
    ours, python = [], []
    with Slave(wire.fmu.path) as slave:
        slave.start(step_s=0.01)
        for index in range(200):
            given, changed = inputs(wire.constants, index)
            state, means = advance(state, changed, 2.8, SAMPLE_S, StepControl(fixed_s=0.01))
            python.append(shown(state, means, changed))
            slave.set(drive_voltage_v=2.8, **given)
            slave.step(SAMPLE_S)
            ours.append(slave.outputs())
    found = largest_differences(ours, python)
    assert max(found.values()) <= MAX_DIFFERENCE, found


FACTORS = {
    "pretension_n": (0.0, 1.5),
    "spring_stiffness_n_per_m": (0.0, 5.0),
    "series_resistance_ohm": (0.8, 3.0),
    "convection_factor": (0.5, 3.0),
    "martensite_temperature_k": (0.95, 1.05),
    "martensite_stress_rate_pa_per_k": (0.7, 1.5),
    "martensite_barrier_k": (0.2, 2.0),
    "r_phase_temperature_k": (0.95, 1.05),
    "r_phase_entropy_ratio": (0.3, 1.0),
    "r_phase_spread_k": (0.1, 1.0),
    "martensite_spread_k": (0.8, 2.0),
    "strain_stress_scale_pa": (0.3, 3.0),
    "austenite_modulus_pa": (0.5, 1.5),
    "martensite_modulus_pa": (0.5, 1.5),
}


@st.composite
def changed_wires(draw: st.DrawFn, of: WireConstants) -> dict[str, float]:
    """Parameters of another wire: those of a wire by factors, and any friction."""
    changes = {name: getattr(of, name) * draw(st.floats(low, high)) for name, (low, high) in FACTORS.items()}
    changes["friction_n"] = draw(st.sampled_from([0.0, 0.05, 0.5, 3.0]))
    changes["friction_presliding_m"] = draw(st.sampled_from([1e-6, 2e-5, 1e-4]))
    changes["shakedown_strain"] = draw(st.sampled_from([0.0, 0.003]))
    return changes


@pytest.mark.parametrize("name", ["simulated", "finger"])
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_any_wire_and_any_drive_give_python_s_trajectory(
    wires: Callable[[str], Wire], name: str, data: st.DataObject
) -> None:
    wire = wires(name)
    changes = data.draw(changed_wires(wire.constants))
    most_v = wire.device.facts.limits.maximum_voltage_v
    drive = data.draw(st.lists(st.floats(0.0, most_v), min_size=5, max_size=15))
    step_s = data.draw(st.sampled_from([0.0, 0.001, 0.01, 0.05]))
    try:
        constants = with_pretension(wire.constants.replace(**changes), changes["pretension_n"])
        python = rows_of_python(constants, np.repeat(drive, 10), step_s)
    except (CallerError, NumericsError):
        assume(False)
    found = largest_differences(rows_of_fmu(wire.fmu.path, np.repeat(drive, 10), step_s, **changes), python)
    assert max(found.values()) <= MAX_DIFFERENCE, found


def test_at_rest_the_outputs_are_those_of_the_resting_wire(wires: Callable[[str], Wire]) -> None:
    wire = wires("finger")
    state = resting_state(wire.constants)
    with Slave(wire.fmu.path) as slave:
        slave.start(drive_voltage_v=0.3)
        found = slave.outputs()
    assert found["temperature_k"] == state.temperature_k
    assert found["resistance_ohm"] == state.resistance_ohm
    assert found["displacement_m"] == found["mean_displacement_m"] == 0.0
    assert found["force_n"] == pytest.approx(wire.constants.pretension_n, rel=1e-15)
    current = 0.3 / (state.resistance_ohm + wire.constants.series_resistance_ohm)
    assert found["wire_voltage_v"] == found["mean_wire_voltage_v"] == current * state.resistance_ohm


@pytest.mark.parametrize(
    ("start", "values", "step_s", "said"),
    [
        ({}, {"drive_voltage_v": math.nan}, SAMPLE_S, r"caller: drive_voltage_v is -?nan at 0 s: give 0 to "),
        ({}, {"external_force_n": math.inf}, SAMPLE_S, r"caller: external_force_n is inf at 0 s"),
        ({"step_s": 0.1}, {}, SAMPLE_S, r"caller: step_s of 0\.1 s does not divide the communication step of 0\.05 s"),
        ({"martensite_spread_k": 1.0}, {}, SAMPLE_S, r"caller: martensite_spread_k is 1 K .* martensite's larger by"),
        ({"austenite_modulus_pa": 70.0}, {}, SAMPLE_S, r"caller: austenite_modulus_pa is 70 at 0 s: give "),
        ({}, {"pretension_n": 1.0}, SAMPLE_S, r"caller: pretension_n is fixed: set it before the end of init"),
    ],
)
def test_what_cannot_be_is_an_error_of_the_caller_with_its_remedy(
    wires: Callable[[str], Wire], start: dict[str, float], values: dict[str, float], step_s: float, said: str
) -> None:
    with Slave(wires("simulated").fmu.path) as slave:
        with pytest.raises(Exception, match="fmi2"):
            start_and_step(slave, start, values, step_s)
        assert slave.messages[-1][0] == ERROR
        assert re.match(said, slave.messages[-1][1]), slave.messages


def start_and_step(slave: Slave, start: dict[str, float], values: dict[str, float], step_s: float) -> None:
    slave.start(**start)
    slave.set(**values)
    slave.step(step_s)


def unpacked(fmu: Any, folder: Path) -> Path:
    with zipfile.ZipFile(fmu.path) as archive:
        archive.extractall(folder)
    return folder


def compiled_again(folder: Path, *flags: str) -> Path:
    """Replace the binary of an unpacked FMU by one with other flags."""
    binary = next((folder / "binaries").rglob("wire.*"))
    sources = sorted((folder / "sources").glob("*.c"))
    command = ["gcc", "-std=c99", "-O1", "-ffp-contract=off", "-fPIC", "-shared", *flags]
    subprocess.run([*command, *map(str, sources), "-o", str(binary)], check=True)
    return folder


def test_a_step_that_cannot_be_solved_is_discarded_and_the_state_is_as_before(
    wires: Callable[[str], Wire], tmp_path: Path
) -> None:
    fmu = wires("friction").fmu
    folder = unpacked(fmu, tmp_path)
    solver = folder / "sources" / "mw_solve.c"
    solver.write_text(solver.read_text().replace("#define MAX_EVALUATIONS 200", "#define MAX_EVALUATIONS 3"))
    with Slave(fmu.path, compiled_again(folder)) as slave:
        slave.start(step_s=0.05)
        slave.set(drive_voltage_v=3.0)
        status = 0
        while status == 0 and slave.time_s < 20.0:
            before = slave.outputs()
            status = slave.status_of_step(slave.time_s, SAMPLE_S)
            slave.time_s += SAMPLE_S
        assert status == DISCARD
        assert re.match(r"numerics: between .* s and .* s 1 balances are unsolved", slave.messages[-1][1])
        assert slave.outputs() == before


def test_a_fixed_step_too_long_for_the_wire_is_discarded_and_one_by_tolerance_is_not(
    wires: Callable[[str], Wire],
) -> None:
    path = wires("simulated").fmu.path
    with Slave(path) as slave, Slave(path) as other:
        for one, step_s in ((slave, 2.0), (other, 0.0)):
            one.start(step_s=step_s)
            one.set(drive_voltage_v=3.0)
        assert slave.status_of_step(0.0, 2.0) == DISCARD
        assert slave.messages[-1][1].startswith("numerics: between 0 s and 2 s 0 balances are unsolved, and a step")
        assert slave.get("temperature_k") == other.get("temperature_k")
        other.step(2.0)
        assert other.get("temperature_k") > 340.0


@pytest.mark.parametrize("name", ["simulated", "finger"])
def test_its_own_sources_compile_without_a_warning_and_give_the_same_bits(
    wires: Callable[[str], Wire], name: str, tmp_path: Path
) -> None:
    require_tool("cmake", "cmake make")
    wire = wires(name)
    folder = unpacked(wire.fmu, tmp_path / "fmu")
    binary = next((folder / "binaries").rglob("wire.*"))
    binary.unlink()
    (tmp_path / "build").mkdir()
    build_platform_binary(
        folder,
        tmp_path / "build",
        cmake_options={"CMAKE_C_FLAGS:STRING": "-std=c99 -pedantic -Wall -Wextra -Wconversion -Werror"},
    )
    drive = drive_staircase(wire.device)[:200]
    assert rows_of_fmu(wire.fmu.path, drive, 0.01, folder) == rows_of_fmu(wire.fmu.path, drive, 0.01)


@pytest.mark.parametrize("name", ["finger", "slack"])
def test_nothing_undefined_happens_in_its_c(wires: Callable[[str], Wire], name: str, tmp_path: Path) -> None:
    wire = wires(name)
    trap = ("-fsanitize=undefined,float-cast-overflow", "-fsanitize-undefined-trap-on-error")
    folder = compiled_again(unpacked(wire.fmu, tmp_path), *trap)
    drive = drive_staircase(wire.device)
    assert rows_of_fmu(wire.fmu.path, drive, 0.01, folder) == rows_of_fmu(wire.fmu.path, drive, 0.01)


@pytest.mark.parametrize("kind", ["wire", "controller"])
def test_memory_is_kept_in_order_over_a_whole_life(wires: Callable[[str], Wire], tmp_path: Path, kind: str) -> None:
    gcc = require_tool("gcc", "gcc libc6-dev")
    fmu = wires("finger").fmu if kind == "wire" else mw.export_fmu(whole_model(), tmp_path)
    folder = unpacked(fmu, tmp_path / "unpacked")
    sources = [*sorted((folder / "sources").glob("*.c")), Path(__file__).with_name("fmu_life.c")]
    watched = [
        "-fsanitize=address,undefined,float-cast-overflow",
        "-fno-sanitize-recover=all",
        "-DFMI2_FUNCTION_PREFIX=my_",
    ]
    flags = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O1", "-g", "-ffp-contract=off", *watched]
    program = tmp_path / "life"
    subprocess.run([gcc, *flags, f"-I{folder / 'sources'}", *map(str, sources), "-o", str(program)], check=True)
    said = subprocess.run([str(program)], capture_output=True, text=True, check=False)
    assert (said.returncode, said.stderr) == (0, ""), said
    assert said.stdout.endswith("the same to the bit\n")


def test_clang_gives_the_same_bits(
    wires: Callable[[str], Wire], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", require_tool("clang", "clang"))
    wire = wires("finger")
    other = mw.export_fmu("finger", tmp_path)
    drive = drive_staircase(wire.device)
    assert rows_of_fmu(other.path, drive, 0.01) == rows_of_fmu(wire.fmu.path, drive, 0.01)


def test_what_the_rig_has_and_the_fmu_has_not_is_said(tmp_path: Path) -> None:
    moving: Any = {"draught": 0.1}
    assert not any("air" in text for text in mw.export_fmu("simulated", tmp_path, sources_only=True).left_out)
    windy = RigConfiguration.model_validate({"surroundings": moving})
    said = mw.export_fmu(windy, tmp_path, name="windy", sources_only=True)
    assert any("[surroundings]" in text for text in said.left_out)
    assert fmpy.supported_platforms(str(said.path)) == ["c-code"]
