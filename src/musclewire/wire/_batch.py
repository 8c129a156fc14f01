"""Many different wires, each on its load under its drive, in one call and over all cores.

Wires on plain springs with fixed steps run sixteen at a time in vector registers (``wire/_lanes.py``); wires with a
load's table, new wires and chosen steps run one by one. Either way a wire has the same bits as alone, whatever the size
of the batch, its order and the number of threads.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inline
from musclewire.errors import CallerError
from musclewire.wire._advance import advance_wire
from musclewire.wire._building import resting_state
from musclewire.wire._constants import WireConstants, as_record
from musclewire.wire._lane_layout import LANES, blocks_of, state_fields
from musclewire.wire._lanes import advance_block
from musclewire.wire._paths import DrivenPath
from musclewire.wire._row import Rows
from musclewire.wire._state import WireState
from musclewire.wire._step import RunningWire
from musclewire.wire._stepping import CHOSEN, SourceOutput, StepControl, plan_of, require_resolved

__all__ = ["COLUMNS", "BatchMeans", "WireBatch", "drive_many"]

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
    """Wires of a batch that one thread runs, all in the same way.

    Parameters
    ----------
    places
        Their places in the batch, (n_wires,).
    states, derived
        Their states and derived constants, (n_wires,) each.
    tables
        The distribution and the load that they share.
    blocks
        The wires in lanes, which hold the states while they run; None if they run one by one.
    scratch
        A state to work with, (1,).
    begins
        The states at the start, and the blocks that hold them.
    """

    places: Places
    states: Rows
    derived: Rows
    tables: tuple[Rows, Rows]
    blocks: Rows | None
    scratch: Rows
    begins: tuple[Rows, Rows | None]


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
        self._parts = parts_of(constants, begins, fixed=stepping.fixed_s > 0.0, threads=self._threads)
        self._count, self._layout = len(constants), begins[0].row.dtype

    def __len__(self) -> int:
        """Return the number of wires."""
        return self._count

    @property
    def states(self) -> Rows:
        """The present states, a copy: an array of records, (n_wires,), with ``states["temperature_k"]`` and so on."""
        together = np.zeros(len(self), self._layout)
        for part in self._parts:
            if part.blocks is not None:
                unload(part)
            together[part.places] = part.states
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
        copied = WireState.zeros(self._layout["front_austenite"].shape[0])
        copied.row[0] = self.states[wire]
        return copied

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
        for part in self._parts:
            begin_again(part, wires[part.places])

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
        if drive_v.shape[1] * max(int(plan[1]), 1) * len(self) < WORTH_THREADS or self._threads == 1:
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


def parts_of(
    constants: Sequence[WireConstants], states: Sequence[WireState], *, fixed: bool, threads: int
) -> list[BatchPart]:
    """Return the wires in parts with one distribution, load's table and the way they run, for so many threads."""
    members: dict[tuple[int, int, bool], list[int]] = {}
    for place, item in enumerate(constants):
        plain = item.load_table_n.shape[1] == 2 and not item.load_table_n.any()
        in_lanes = fixed and plain and item.derived.shakedown_cycles == 0.0
        load = 0 if plain else item.load_table_n.ctypes.data
        members.setdefault((item.distribution_cells.ctypes.data, load, in_lanes), []).append(place)
    parts = []
    for (_, _, in_lanes), places in members.items():
        whole = LANES if in_lanes else 1
        blocks = -(-len(places) // whole)
        ends = [whole * (blocks * part // threads) for part in range(threads + 1)]
        cut = [places[low:high] for low, high in pairwise(ends)]
        parts += [part_of(constants, states, each, in_lanes) for each in cut if each]
    return parts


def part_of(
    constants: Sequence[WireConstants], states: Sequence[WireState], places: list[int], in_lanes: bool
) -> BatchPart:
    """Return some of the wires as a part."""
    first = constants[places[0]]
    rows = np.concatenate([states[place].row for place in places])
    derived = np.concatenate([constants[place].derived.row for place in places])
    return BatchPart(
        np.array(places),
        rows,
        derived,
        (as_record(first.distribution_cells), as_record(first.load_table_n)),
        blocks_of(derived, rows) if in_lanes else None,
        np.zeros(1, rows.dtype),
        (rows.copy(), blocks_of(derived, rows) if in_lanes else None),
    )


def begin_again(part: BatchPart, wires: npt.NDArray[np.bool_]) -> None:
    """Set some wires of a part back to where they began."""
    states, blocks = part.begins
    part.states[wires] = states[wires]
    if part.blocks is None or blocks is None:
        return
    lanes = np.zeros(LANES * len(blocks), dtype=bool)
    lanes[: len(wires)] = wires
    for name in state_fields():
        np.copyto(part.blocks[f"s_{name}"], blocks[f"s_{name}"], where=lane_mask(lanes, blocks[f"s_{name}"]))


def lane_mask(lanes: npt.NDArray[np.bool_], field: FloatArray) -> npt.NDArray[np.bool_]:
    """Return a mask of lanes in the shape of a block's field, (n_blocks, LANES) or (n_blocks, classes, LANES)."""
    mask = lanes.reshape(-1, LANES)
    return np.broadcast_to(mask if field.ndim == 2 else mask[:, np.newaxis], field.shape)


def unload(part: BatchPart) -> None:
    """Copy the states of a part's blocks to its rows."""
    count = len(part.places)
    for name in state_fields():
        lanes = np.moveaxis(part.blocks[f"s_{name}"], -1, 1)  # type: ignore[index]
        part.states[name] = lanes.reshape(-1, *lanes.shape[2:])[:count]


def run_part(part: BatchPart, task: Task) -> None:
    """Run a part of a batch along its drives."""
    if part.blocks is None:
        run_one_by_one(part.places, part.states, part.derived, part.tables, task)
    else:
        run_in_lanes(part.places, part.blocks, part.derived, part.tables, part.scratch, task)
        part.states["time_s"] += task[1][0] * task[0].shape[1]


@compiled
def run_one_by_one(places: Places, states: Rows, derived: Rows, tables: tuple[Rows, Rows], task: Task) -> None:
    """Run wires one after the other along their drives, in place."""
    drive_v, plan, kept, columns = task
    for at in range(places.shape[0]):
        running = RunningWire(states[at], derived[at], tables[0][0], tables[1][0])
        state, wire = states[at], places[at]
        row = wire if drive_v.shape[0] > 1 else 0
        for sample in range(drive_v.shape[1]):
            means = advance_wire(running, SourceOutput(drive_v[row, sample], False), plan)
            truth = (
                state.temperature_k,
                state.stress_pa,
                state.martensite_fraction,
                state.r_phase_fraction,
                state.resistance_ohm,
            )
            keep(kept, columns, (wire, sample), means, truth)


@compiled
def run_in_lanes(
    places: Places, blocks: Rows, derived: Rows, tables: tuple[Rows, Rows], scratch: Rows, task: Task
) -> None:
    """Run blocks of wires along their drives, in place, by fixed steps."""
    drive_v, plan, kept, columns = task
    steps = int(plan[1])
    mean = 0.5 / plan[0]
    for block in range(blocks.shape[0]):
        b, first = blocks[block], block * LANES
        used = min(LANES, places.shape[0] - first)
        for sample in range(drive_v.shape[1]):
            for lane in range(LANES):
                wire = places[first + min(lane, used - 1)]
                b.t_drive_v[lane] = drive_v[wire if drive_v.shape[0] > 1 else 0, sample]
            advance_block(b, first, derived, (tables[0][0], tables[1][0]), scratch[0], plan[0] / plan[1], steps)
            for lane in range(used):
                means = (
                    mean * b.t_voltage_sum[lane],
                    mean * b.t_current_sum[lane] * b.k_shunt_resistance_ohm[lane],
                    mean * b.t_moved_sum[lane] * b.k_leg_length_m[lane],
                    mean * b.t_stress_sum[lane] * b.k_section_m2[lane],
                )
                truth = (
                    b.s_temperature_k[lane],
                    b.s_stress_pa[lane],
                    b.s_martensite_fraction[lane],
                    b.s_r_phase_fraction[lane],
                    b.s_resistance_ohm[lane],
                )
                keep(kept, columns, (places[first + lane], sample), means, truth)


@compiled_inline
def keep(
    kept: FloatArray,
    columns: Places,
    at: tuple[int, int],
    means: tuple[float, float, float, float],
    truth: tuple[float, float, float, float, float],
) -> None:
    """Write a sample of a wire into the columns to keep, (n_columns, n_wires, n_samples); -1 is not kept."""
    wire, sample = at
    for column in range(4):
        if columns[column] >= 0:
            kept[columns[column], wire, sample] = means[column]
    for column in range(5):
        if columns[4 + column] >= 0:
            kept[columns[4 + column], wire, sample] = truth[column]
