"""The filter of the exported library is that of Python: to the bit in double precision, closely in single."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from emulation.exported_library.on_this_machine import FILTER_DIFFERENCE, HostLibrary, built, largest_differences
from tests.command_line import CommandLine
from tests.extras.board.export.export_parts import SHUNT_OHM, drive_limits, limits_for
from tests.tools import require_tool

from musclewire.arrays import FloatArray
from musclewire.controllers import FuzzyPidSettings
from musclewire.errors import CallerError
from musclewire.experiment import control
from musclewire.extras.board import CLibrary, exercise, golden_ticks, write_library
from musclewire.rigs import open_rig
from musclewire.sensing import ESTIMATORS, EstimatorSetup, SensingModel, save_model
from musclewire.signals import ESTIMATOR_ANSWERS

TICKS, RUNS = 2_000, 60
# Times are multiples of this, so that Python's differences of times are exact.
GRID_S = 2.0**-10
# By how much single precision moves value and deviation on a run, as a part of the range: no more than readings do
# that differ by the rounding of a single. Where power and resistance have nothing to do with one another, as in the
# rows above, neither has a bound: a point of the mean is on either side of B or of the play.
SINGLE_RMS, SINGLE_MOST = 5e-4, 5e-3


@pytest.fixture(scope="module")
def library(model: SensingModel, tmp_path_factory: pytest.TempPathFactory) -> CLibrary:
    limits = limits_for(model, SHUNT_OHM)
    folder = tmp_path_factory.mktemp("library")
    return write_library(model, FuzzyPidSettings(), drive_limits(limits), limits, folder, estimator="filter")


def loaded(library: CLibrary, folder: Path, *, double: bool) -> HostLibrary:
    require_tool("gcc", "gcc libc6-dev")
    return HostLibrary(built(library.folder, folder, double=double), double=double)


def random_rows(model: SensingModel, seed: int) -> FloatArray:
    """Return wire's and shunt's voltage and the time since the last sample, with all that a wire may do.

    Slow loops between cold and hot, steps and noise of the drive; readings without current, of other wires, and times
    between a millisecond and two seconds.
    """
    random = np.random.default_rng(seed)
    at = np.cumsum(random.normal(0.0, 0.02, TICKS))
    part = 0.5 - 0.55 * np.cos(at) + random.normal(0.0, 0.002, TICKS)
    ohm = model.resistance_min_ohm + part * (model.resistance_max_ohm - model.resistance_min_ohm)
    drive_v = np.repeat(random.uniform(0.3, 3.6, TICKS // 40), 40) + random.normal(0.0, 1e-3, TICKS)
    kind = random.random(TICKS)
    ohm[kind < 0.01] *= 1.5
    rows = np.column_stack([drive_v * ohm / (ohm + SHUNT_OHM), drive_v / (ohm + SHUNT_OHM) * SHUNT_OHM, ohm])
    rows[kind > 0.98, :2] = 0.0
    rows[:, 2] = GRID_S * np.where(random.random(TICKS) < 0.9, 50, random.integers(1, 2048, TICKS))
    return rows


def followed_in_python(model: SensingModel, rows: FloatArray) -> FloatArray:
    """Return what the tick makes of the rows: value, deviation, validity, four states and their covariance."""
    estimator = ESTIMATORS.find("filter")(EstimatorSetup(model, SHUNT_OHM, 0.05))
    tick, answer = estimator.compiled_tick(), np.empty(len(ESTIMATOR_ANSWERS) + len(estimator.columns))
    state, found = tick.state.copy(), np.empty((len(rows), 17))
    for row, time_s, out in zip(rows, np.cumsum(rows[:, 2]), found, strict=True):
        tick.function(tick.constants, state, np.array([time_s, 0.0, row[0], row[1]]), answer)
        out[:3], out[3:] = answer[:3], state[-14:]
    return found


def test_every_number_of_120000_random_samples_has_the_bits_of_python(
    model: SensingModel, library: CLibrary, tmp_path: Path
) -> None:
    c, valid = loaded(library, tmp_path, double=True), []
    for seed in range(RUNS):
        rows = random_rows(model, seed)
        rows = rows[int(np.flatnonzero(rows[:, 1])[0]) :]
        c.start()
        python = followed_in_python(model, rows)
        assert np.isfinite(python).all()
        np.testing.assert_array_equal(c.follow(rows), python)
        valid.append(python[:, 2].mean())
    assert 0.1 < np.mean(valid) < 0.9


@pytest.mark.parametrize("seed", [3, 6])
def test_single_precision_is_close_on_runs_of_a_wire(
    model: SensingModel, library: CLibrary, tmp_path: Path, seed: int
) -> None:
    with open_rig("simulated", seed=seed) as rig:
        run = control(rig, model)
    waited_s = np.diff(run["time_s"], prepend=run["time_s"][0] - 0.05)
    rows = np.column_stack([run["wire_voltage_v"], run["shunt_voltage_v"], waited_s]).astype(np.float32)
    rows[np.random.default_rng(seed).random(len(rows)) < 0.05, :2] = 0.0
    double, single = (
        loaded(library, tmp_path, double=double).follow(rows.astype(np.float64)) for double in (True, False)
    )
    apart = np.abs(single - double)[:, :2] / (model.quantity_max - model.quantity_min)
    assert np.sqrt(np.mean(apart**2)) < SINGLE_RMS
    assert apart.max() < SINGLE_MOST
    assert (single[:, 2] == double[:, 2]).all()


@pytest.mark.parametrize("double", [True, False], ids=["double", "single"])
def test_a_closed_loop_by_the_filter_is_that_of_python(library: CLibrary, tmp_path: Path, double: bool) -> None:
    c = loaded(library, tmp_path, double=double)
    slow = exercise(library.reference, 12, 500, tick_s=2.0, fault_probability=0.0)
    for ticks in (golden_ticks(library.reference), exercise(library.reference, 11, 2_000), slow):
        found = largest_differences(c, library.reference, ticks, relative=double)
        assert max(found.values()) <= FILTER_DIFFERENCE[double], found


@pytest.mark.parametrize(("double", "kind"), [(True, np.float64), (False, np.float32)], ids=["double", "single"])
def test_the_square_root_is_rounded_as_the_processors_own(
    library: CLibrary, tmp_path: Path, double: bool, kind: type
) -> None:
    c = loaded(library, tmp_path, double=double)
    random = np.random.default_rng(3)
    numbers = (random.uniform(1.0, 4.0, 20_000) * 10.0 ** random.uniform(-36, 36, 20_000)).astype(kind)
    edges = [0.0, -1.0, np.inf, 1.0, 2.0, 4.0, np.finfo(kind).max, np.finfo(kind).tiny, np.nextafter(kind(1), kind(0))]
    for number in (*numbers.tolist(), *map(float, edges)):
        assert c.root(number) == (float(np.sqrt(kind(number))) if number > 0.0 else 0.0)
    assert c.root(np.nan) == 0.0


def checksum_of(model: SensingModel, folder: Path, estimator: str, shunt_ohm: float) -> str:
    """Return the checksum of model and controller that the header of a library has."""
    limits = limits_for(model, shunt_ohm)
    written = write_library(model, FuzzyPidSettings(), drive_limits(limits), limits, folder, estimator=estimator)
    lines = (written.folder / "src/mw_constants.h").read_text("utf-8").splitlines()
    return next(line for line in lines if line.startswith("#define MW_MODEL_CHECKSUM"))


def test_the_filter_is_part_of_the_checksum_and_the_shunt_is_not(model: SensingModel, tmp_path: Path) -> None:
    sums = {checksum_of(model, tmp_path, estimator, 1.0) for estimator in ("polynomial", "filter")}
    assert len(sums) == 2
    assert checksum_of(model, tmp_path, "filter", 2.0) in sums
    with pytest.raises(CallerError, match="'particle-filter' has no C form; known: filter, polynomial: export"):
        checksum_of(model, tmp_path, "particle-filter", 1.0)


def test_the_command_writes_it_and_says_that_an_uno_has_no_room(
    model: SensingModel, tmp_path: Path, musclewire: CommandLine
) -> None:
    save_model(model, tmp_path / "model.json")
    said = musclewire("export", "c", tmp_path / "model.json", "-o", tmp_path / "library").out
    assert "an Arduino Uno has no room for the filter" in said
    assert "#define MW_FILTER 1" in (tmp_path / "library/src/mw_constants.h").read_text("utf-8")


def test_a_model_without_a_slow_loop_is_refused_in_one_line(model: SensingModel, tmp_path: Path) -> None:
    limits = limits_for(model, SHUNT_OHM)
    lacking = replace(model, slow_loop=())
    with pytest.raises(CallerError, match="needs the slow loop") as caught:
        write_library(lacking, FuzzyPidSettings(), drive_limits(limits), limits, tmp_path, estimator="filter")
    assert "\n" not in str(caught.value)
