"""The inverse of the wire's model in C is that of Python: to the bit in double precision, closely in single."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from emulation.exported_library.on_this_machine import HostLibrary, built, largest_differences
from tests.command_line import CommandLine
from tests.extras.board.export.export_parts import SHUNT_OHM, drive_limits, export, limits_for
from tests.tools import require_tool

from musclewire.arrays import FloatArray
from musclewire.controllers import ControllerSetup, FeedforwardSettings, Gains, InverseModelController
from musclewire.errors import CallerError
from musclewire.experiment import control_compiled
from musclewire.extras.board import CLibrary, exercise, golden_ticks, write_library
from musclewire.parameters import load_bench
from musclewire.rigs import RigConfiguration, open_rig
from musclewire.sensing import SensingModel, save_model
from musclewire.signals import Reason

ESTIMATORS = ("filter", "polynomial")
STEPS, RUNS, SLOW_RUNS = 2_000, 50, 500
# Of a whole tick, in parts of full scale: an estimate that the filter has enlarged moves the drive as a step does.
SINGLE_TICK = 2e-3
# By how much single precision moves the drive over random steps, as a part of its range.
SINGLE_RMS, SINGLE_MOST = 3e-6, 3e-4
# Whole numbers of samples are a second, and every difference of times is exact.
PERIOD_S = 2.0**-5


@pytest.fixture(scope="module")
def gains(model: SensingModel) -> FeedforwardSettings:
    settings = Gains.read(model.gains, "the fitted model").settings
    assert isinstance(settings, FeedforwardSettings)
    return settings


@pytest.fixture(scope="module")
def library(
    model: SensingModel, gains: FeedforwardSettings, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, CLibrary]:
    """Libraries of the fitted model with its gains, by estimator."""
    limits, folder = limits_for(model, SHUNT_OHM), tmp_path_factory.mktemp("libraries")
    numbers = (model, gains, drive_limits(limits), limits)
    return {name: write_library(*numbers, folder / name, estimator=name) for name in ESTIMATORS}


@pytest.fixture(scope="module")
def loaded(
    library: dict[str, CLibrary], tmp_path_factory: pytest.TempPathFactory
) -> dict[tuple[str, bool], HostLibrary]:
    """The same compiled, by estimator and whether it is in double precision."""
    require_tool("gcc", "gcc libc6-dev")
    folder = tmp_path_factory.mktemp("compiled")
    return {
        (name, double): HostLibrary(built(one.folder, folder, double=double), double=double)
        for name, one in library.items()
        for double in (True, False)
    }


def random_steps(gains: FeedforwardSettings, seed: int) -> FloatArray:
    """Return what a controller is given in steps, as its tick takes it, with all that may come.

    Targets that rest, jump, ramp and leave the tables; values that follow, err and are met; deviations from none to the
    whole range; stretches that are cold, not ready, without current or without the wire's state; numbers that are none.
    """
    random = np.random.default_rng(seed)
    span = gains.highest - gains.lowest
    levels = np.repeat(random.uniform(gains.lowest - 0.3 * span, gains.highest + 0.2 * span, STEPS // 50), 50)
    ramp = np.repeat(random.choice([0.0, 0.0, 1e-3, -2e-3], STEPS // 50), 50) * span
    target = levels + ramp * (np.arange(STEPS) % 50)
    value = target + span * random.normal(0.0, 1.0, STEPS) * np.repeat(random.choice([0.0, 1e-3, 0.3], STEPS // 25), 25)
    std = span * random.choice([0.0, 1e-3, 0.02, 1.0], STEPS) * random.random(STEPS)
    reason = np.repeat(random.choice([*map(float, Reason), *[float(Reason.OK)] * 12], STEPS // 20), 20)
    reason[random.random(STEPS) < 0.02] = Reason.NO_CURRENT
    dt_s = np.where(random.random(STEPS) < 0.9, 0.05, random.uniform(1e-3, 2.0, STEPS))
    most_w = gains.maximum_steady_power_w
    wire = [
        random.uniform(0.0, 1.1 * most_w, STEPS),
        random.choice([0.0, 1.0, 0.5, 0.2], STEPS) * random.random(STEPS),
        most_w * random.normal(0.0, 0.05, STEPS),
        random.uniform(0.5, 2.5, STEPS),
        random.uniform(0.0, 2.0 * most_w, STEPS),
    ]
    rows = np.column_stack([target, value, std, reason == Reason.OK, reason, dt_s, *wire])
    rows[np.repeat(random.random(STEPS // 40) < 0.3, 40), 6:] = np.nan
    for column, bad in ((0, np.nan), (0, 1.0), (1, np.inf), (5, 0.0), (5, np.nan), (6, np.inf), (10, np.nan)):
        rows[random.random(STEPS) < 5e-4, column] = bad
    return rows.astype(np.float32).astype(np.float64)


def as_c_takes_it(rows: FloatArray) -> FloatArray:
    """Return rows of a tick as the library takes them: current, cold and wire known, then the numbers."""
    reason = rows[:, 4]
    flags = [reason != Reason.NO_CURRENT, np.isin(reason, (Reason.COLD, Reason.NOT_READY)), ~np.isnan(rows[:, 6])]
    return np.column_stack([*flags, rows[:, :3], rows[:, 5:]])


def stepped_in_python(controller: InverseModelController, rows: FloatArray) -> FloatArray:
    """Return answer and state of each step, as the library has them, and whether it failed."""
    tick = controller.compiled_tick(controller.limits.sense_voltage_v)
    state, answer, found = tick.state.copy(), np.empty(5), np.empty((len(rows), 14))
    for row, out in zip(rows, found, strict=True):
        tick.function(tick.constants, state, row, answer)
        out[0], out[1:4], out[4:13], out[13] = answer[0], answer[2:], state[1:], answer[1]
    return found


def assert_the_same_bits(
    c: HostLibrary, controller: InverseModelController, gains: FeedforwardSettings, runs: range
) -> None:
    """Run random steps by both and compare every number of answers and states."""
    limits, reached = controller.limits, []
    for seed in runs:
        rows = random_steps(gains, seed)
        python = stepped_in_python(controller, rows)
        assert np.isfinite(python).all()
        np.testing.assert_array_equal(c.inverse_model(limits.sense_voltage_v, as_c_takes_it(rows)), python[:, :13])
        drive_v, limited, failed = python[:, 0], python[:, 3], python[:, 13]
        inside = (drive_v > limits.sense_voltage_v) & (drive_v < limits.maximum_voltage_v)
        reached.append((inside.mean(), 1.0 - inside.mean(), limited.mean(), failed.mean()))
    # Drives at their limits and between them, power held back by the highest temperature, and steps that fail.
    assert (np.mean(reached, axis=0) > (0.05, 0.05, 1e-3, 1e-4)).all(), np.mean(reached, axis=0)


def controller_of(library: CLibrary, gains: FeedforwardSettings) -> InverseModelController:
    return InverseModelController(ControllerSetup(library.reference.limits, settings=gains))


def test_every_number_of_100000_random_steps_has_the_bits_of_python(
    library: dict[str, CLibrary], loaded: dict[tuple[str, bool], HostLibrary], gains: FeedforwardSettings
) -> None:
    controller = controller_of(library["filter"], gains)
    assert_the_same_bits(loaded["filter", True], controller, gains, range(RUNS))


@pytest.mark.slow
def test_every_number_of_a_million_random_steps_has_the_bits_of_python(
    library: dict[str, CLibrary], loaded: dict[tuple[str, bool], HostLibrary], gains: FeedforwardSettings
) -> None:
    controller = controller_of(library["filter"], gains)
    assert_the_same_bits(loaded["filter", True], controller, gains, range(RUNS, RUNS + SLOW_RUNS))


def test_single_precision_moves_the_drive_of_random_steps_little(
    library: dict[str, CLibrary], loaded: dict[tuple[str, bool], HostLibrary], gains: FeedforwardSettings
) -> None:
    limits = library["filter"].reference.limits
    apart = []
    for seed in range(10):
        rows = as_c_takes_it(random_steps(gains, seed))
        double, single = (
            loaded["filter", double].inverse_model(limits.sense_voltage_v, rows)[:, 0] for double in (True, False)
        )
        apart.append(np.abs(single - double) / (limits.maximum_voltage_v - limits.sense_voltage_v))
    assert np.sqrt(np.mean(np.square(apart))) < SINGLE_RMS
    assert np.max(apart) < SINGLE_MOST


def test_a_loop_on_the_rig_s_staircase_is_the_compiled_loop_of_python(
    model: SensingModel, gains: FeedforwardSettings, tmp_path: Path
) -> None:
    configuration = RigConfiguration(sample_period=PERIOD_S)
    with open_rig(configuration, seed=3) as rig:
        limits = rig.protection_limits
    run = control_compiled(open_rig(configuration, seed=3), model, estimator="filter", controller="inverse-model")
    written = write_library(model, gains, drive_limits(limits), limits, tmp_path, estimator="filter")
    c = HostLibrary(built(written.folder, tmp_path, double=True), double=True)
    columns = ("estimated_strain", "valid", "steady_power_w", "pending_heat_j", "power_limited")
    python = np.column_stack([run[name] for name in columns])[:-1]
    # A target holds from the end of a sample on; the loop answers the one that comes.
    targets, ours, drives = run["target_strain"][1:], np.empty_like(python), np.empty(len(python))
    for row, target in enumerate(targets):
        c.sample(run["wire_voltage_v"][row], run["shunt_voltage_v"][row], PERIOD_S)
        found = c.control(target, PERIOD_S)
        ours[row], drives[row] = (found.estimate, found.valid, found.kp, found.ki, found.kd), found.drive_voltage_v
    np.testing.assert_array_equal(ours, python)
    step_v = load_bench("paper")["amplifier_resolution_v"]
    np.testing.assert_array_equal(step_v * np.rint(drives / step_v), run["drive_voltage_v"][1:])
    assert len(python) > 2_000


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("double", [True, False], ids=["double", "single"])
def test_a_whole_tick_with_faults_is_that_of_python(
    library: dict[str, CLibrary], loaded: dict[tuple[str, bool], HostLibrary], estimator: str, double: bool
) -> None:
    c, reference = loaded[estimator, double], library[estimator].reference
    for ticks in (golden_ticks(reference), exercise(reference, 11, 2_000)):
        found = largest_differences(c, reference, ticks, relative=double)
        assert max(found.values()) <= (0.0 if double else SINGLE_TICK), found


def test_another_shunt_than_that_of_the_gains_is_the_rig_s(
    model: SensingModel, gains: FeedforwardSettings, tmp_path: Path
) -> None:
    limits = limits_for(model, 2.0)
    written = write_library(model, gains, drive_limits(limits), limits, tmp_path, estimator="filter")
    c = HostLibrary(built(written.folder, tmp_path, double=True), double=True)
    found = largest_differences(c, written.reference, golden_ticks(written.reference), relative=True)
    assert max(found.values()) == 0.0, found


def test_gains_of_another_quantity_are_refused(model: SensingModel, gains: FeedforwardSettings, tmp_path: Path) -> None:
    other = gains.model_copy(update={"quantity": "displacement"})
    with pytest.raises(CallerError, match="gains are of displacement, the model of strain"):
        export(tmp_path, model=model, settings=other)


def test_the_command_writes_it_by_the_model_s_gains(
    model: SensingModel, tmp_path: Path, musclewire: CommandLine
) -> None:
    file, folder = tmp_path / "model.json", tmp_path / "library"
    save_model(model, file)
    asked = ("export", "c", file, "-o", folder)
    assert "controller inverse-model" in musclewire(*asked).out
    header = (folder / "src/mw_constants.h").read_text("utf-8")
    assert "#define MW_INVERSE_MODEL 1" in header
    assert "MW_KP_MAXIMUM" not in header
    answer = musclewire(*asked, "--json").json
    assert (answer["controller"], answer["rule_base"], answer["estimator"]) == ("inverse-model", None, "filter")
    assert "steady_power_w,pending_heat_j,power_limited" in (folder / "test/golden_vectors.csv").read_text("utf-8")
    assert "--estimator filter knows it" in musclewire(*asked, "--estimator", "polynomial", "--overwrite").out


def test_the_paper_s_loop_is_written_by_name_and_says_that_it_is_slow_from_cold(
    model: SensingModel, tmp_path: Path, musclewire: CommandLine
) -> None:
    save_model(model, tmp_path / "model.json")
    asked = ("--estimator", "polynomial", "--controller", "fuzzy-pid")
    said = musclewire("export", "c", tmp_path / "model.json", "-o", tmp_path / "library", *asked).out
    assert "some 12 s from cold: --controller inverse-model does not" in said
    assert "#define MW_KP_MAXIMUM" in (tmp_path / "library/src/mw_constants.h").read_text("utf-8")
