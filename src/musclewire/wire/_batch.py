"""Many different wires, each on its load under its drive, in one call and over all cores.

Wires on plain springs with fixed steps run sixteen at a time in vector registers (``wire/_lanes.py``); wires with a
load's table, new wires and chosen steps run one by one. Either way a wire has the same bits as alone, whatever the size
of the batch, its order and the number of threads.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inline
from musclewire.errors import CallerError
from musclewire.wire._building import resting_state
from musclewire.wire._lane_views import constants_in, wire_in
from musclewire.wire._lanes import LANES, advance_lanes, give_block, take_block, workspace
from musclewire.wire._paths import DrivenPath
from musclewire.wire._row import Rows, WireConstants, WireState, as_record
from musclewire.wire._step import RunningWire
from musclewire.wire._stepping import (
    CHOSEN,
    DURATION,
    STEPS,
    VOLTAGE,
    SourceOutput,
    StepControl,
    advance_wire,
    plan_of,
    require_resolved,
)

COLUMNS = DrivenPath._fields
Places = npt.NDArray[np.int64]
# Drives, plan, columns to fill, and which column goes where.
Task = tuple[FloatArray, FloatArray, FloatArray, Places]
FOUR_MEANS = np.array([0, 1, 2, 3, -1, -1, -1, -1, -1])
# Wires and steps below this are done by one thread: handing them over would take longer.
WORTH_THREADS = 20_000


class BatchMeans(NamedTuple):
    """Means over a sample, (n_wires,) each, as :class:`~musclewire.wire._wires.WireMeans` of one wire."""

    wire_voltage_v: FloatArray
    shunt_voltage_v: FloatArray
    displacement_m: FloatArray
    force_n: FloatArray


class BatchPart(NamedTuple):
    """Wires of a batch that one thread runs, all in the same way."""

    places: Places  # in the batch, (n_wires,)
    states: Rows  # rows that change in place, (n_wires,)
    derived: Rows  # rows of derived constants, (n_wires,)
    tables: tuple[Rows, Rows]  # distribution and load, which they share
    in_lanes: int  # how many of them, the first ones, run in lanes: a multiple of LANES
    work: Rows  # room for a step of lanes, (1,)


class WireBatch:
    """Many wires that run in place, sample by sample.

    Parameters
    ----------
    constants
        The wires; each may have its own numbers, load, distribution.
    stepping
        How samples are divided into steps: fixed steps are faster, as they run in vector registers.
    states
        Where the wires begin; cold and at rest if None.
    threads
        Number of threads; all cores if None.

    Raises
    ------
    CallerError
        Without a wire, and for wires with different numbers of classes of barrier.
    """

    def __init__(
        self,
        constants: Sequence[WireConstants],
        *,
        stepping: StepControl = CHOSEN,
        states: Sequence[WireState] | None = None,
        threads: int | None = None,
    ) -> None:
        """Cool the wires under their pretension, or take their states."""
        if not constants or len({item.classes for item in constants}) != 1:
            raise CallerError(
                "a batch needs wires with the same number of classes of barrier, not "
                f"{sorted({item.classes for item in constants})}, and at least one"
            )
        if states is not None and len(states) != len(constants):
            raise CallerError(f"{len(constants)} wires and {len(states)} states: give each wire its state")
        self.stepping = stepping
        self._threads = threads or os.cpu_count() or 1
        begins = [resting_state(item) for item in constants] if states is None else states
        alike = wires_alike(constants, fixed=stepping.fixed_s > 0.0)
        # All that is alike lies together in memory; this is where each of it belongs in the batch.
        self._places = np.array([place for group in alike for place in group.places])
        self._states = np.concatenate([begins[place].row for place in self._places])
        self._begins = self._states.copy()
        derived = np.concatenate([constants[place].derived.row for place in self._places])
        self._parts = list(parts_of(alike, self._places, self._states, derived, self._threads))

    def __len__(self) -> int:
        """Return the number of wires."""
        return len(self._places)

    @property
    def states(self) -> Rows:
        """The present states, a copy: an array of records, (n_wires,), with ``states["temperature_k"]`` and so on."""
        together = np.empty_like(self._states)
        together[self._places] = self._states
        return together

    def state(self, wire: int) -> WireState:
        """Return the present state of one wire.

        Parameters
        ----------
        wire
            Its place in the batch, from 0.

        Returns
        -------
        A copy, which does not change any more.
        """
        row = self.states[[wire]]
        return WireState(row.view(np.float64), row.dtype)

    def advance(self, drive_voltage_v: FloatArray, duration_s: float) -> BatchMeans:
        """Advance all wires by one sample, and return the means over it.

        Parameters
        ----------
        drive_voltage_v
            Drive voltage of each wire [V], (n_wires,), held during the sample.
        duration_s
            Length of the sample [s].

        Returns
        -------
        Means of each wire. The arrays are the caller's own.

        Raises
        ------
        CallerError
            For another number of voltages, or a duration that fixed steps do not divide.
        """
        if np.shape(drive_voltage_v) != (len(self),):
            raise CallerError(f"{len(self)} wires need as many voltages, not {np.shape(drive_voltage_v)}")
        held = np.ascontiguousarray(drive_voltage_v, dtype=np.float64)
        kept = np.empty((4, len(self), 1))
        self._run(held.reshape(-1, 1), plan_of(self.stepping, duration_s), kept, FOUR_MEANS)
        return BatchMeans(*kept[:, :, 0])

    def rest(self, wires: npt.NDArray[np.bool_]) -> None:
        """Set some of the wires back to where they began.

        Parameters
        ----------
        wires
            True for each of these, (n_wires,).
        """
        again = wires[self._places]
        self._states[again] = self._begins[again]

    def drive(self, drive_v: FloatArray, sample_s: float, keep: Sequence[str]) -> dict[str, FloatArray]:
        """Advance all wires along a drive, and return the columns to keep.

        Parameters
        ----------
        drive_v
            Drive voltages [V], (n_samples,) for all or (n_wires, n_samples).
        sample_s
            Length of a sample [s].
        keep
            Names from ``COLUMNS``; memory is needed for these only.

        Returns
        -------
        Each column by its name, (n_wires, n_samples).

        Raises
        ------
        CallerError
            For an unknown column, a shape that does not belong to the batch, or steps that do not divide a sample.
        """
        unknown = [name for name in keep if name not in COLUMNS]
        if unknown:
            raise CallerError(f"there is no column '{unknown[0]}': choose from {', '.join(COLUMNS)}")
        held = np.ascontiguousarray(drive_v, dtype=np.float64)
        if held.ndim not in (1, 2) or (held.ndim == 2 and held.shape[0] != len(self)):
            raise CallerError(f"a drive of shape {held.shape} for {len(self)} wires: give (n_samples,) or one row each")
        held = held.reshape(-1, held.shape[-1])
        kept = np.empty((len(keep), len(self), held.shape[1]))
        places = np.array([keep.index(name) if name in keep else -1 for name in COLUMNS])
        self._run(held, plan_of(self.stepping, sample_s), kept, places)
        return dict(zip(keep, kept, strict=True))

    def require_resolved(self, sample_s: float) -> None:
        """Raise NumericsError, for the worst wire, if a step of any was unsolved or too long.

        Parameters
        ----------
        sample_s
            Length of a sample [s], for the message.

        Raises
        ------
        NumericsError
            If there is such a wire.
        """
        states = self.states
        lost = (states["unsolved_steps"] > 0.0) | ~np.isfinite(states["temperature_k"])
        worst = int(np.argmax(lost)) if lost.any() else int(np.argmax(states["step_error_k"]))
        require_resolved(self.state(worst), self.stepping, sample_s)

    def _run(self, drive_v: FloatArray, plan: FloatArray, kept: FloatArray, columns: Places) -> None:
        """Run all wires along drives, (n_wires or 1, n_samples)."""
        task = (drive_v, plan, kept, columns)
        if drive_v.shape[1] * max(int(plan[STEPS]), 1) * len(self) < WORTH_THREADS or self._threads == 1:
            for part in self._parts:
                run_part(part, task)
            return
        running = [pool(self._threads).submit(run_part, part, task) for part in self._parts]
        for one in running:
            one.result()


def drive_many(
    constants: Sequence[WireConstants],
    drive: FloatArray,
    *,
    sample_s: float,
    stepping: StepControl = CHOSEN,
    keep: Sequence[str] = ("displacement_m", "resistance_ohm"),
    threads: int | None = None,
) -> dict[str, FloatArray]:
    """Return the responses of many wires to their drives, from rest.

    Parameters
    ----------
    constants
        The wires.
    drive
        Drive voltages [V], (n_samples,) for all or (n_wires, n_samples).
    sample_s
        Length of a sample [s].
    stepping
        How a sample is divided into steps.
    keep
        Columns of :class:`~musclewire.wire._paths.DrivenPath` to return; memory is needed for these only.
    threads
        Number of threads; all cores if None.

    Returns
    -------
    Each column by its name, (n_wires, n_samples).

    Raises
    ------
    CallerError
        For an unknown column, shapes that do not belong together, or steps that do not divide a sample.
    NumericsError
        If a step of any wire was unsolved or too long.
    """
    batch = WireBatch(constants, stepping=stepping, threads=threads)
    columns = batch.drive(drive, sample_s, keep)
    batch.require_resolved(sample_s)
    return columns


@cache
def pool(threads: int) -> ThreadPoolExecutor:
    """Return the threads that run parts of batches; compiled code leaves the interpreter free."""
    return ThreadPoolExecutor(threads, thread_name_prefix="musclewire-batch")


class AlikeWires(NamedTuple):
    """Places in a batch of wires with one distribution and load, those records, and whether they can run in lanes."""

    places: list[int]
    tables: tuple[Rows, Rows]
    in_lanes: bool


def wires_alike(constants: Sequence[WireConstants], *, fixed: bool) -> list[AlikeWires]:
    """Return the wires by distribution, load's table and the way they run."""
    found: dict[tuple[int, int, bool], AlikeWires] = {}
    for place, item in enumerate(constants):
        plain = item.load_table_n.shape[1] == 2 and not item.load_table_n.any()
        in_lanes = fixed and plain and item.derived.shakedown_cycles == 0.0
        key = (item.distribution_cells.ctypes.data, 0 if plain else item.load_table_n.ctypes.data, in_lanes)
        tables = (as_record(item.distribution_cells), as_record(item.load_table_n))
        found.setdefault(key, AlikeWires([], tables, in_lanes)).places.append(place)
    return list(found.values())


def parts_of(
    alike: Sequence[AlikeWires], places: Places, states: Rows, derived: Rows, threads: int
) -> Iterator[BatchPart]:
    """Yield the wires, whose rows lie together if they are alike, in parts for so many threads."""
    begin = 0
    for group in alike:
        count, whole = len(group.places), LANES if group.in_lanes else 1
        blocks = -(-count // whole)
        ends = [begin + min(whole * (blocks * part // threads), count) for part in range(threads + 1)]
        for low, high in pairwise(ends):
            in_lanes = (high - low) // LANES * LANES if group.in_lanes else 0
            work = workspace(derived.dtype["class_weight"].shape[0])
            cut = slice(low, high)
            if high > low:
                yield BatchPart(places[cut], states[cut], derived[cut], group.tables, in_lanes, work)
        begin += count


def run_part(part: BatchPart, task: Task) -> None:
    """Run a part of a batch along its drives: whole blocks in lanes, the others one by one."""
    lanes, rest = slice(0, part.in_lanes), slice(part.in_lanes, None)
    if part.in_lanes:
        run_in_lanes(part.places[lanes], part.states[lanes], part.derived[lanes], part.tables, part.work, task)
    if part.in_lanes < len(part.places):
        run_one_by_one(part.places[rest], part.states[rest], part.derived[rest], part.tables, task)


@compiled
def run_one_by_one(places: Places, states: Rows, derived: Rows, tables: tuple[Rows, Rows], task: Task) -> None:
    """Run wires one after the other along their drives, in place."""
    drive_v, plan, kept, columns = task
    for at in range(places.shape[0]):
        running = RunningWire(states[at], derived[at], tables[0][0], tables[1][0])
        state, wire = states[at], places[at]
        row = wire if drive_v.shape[0] > 1 else 0
        for sample in range(drive_v.shape[1]):
            means = advance_wire(running, SourceOutput(drive_v[row, sample], VOLTAGE), plan)
            keep(kept, columns, (wire, sample), means, state)


@compiled
def run_in_lanes(
    places: Places, states: Rows, derived: Rows, tables: tuple[Rows, Rows], workspaces: Rows, task: Task
) -> None:
    """Run whole blocks of wires along their drives, in place, by fixed steps."""
    drive_v, plan, kept, columns = task
    work, mean = workspaces[0], 0.5 / plan[DURATION]
    for first in range(0, places.shape[0], LANES):
        wires, constants = states[first : first + LANES], derived[first : first + LANES]
        take_block(wires, constants, work)
        for sample in range(drive_v.shape[1]):
            for lane in range(LANES):
                work.drive_v[lane] = drive_v[places[first + lane] if drive_v.shape[0] > 1 else 0, sample]
            advance_lanes(wires, constants, tables[0][0], tables[1][0], work, plan)
            for lane in range(LANES):
                k, state = constants_in(work, lane), wire_in(work, lane)
                means = (
                    mean * work.voltage_sum[lane],
                    mean * work.current_sum[lane] * k.shunt_resistance_ohm,
                    mean * work.moved_sum[lane] * k.leg_length_m,
                    mean * work.stress_sum[lane] * k.section_m2,
                )
                keep(kept, columns, (places[first + lane], sample), means, state)
        give_block(wires, work)


@compiled_inline
def keep(
    kept: FloatArray,
    columns: Places,
    at: tuple[int, int],
    means: tuple[float, float, float, float],
    state: WireState,
) -> None:
    """Write a sample of a wire into the columns to keep, (n_columns, n_wires, n_samples); -1 is not kept."""
    wire, sample = at
    truth = (
        state.temperature_k,
        state.stress_pa,
        state.martensite_fraction,
        state.r_phase_fraction,
        state.resistance_ohm,
    )
    for column in range(4):
        if columns[column] >= 0:
            kept[columns[column], wire, sample] = means[column]
    for column in range(5):
        if columns[4 + column] >= 0:
            kept[columns[4 + column], wire, sample] = truth[column]
