"""The FMU of a controller: FMPy's check, Python's tick, its messages, its own sources."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from emulation.exported_library.on_this_machine import full_scales
from tests.extras.board.export.export_parts import drive_limits, whole_model
from tests.extras.interfaces.export.fmu_parts import ERROR, WARNING, Slave
from tests.tools import require_oracle, require_tool

import musclewire as mw
from musclewire.controllers import Event, State
from musclewire.errors import CallerError
from musclewire.extras.board import ReferenceTick, TickOutcome, exercise, limits_of_rig, settings_in_c

pytestmark = pytest.mark.oracles
fmpy = require_oracle("fmpy")
build_platform_binary = require_oracle("fmpy.build").build_platform_binary
simulate_fmu = require_oracle("fmpy.simulation").simulate_fmu
validate_fmu = require_oracle("fmpy.validation").validate_fmu

PERIOD_S = 0.05
NAMES = {"valid": "estimate_valid", "state": "protection_state", "event": "protection_event"}
RECORDED = {"kp": "steady_power_w", "ki": "pending_heat_j", "kd": "power_limited"}
# The defaults, and the paper's by name.
LOOPS = {"inverse-model": {}, "fuzzy-pid": {"estimator": "polynomial", "controller": "fuzzy-pid"}}


@pytest.fixture(scope="module", params=LOOPS)
def controller(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def exported(controller: str, tmp_path_factory: pytest.TempPathFactory) -> Any:
    require_tool("gcc", "gcc libc6-dev")
    return mw.export_fmu(whole_model(), tmp_path_factory.mktemp("fmu"), **LOOPS[controller])


@pytest.fixture
def slave(exported: Any) -> Iterator[Slave]:
    with Slave(exported.path) as opened:
        yield opened


def reference(controller: str) -> ReferenceTick:
    model = whole_model()
    limits = limits_of_rig("simulated")[0]
    estimator = LOOPS[controller].get("estimator", "filter")
    settings = settings_in_c(model, controller, sample_period_s=PERIOD_S)
    return ReferenceTick(model, settings, drive_limits(limits), limits, estimator=estimator)


def differences(slave: Slave, outcome: TickOutcome, scales: dict[str, float]) -> dict[str, float]:
    """Return how far the FMU is from an outcome, relative to each value or a thousandth of its full scale."""
    found = {}
    names = NAMES if slave.knows("kp") else NAMES | RECORDED
    for name, wanted in outcome._asdict().items():
        got = slave.get(names.get(name, name))
        found[name] = abs(got - float(wanted)) / max(abs(float(wanted)), 1e-3 * scales[name])
    return found


def test_fmpy_finds_nothing_to_complain_of(exported: Any) -> None:
    assert validate_fmu(str(exported.path)) == []


@pytest.mark.parametrize("faults", [0.0, 0.02], ids=["calm", "with faults"])
def test_every_tick_is_python_s(controller: str, slave: Slave, faults: float) -> None:
    python = reference(controller)
    scales = full_scales(python)
    worst = dict.fromkeys(TickOutcome._fields, 0.0)
    for tick in exercise(python, 31, 2000, fault_probability=faults):
        if tick.start:
            slave.fmu.reset()
            slave.start()
        slave.set(wire_voltage_v=tick.wire_voltage_v, shunt_voltage_v=tick.shunt_voltage_v, target=tick.target)
        slave.step(tick.tick_s)
        found = differences(slave, tick.outcome, scales)
        worst = {name: max(most, found[name]) for name, most in worst.items()}
    assert [worst[name] for name in ("resistance_ohm", "estimate", "valid", "state", "event")] == [0.0] * 5
    assert max(worst.values()) <= 1e-12, worst


def test_with_shorter_communication_steps_it_samples_each_and_controls_at_its_period(
    controller: str, slave: Slave
) -> None:
    python = reference(controller)
    scales = full_scales(python)
    slave.start()
    # Sums of such steps are exact: Python's filter takes differences of times.
    model, step_s, elapsed_s = whole_model(), 2.0**-7, 0.0
    for index in range(1000):
        share = 0.5 + 0.4 * math.sin(0.01 * index)
        ohm = model.resistance_min_ohm + share * (model.resistance_max_ohm - model.resistance_min_ohm)
        current = python.drive_voltage_v / (ohm + 1.0)
        slave.set(wire_voltage_v=current * ohm, shunt_voltage_v=current, target=0.02)
        slave.step(step_s)
        outcome = python.sample(current * ohm, current, step_s)
        elapsed_s += step_s
        if elapsed_s > PERIOD_S - 1e-9:
            outcome, elapsed_s = python.control(0.02, elapsed_s), 0.0
        assert max(differences(slave, outcome, scales).values()) <= 1e-12


def test_at_rest_the_sense_voltage_is_out_and_nothing_is_known(slave: Slave) -> None:
    slave.start()
    limits = limits_of_rig("simulated")[0]
    assert slave.get("drive_voltage_v") == limits.sense_voltage_v
    assert slave.get("protection_state") == State.ARMED
    assert not slave.get("estimate_valid")


def test_a_trip_is_a_warning_that_names_its_cause_once(slave: Slave) -> None:
    slave.start()
    slave.set(wire_voltage_v=math.nan, shunt_voltage_v=0.05, target=0.02)
    for _ in range(10):
        slave.step(PERIOD_S)
    assert slave.get("drive_voltage_v") == 0.0
    assert slave.get("protection_event") == Event.READING_NOT_FINITE
    assert [status for status, _ in slave.messages] == [WARNING]
    assert slave.messages[0][1].startswith("protection: at 0.05 s reading_not_finite: the state is now ")


@pytest.mark.parametrize(
    ("act", "said"),
    [
        (lambda slave: slave.step(PERIOD_S), "caller: fmi2DoStep can only be called between"),
        (lambda slave: (slave.start(), slave.step(math.nan)), "caller: the communication step at 0 s is nan s"),
        (lambda slave: (slave.start(), slave.set(control_period_s=0.1)), "caller: control_period_s is fixed: set it"),
        (lambda slave: slave.set(control_period_s=-1.0), "caller: control_period_s is -1 at 0 s: give 0 to 3600"),
        (lambda slave: slave.set(estimate=0.1), "caller: estimate cannot be set: it is computed"),
        (lambda slave: slave.fmu.setReal([99], [0.0]), "caller: there is no Real variable with value reference 99"),
    ],
)
def test_a_wrong_call_is_an_error_of_the_caller_with_its_remedy(slave: Slave, act: object, said: str) -> None:
    with pytest.raises(Exception, match="fmi2"):
        act(slave)  # type: ignore[operator]
    assert slave.messages[-1][0] == ERROR
    assert slave.messages[-1][1].startswith(said)
    slave.fmu.reset()
    slave.start()
    slave.step(PERIOD_S)


def test_a_binary_of_another_export_is_refused_by_its_guid(exported: Any) -> None:
    folder = Path(fmpy.extract(str(exported.path)))
    description = folder / "modelDescription.xml"
    guid = fmpy.read_model_description(str(folder)).guid
    description.write_text(description.read_text().replace(guid, "{0}"))
    with pytest.raises(Exception, match="instantiate"):
        Slave(exported.path, folder)


def test_its_own_sources_compile_without_a_warning_and_give_the_same_numbers(exported: Any, tmp_path: Path) -> None:
    require_tool("cmake", "cmake make")
    folder = tmp_path / "unpacked"
    with zipfile.ZipFile(exported.path) as archive:
        archive.extractall(folder)
    binary = folder / "binaries" / exported.platform / "controller.so"
    shipped = binary.read_bytes()
    binary.unlink()
    options = {"CMAKE_C_FLAGS:STRING": "-std=c99 -pedantic -Wall -Wextra -Werror"}
    (tmp_path / "build").mkdir()
    build_platform_binary(folder, tmp_path / "build", cmake_options=options)
    assert binary.exists()
    values = {"wire_voltage_v": 0.28, "shunt_voltage_v": 0.0175, "target": 0.02}
    ours = simulate_fmu(str(exported.path), stop_time=0.5, output_interval=PERIOD_S, start_values=values)
    theirs = simulate_fmu(str(folder), stop_time=0.5, output_interval=PERIOD_S, start_values=values)
    assert ours.tolist() == theirs.tolist()
    assert shipped != b""


def test_the_same_model_gives_the_same_bytes_and_another_is_not_replaced_unasked(
    controller: str, exported: Any, tmp_path: Path
) -> None:
    again = mw.export_fmu(whole_model(), tmp_path, **LOOPS[controller])
    assert again.path.read_bytes() == exported.path.read_bytes()
    other = whole_model(normalised_max=0.9)
    with pytest.raises(CallerError, match="is another FMU"):
        mw.export_fmu(other, tmp_path, **LOOPS[controller])
    assert again.path.read_bytes() == exported.path.read_bytes()
    assert (
        mw.export_fmu(other, tmp_path, overwrite=True, **LOOPS[controller]).path.read_bytes()
        != exported.path.read_bytes()
    )


def test_without_a_compiler_it_says_so_and_sources_alone_are_to_be_had(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    with pytest.raises(CallerError, match=r"no C compiler .* sources_only=True"):
        mw.export_fmu(whole_model(), tmp_path)
    assert not list(tmp_path.glob("*.fmu"))
    written = mw.export_fmu(whole_model(), tmp_path, sources_only=True)
    assert (written.platform, written.compiler) == ("", "")
    assert fmpy.supported_platforms(str(written.path)) == ["c-code"]
    assert validate_fmu(str(written.path)) == []
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(CallerError, match="CC names 'no-such-compiler'"):
        mw.export_fmu(whole_model(), tmp_path)
