"""The filter's numbers: how they are chosen, what each of them moves, and the table of what comes of them.

Wires of the population of ``musclewire robustness`` follow random steps by their displacement sensor, under its
conditions; in addition with a tenth of the samples missing, and read from 20 s after the beginning of the reference on.
The runs are recorded once and kept in a folder, so that a table takes minutes. A wire that its rig's protection lets no
slow loop be recorded of is left out, and said.

    python studies/filter_numbers.py record --wires 741-770     record the runs, and the crossings of B
    python studies/filter_numbers.py table --wires 741-770      filter and polynomial
    python studies/filter_numbers.py crossings --wires 741-770  200 drawn crossings of B, in 0.3 to 30 s
    python studies/filter_numbers.py plants                     random steps on rigs that are not drawn wires
    python studies/filter_numbers.py labs                       loops as laboratories record them, from 14 s to an hour
    python studies/filter_numbers.py choose --wires 1-12,131-136
    python studies/filter_numbers.py moves --wires 1-12,131-136 each number halved and doubled

Percent of the full stroke, pooled over wires: root mean square error, largest error, how many samples the 95 % interval
holds, its median half-width, and the mean error. On one recording alone the share of valid samples stands in the place
of the worst wire. ``choose`` goes down the mean of the logarithm of all rows' error and,
a tenth as much, of their largest one, by steps of 1.5, 1.25 and 1.12 in each number but the interval's. It and
``moves`` have rows of closed loops besides: a wire that follows its own estimate rests where the filter lets it rest.
They are recorded once, with the numbers of that day.
"""

from __future__ import annotations

import argparse
import itertools
import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np
from musclewire_robustness.characterizing import UsersKnowledge, slow_loop
from musclewire_robustness.command import chosen_seeds
from musclewire_robustness.estimating import samples_of
from musclewire_robustness.plant import AS_CHARACTERIZED, open_plant
from musclewire_robustness.population import drawn_wire
from musclewire_robustness.recorded_run import RecordedRun
from musclewire_robustness.recording_runs import StrainServo, record_run
from musclewire_robustness.scoring import DEVIATIONS, judged_from_s, usable
from musclewire_robustness.settings import Condition, settings
from musclewire_robustness.task_plants import PLANTS
from musclewire_robustness.task_runs import measured_by
from musclewire_robustness.task_table import SEEDS
from musclewire_robustness.tasks import TASKS
from numpy.typing import NDArray

import musclewire as mw
from musclewire.errors import MusclewireError
from musclewire.experiment import control
from musclewire.judge import KnownB, RunCorrection
from musclewire.sensing import (
    ESTIMATORS,
    FILTER,
    FILTER_CONSTANTS,
    EstimatorSetup,
    FilterNumbers,
    SensingModel,
)
from musclewire.signals import CompiledTick, QuantityEstimate, Reason, reference_quantity

FOLDER = Path("filter_runs")
REFERENCE = "random steps"
CONDITIONS = (
    *("none", "draughts 0.25", "h x0.5", "h x3", "ambient +15 K", "ambient -15 K", "noise x10"),
    *("R +1 %, zeroed again", "R -1 %, zeroed again", "load +50 %, zeroed again", "load -50 %, zeroed again"),
    *("k x2", "T -5 K"),
)
MISSING, WARM = "10 % missing", "begun warm"
ROWS = (*CONDITIONS, MISSING, WARM)
MISSING_PART, WARM_S = 0.1, 20.0
NAMES = ("filter", "polynomial")
# What the interval is made of is not chosen by the error.
NOT_BY_ERROR = ("range_std",)
STEPS, LARGEST_WEIGHT = (1.5, 1.25, 1.12), 0.1
CROSSINGS, STREAM, AFTER_S = 200, 60, 10.0
# Of a rig that is no drawn wire the first seconds, from cold, are not judged. A loop of a minute is stretched so.
SETTLED_S, STRETCHES = 4.0, (14.0 / 60.0, 1.0, 10.0, 60.0)
LOOP_TASKS, LOOP_SEED = ("staircase", "small steps", "random steps", "hold 10 min"), 11
Array = NDArray[np.float64]
# What an estimator says over the rows that it is given: value, deviation, validity, and columns of its own.
Estimate = Callable[["Case"], tuple[Array, Array, NDArray[np.bool_]]]


class Case(NamedTuple):
    """A run as an estimator gets it and as it is judged, each (n_samples,), and what its user knows."""

    seed: int
    given: Array
    least_std: Array
    refused: NDArray[np.bool_]
    strain: Array
    judged: NDArray[np.bool_]
    model: SensingModel
    stroke: float
    facts: Mapping[str, float]
    drawn: Mapping[str, float]

    def only(self, kept: NDArray[np.bool_]) -> Case:
        """Return the case with some of its samples."""
        parts = {name: getattr(self, name)[kept] for name in ("given", "least_std", "refused", "strain", "judged")}
        return self._replace(**parts)


class Row(NamedTuple):
    """One row of the table [% of stroke]; ``holds`` is a part."""

    rms: float
    worst_wire: float
    largest: float
    holds: float
    half_width: float
    bias: float


def known(seed: int, folder: Path) -> UsersKnowledge:
    """Return what a wire's user knows, recorded now or before."""
    path = folder / str(seed)
    if not (path / "loop.h5").exists():
        path.mkdir(parents=True, exist_ok=True)
        loop = slow_loop(drawn_wire(seed))
        mw.fit(loop).save(path / "model.json")
        loop.save(path / "loop.h5")
    loop = mw.read_recording(path / "loop.h5")
    gaps, amplitude_v = mw.loop_gaps(loop), loop.facts.number_or_none("amplitude_v")
    assert amplitude_v is not None
    model = mw.load_model(path / "model.json")
    return UsersKnowledge(model, None, gaps.segments.strain_max, 100.0 * gaps.strain_gap, amplitude_v, loop)


def wires_of(seeds: Sequence[int], folder: Path) -> Iterator[tuple[int, UsersKnowledge]]:
    """Yield each wire that has a slow loop, and say which have none."""
    for seed in seeds:
        try:
            yield seed, known(seed, folder)
        except MusclewireError as error:
            print(f"wire {seed} is left out: {' '.join(str(error).split())}", flush=True)


def run_path(seed: int, condition: str, folder: Path) -> Path:
    """Return where a run is kept."""
    return folder / str(seed) / (condition.replace(" ", "_").replace(",", "").replace("%", "pct") + ".npz")


def recorded(seed: int, condition: Condition, knowledge: UsersKnowledge, folder: Path) -> RecordedRun:
    """Return a run, recorded now or before."""
    path = run_path(seed, condition.name, folder)
    if not path.exists():
        record_run(drawn_wire(seed), condition, REFERENCE, knowledge)[0].save(path)
    return RecordedRun.load(path)


def case_of(seed: int, row: str, knowledge: UsersKnowledge, folder: Path) -> Case:
    """Return the run of a row of the table, scaled by B as a loop does it where strain counts from today's zero."""
    (condition,) = settings().conditions((row if row in CONDITIONS else "none",))
    run = recorded(seed, condition, knowledge, folder)
    known_b = KnownB.of_model(knowledge.model, run.facts["sense_voltage_v"])
    correction = RunCorrection(knowledge.model, run.facts["shunt_resistance_ohm"], known_b)
    said, given, judged = QuantityEstimate(0.0, 0.0, True, Reason.OK), [], []
    for sample in samples_of(run):
        # All values of the filter go by one model: the reading is scaled in place of its resistances.
        factor = correction.correction.scale if condition.zeroed else 1.0
        given.append(sample._replace(wire_voltage_v=factor * sample.wire_voltage_v)[:4])
        judged.append(correction.shown(said) if condition.zeroed else said)
        correction.watch(sample, said, sample.time_s)
    counts = usable(run.strain, knowledge, settings().run) & (run.time_s >= judged_from_s(condition, settings().run))
    case = Case(
        seed,
        np.array(given, dtype=np.float64),
        np.array([one.std for one in judged]),
        np.array([not one.valid for one in judged]),
        run.strain,
        counts,
        knowledge.model,
        knowledge.stroke,
        run.facts,
        {},
    )
    if row == MISSING:
        return case.only(np.random.default_rng([STREAM, seed]).random(run.time_s.size) > MISSING_PART)
    return case.only(run.time_s >= WARM_S) if row == WARM else case


@numba.njit
def over_rows(function: Any, constants: Array, state: Array, given: Array, answers: Array) -> None:
    """Run a tick over all rows."""
    for row in range(given.shape[0]):
        function(constants, state, given[row], answers[row])


def said(tick: CompiledTick, constants: Array, case: Case) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return value, deviation and validity of a tick over a case."""
    answers = np.zeros((len(case.given), 16))
    over_rows(tick.function, constants, tick.state.copy(), case.given, answers)
    return answers[:, 0], answers[:, 1], answers[:, 2] > 0.0


# By estimator and by the identity of the model, which its cases keep.
TICKS: dict[tuple[str, int], CompiledTick] = {}


def tick_of(name: str, case: Case) -> CompiledTick:
    """Return the tick of an estimator for the wire of a case, made once."""
    if (name, id(case.model)) not in TICKS:
        facts = case.facts
        setup = EstimatorSetup(case.model, facts["shunt_resistance_ohm"], facts["sample_period_s"])
        made: Any = ESTIMATORS.find(name)(setup)
        TICKS[name, id(case.model)] = made.compiled_tick()
    return TICKS[name, id(case.model)]


def named(name: str) -> Estimate:
    """Return an estimator by its name."""
    return lambda case: said(tick_of(name, case), tick_of(name, case).constants, case)


def with_numbers(numbers: FilterNumbers) -> Estimate:
    """Return the filter with other numbers of its method."""
    first = FILTER_CONSTANTS.index(FilterNumbers._fields[0])

    def estimate(case: Case) -> tuple[Array, Array, NDArray[np.bool_]]:
        tick = tick_of("filter", case)
        constants = tick.constants.copy()
        constants[first : first + len(numbers)] = numbers
        return said(tick, constants, case)

    return estimate


def judged_row(estimate: Estimate, cases: Sequence[Case]) -> Row:
    """Return the row of an estimator over the cases of all wires."""
    errors, held, widths = [], [], []
    for case in cases:
        value, std, valid = estimate(case)
        error = (value - case.strain)[case.judged] / case.stroke
        counts = (valid & ~case.refused)[case.judged]
        half = DEVIATIONS * np.maximum(std, case.least_std)[case.judged] / case.stroke
        errors.append(error)
        held.append((np.abs(error) <= half)[counts])
        widths.append(float(np.median(half[counts])) if counts.any() else math.nan)
    every = np.concatenate(errors)
    return Row(
        100.0 * float(np.sqrt(np.mean(every**2))),
        100.0 * max(float(np.sqrt(np.mean(one**2))) for one in errors),
        100.0 * float(np.abs(every).max()),
        float(np.concatenate(held).mean()),
        100.0 * float(np.nanmedian(widths)),
        100.0 * float(every.mean()),
    )


def cases_by_row(seeds: Sequence[int], folder: Path) -> dict[str, list[Case]]:
    """Return the cases of every row, each with all wires that have judged samples in it."""
    found: dict[str, list[Case]] = {row: [] for row in ROWS}
    for seed, knowledge in wires_of(seeds, folder):
        for row in ROWS:
            case = case_of(seed, row, knowledge, folder)
            if case.judged.any():
                found[row].append(case)
    return found


def print_table(seeds: Sequence[int], folder: Path) -> None:
    """Print the table of all estimators."""
    cases = cases_by_row(seeds, folder)
    print(f"a tick takes {', '.join(f'{name} {1e6 * tick_s(name, cases[WARM][0]):.2f} us' for name in NAMES)}")
    print("rms (largest; worst wire), interval holds at half-width (over rms), bias")
    for row, over in cases.items():
        for name in NAMES:
            print(f"{row:26s} {len(over):2d} wires {row_text(name, judged_row(named(name), over))}", flush=True)


def tick_s(name: str, case: Case) -> float:
    """Return the time of a tick [s], the least of some runs over a case."""
    times_s = []
    for _ in range(10):
        began_s = time.perf_counter()
        named(name)(case)
        times_s.append((time.perf_counter() - began_s) / len(case.given))
    return min(times_s)


def row_text(name: str, one: Row) -> str:
    """Return a row of the table as text."""
    return (
        f"{name:10s} {one.rms:.2f} ({one.largest:.1f}; {one.worst_wire:.2f}), {100.0 * one.holds:.0f} % at "
        f"{one.half_width:.2f} ({one.half_width / one.rms:.1f}), {one.bias:+.2f}"
    )


def cost(numbers: FilterNumbers, cases: Mapping[str, list[Case]]) -> float:
    """Return what is to be small: the mean over rows of the logarithm of the error, and a part of the largest."""
    rows = [judged_row(with_numbers(numbers), over) for over in cases.values()]
    return sum(math.log(row.rms) + LARGEST_WEIGHT * math.log(row.largest) for row in rows) / len(rows)


def choose(seeds: Sequence[int], folder: Path) -> None:
    """Go down from the present numbers, one number after the other, and print what comes of it."""
    cases, numbers = cases_to_choose_by(seeds, folder), FILTER
    least = cost(numbers, cases)
    print(f"{least:.4f} with {numbers}", flush=True)
    for step in STEPS:
        for name in (name for name in FilterNumbers._fields if name not in NOT_BY_ERROR):
            for factor in (step, 1.0 / step):
                while True:
                    tried = numbers._replace(**{name: factor * getattr(numbers, name)})
                    found = cost(tried, cases)
                    if found >= least - 1e-4:
                        break
                    numbers, least = tried, found
                    print(f"{least:.4f} with {name} {getattr(numbers, name):.4g}", flush=True)
    print(numbers)


def print_moves(seeds: Sequence[int], folder: Path) -> None:
    """Print by how much each number, halved and doubled, moves the row that it moves most."""
    cases = cases_to_choose_by(seeds, folder)

    def figures(numbers: FilterNumbers) -> dict[tuple[str, str], float]:
        rows = {row: judged_row(with_numbers(numbers), over) for row, over in cases.items()}
        return {(row, kind): getattr(one, kind) for row, one in rows.items() for kind in ("rms", "half_width")}

    before = figures(FILTER)
    for name in FilterNumbers._fields:
        for factor in (0.5, 2.0):
            after = figures(FILTER._replace(**{name: factor * getattr(FILTER, name)}))
            moves = {key: 100.0 * (after[key] / before[key] - 1.0) for key in before}
            (row, kind) = max(moves, key=lambda key: abs(moves[key]))
            print(f"{name:16s} x{factor:g}: {moves[row, kind]:+6.1f} % {kind} of {row}", flush=True)


def crossing(number: int, seed: int, knowledge: UsersKnowledge, folder: Path) -> Case:
    """Return a crossing of B from cold, drawn by its number: rise of the power, noise, air; recorded now or before."""
    path = folder / "crossings" / f"{number}-{seed}.npz"
    random = np.random.default_rng([STREAM, number])
    rise_s, noise = (
        float(np.exp(random.uniform(*np.log([0.3, 30.0])))),
        float(np.exp(random.uniform(0.0, np.log(10.0)))),
    )
    air_k, loss = float(random.uniform(-15.0, 15.0)), float(np.exp(random.uniform(-0.7, 0.7)))
    top, wait_s = float(random.uniform(0.5, 0.95)), float(random.uniform(2.0, 4.0))
    if not path.exists():
        changed = {"name": "crossing", "noise_factor": noise, "ambient_k": air_k, "convection_factor": loss}
        plant = open_plant(drawn_wire(seed), AS_CHARACTERIZED.model_copy(update=changed), run=40)
        with plant.rig as rig:
            plant.disturbance.change_at(0.0)
            low, high = rig.sense_voltage_v**2, top * knowledge.amplitude_v**2
            rows: list[tuple[float, ...]] = []
            for tick in range(round((wait_s + rise_s + 12.0) / rig.sample_period_s)):
                part = min(max((tick * rig.sample_period_s - wait_s) / rise_s, 0.0), 1.0)
                plant.before_sample()
                sample = rig.exchange(math.sqrt(low + part * max(high - low, 0.0)))
                rows.append((*sample[:4], (sample.displacement_m or 0.0) / rig.leg_length_m))
            path.parent.mkdir(parents=True, exist_ok=True)
            np.savez(path, rows=np.array(rows), facts=[rig.shunt_resistance_ohm, rig.sample_period_s])
    with np.load(path) as kept:
        rows_kept, (shunt_ohm, period_s) = kept["rows"], kept["facts"].tolist()
    strain, zeros = rows_kept[:, 4], np.zeros(len(rows_kept))
    inside = usable(strain, knowledge, settings().run)
    first = int(np.argmax(inside))
    within = inside & (np.arange(strain.size) < first + round(AFTER_S / period_s))
    facts = {"shunt_resistance_ohm": shunt_ohm, "sample_period_s": period_s}
    drawn = {"rise_s": rise_s, "noise": noise, "air_k": air_k, "loss": loss}
    return Case(
        seed,
        rows_kept[:, :4].copy(),
        zeros,
        zeros > 0.0,
        strain,
        within,
        knowledge.model,
        knowledge.stroke,
        facts,
        drawn,
    )


def crossings(seeds: Sequence[int], folder: Path) -> list[Case]:
    """Return the drawn crossings, less those that the protection ended or that stay below the usable range."""
    wires, found = list(wires_of(seeds, folder)), []
    for number in range(CROSSINGS):
        seed, knowledge = wires[number % len(wires)]
        try:
            case = crossing(number, seed, knowledge, folder)
        except MusclewireError as error:
            print(f"crossing {number} is left out: {' '.join(str(error).split())[:100]}", flush=True)
            continue
        if case.judged.any():
            found.append(case)
    return found


def print_crossings(seeds: Sequence[int], folder: Path) -> None:
    """Print the largest error after B, how many wires are lost, and when they are valid."""
    cases = crossings(seeds, folder)
    for name in NAMES:
        largest, lost, late_s = [], 0, []
        for case in cases:
            value, _, valid = named(name)(case)
            error = 100.0 * np.abs(value - case.strain) / case.stroke
            largest.append(float(np.max(np.where(case.judged & valid, error, 0.0))))
            judged = np.flatnonzero(case.judged)
            sensed = np.flatnonzero(case.judged & valid)
            late = sensed[0] - judged[0] if sensed.size else judged.size
            late_s.append(case.facts["sample_period_s"] * float(late))
            lost += not valid[judged[-1]] or error[judged[-20:]].mean() > 6.0
        median, most, all_but_one = np.percentile(largest, [50, 95, 99])
        print(
            f"{name:10s} {len(cases)} crossings: largest error of valid samples within {AFTER_S:g} s {median:.1f} in "
            f"the median, {most:.1f} in 95 of 100, {all_but_one:.1f} in 99, {max(largest):.1f} at most; lost {lost}; "
            f"valid after {np.percentile(late_s, 95):.2f} s in 95 of 100",
            flush=True,
        )


def cases_to_choose_by(seeds: Sequence[int], folder: Path) -> dict[str, list[Case]]:
    """Return the cases of every row of the table, then those of closed loops, a row for each task and kind of plant."""
    found = cases_by_row(seeds, folder)
    for task, name in itertools.product(LOOP_TASKS, (name for name in PLANTS if name != "gripper")):
        of_plant = seeds if name == "wires" else (LOOP_SEED,)
        found[f"{name}, {task}"] = [loop_case(name, task, seed, folder) for seed in of_plant]
    return found


def loop_case(name: str, task: str, seed: int, folder: Path) -> Case:
    """Return a task of a rig in a closed loop by the filter, recorded now or before."""
    plant, path = PLANTS[name], folder / "loops" / f"{name}-{task}-{seed}.npz".replace(" ", "_")
    model = plant.model_in(folder / "plants" / f"{name}-{seed}.json", seed)
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        with plant.opened(seed, of_task=True) as rig:
            loop = {"estimator": "filter", "controller": "inverse-model"}
            run = control(rig, model, TASKS[task].reference(model, seed), **loop)
            columns = ("time_s", "drive_voltage_v", "wire_voltage_v", "shunt_voltage_v")
            rows = np.column_stack([*(run[one] for one in columns), reference_quantity(run, model.quantity)])
            np.savez(path, rows=rows, facts=[rig.shunt_resistance_ohm, rig.sample_period_s])
    return kept_case(path, model, seed)


def plant_case(name: str, seed: int, folder: Path) -> Case:
    """Return random steps of a rig by its displacement sensor, recorded now or before."""
    plant, path = PLANTS[name], folder / "plants" / f"{name}-{seed}.npz"
    model = plant.model_in(folder / "plants" / f"{name}-{seed}.json", seed)
    if not path.exists():
        reference = TASKS[REFERENCE].reference(model, seed)
        with plant.opened(seed, of_task=True) as rig:
            servo, drive_v, rows = StrainServo(rig, model.quantity_max, rig.drive_amplitude_v), rig.sense_voltage_v, []
            for index in range(round(reference.duration_s / rig.sample_period_s)):
                sample = rig.exchange(drive_v)
                measured = measured_by(sample, rig, model.quantity)
                drive_v = servo.drive_v(reference.target_at(index * rig.sample_period_s), measured)
                rows.append((*sample[:4], measured))
            np.savez(path, rows=np.array(rows), facts=[rig.shunt_resistance_ohm, rig.sample_period_s])
    return kept_case(path, model, seed)


def kept_case(path: Path, model: SensingModel, seed: int) -> Case:
    """Return the run of a rig that a file keeps, judged where its model senses, from some seconds on."""
    with np.load(path) as kept:
        rows_kept, (shunt_ohm, period_s) = kept["rows"], kept["facts"].tolist()
    measured, zeros = rows_kept[:, 4], np.zeros(len(rows_kept))
    inside = (measured >= model.quantity_min) & (measured <= model.quantity_max) & (rows_kept[:, 0] > SETTLED_S)
    facts = {"shunt_resistance_ohm": shunt_ohm, "sample_period_s": period_s}
    given = rows_kept[:, :4].copy()
    return Case(seed, given, zeros, zeros > 0.0, measured, inside, model, model.quantity_max, facts, {})


def print_plants(_: Sequence[int], folder: Path) -> None:
    """Print the table of all estimators on rigs that are not drawn wires."""
    for plant in (name for name in PLANTS if name != "wires"):
        cases = [plant_case(plant, seed, folder) for seed in SEEDS]
        for name in NAMES:
            print(f"{plant:18s} {len(cases)} seeds {row_text(name, judged_row(named(name), cases))}", flush=True)


def print_labs(_: Sequence[int], __: Path) -> None:
    """Print estimators on loops as laboratories record them: stretched in time, and with their defects."""
    sys.path.insert(0, str(Path(__file__).parents[1]))
    from tests.labs.loops import DEFECTS, LOOPS, SHUNT_OHM, loop

    shown = [(stretch, None) for stretch in STRETCHES] + [(1.0, defect) for defect in DEFECTS]
    for name, (stretch, defect) in itertools.product(LOOPS, shown):
        found = loop(name) if defect is None else defect(loop(name), np.random.default_rng(STREAM))
        columns = {one: found[one] for one in ("wire_voltage_v", "shunt_voltage_v", "displacement_m")}
        recording = mw.Recording({"time_s": stretch * found["time_s"], **columns}, {"shunt_resistance_ohm": SHUNT_OHM})
        title = f"{name:21s} {defect.__name__ if defect else f'in {recording.duration_s:.0f} s':21s}"
        try:
            model = mw.fit(recording, quantity="displacement")
        except MusclewireError as error:
            print(f"{title} has no model: {' '.join(str(error).split())[:60]}")
            continue
        for estimator in NAMES:
            print(f"{title} {row_text(estimator, loop_row(model, recording, estimator))}", flush=True)


def loop_row(model: SensingModel, recording: mw.Recording, name: str) -> Row:
    """Return the row of an estimator on the loop that its model was fitted to."""
    said, moved_m = mw.estimate(model, recording, estimator=name).recording, recording["displacement_m"]
    counts = moved_m >= model.quantity_min
    valid = counts & (said["valid"] > 0.0)
    error, half = (
        100.0 * one / (model.measured_stroke or math.nan)
        for one in (said["estimated_displacement_m"] - moved_m, DEVIATIONS * said["estimate_std"])
    )
    rms, held = float(np.sqrt(np.mean(error[valid] ** 2))), float(np.mean(np.abs(error)[valid] <= half[valid]))
    wrong = float(np.abs(error[valid]).max())
    return Row(
        rms, float(np.mean(valid[counts])), wrong, held, float(np.median(half[valid])), float(error[valid].mean())
    )


def record(seeds: Sequence[int], folder: Path) -> None:
    """Record everything of some wires."""
    for seed, knowledge in wires_of(seeds, folder):
        for condition in settings().conditions(CONDITIONS):
            recorded(seed, condition, knowledge, folder)
        print(f"wire {seed}", flush=True)
    crossings(seeds, folder)


COMMANDS = {
    "record": record,
    "table": print_table,
    "crossings": print_crossings,
    "plants": print_plants,
    "labs": print_labs,
    "choose": choose,
    "moves": print_moves,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=COMMANDS)
    parser.add_argument("--wires", default="1-12,131-136", help="seeds: choose on 1-40, 131-160, report on 741-770")
    parser.add_argument("--folder", type=Path, default=FOLDER, help="where the runs are kept")
    asked = parser.parse_args()
    COMMANDS[asked.what](chosen_seeds(asked.wires) or (), asked.folder)


if __name__ == "__main__":
    main()
