"""One session at a bench: the rig, what was found out on it, and the rows that it shows.

The main thread runs the loop; orders come from another thread. A stop is carried out by the thread that brings it and
waits for no sample; everything else is done between two samples, or refused while something else is being done.

Stops are numbered: an order to switch on that was read before the last stop is out of date, however long it has waited.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from math import nan
from pathlib import Path
from threading import RLock

from musclewire.controllers import SteeredReference
from musclewire.errors import CallerError
from musclewire.extras.live._bench.descriptions import described_protection
from musclewire.extras.live._bench.state import PublishedState
from musclewire.extras.live._ring import RowRing
from musclewire.extras.live._silence import LEASE_S
from musclewire.rigs import GuardedRig, SamplePacer, adjustable_clock_of
from musclewire.sensing import SensingModel
from musclewire.signals import RawSample, Recording

PROTECTION_COLUMN = "protection_temperature_k"
FIRST_COLUMNS = ("time_s", "run_s")
# The reason of a run's end that is no trouble.
AS_ASKED = "as asked"


class RunEndedError(Exception):
    """A run that was ended between two samples, by whoever has control or because nobody has it any more."""


@dataclass
class BenchStop:
    """Whether the bench was stopped: by whom, and how long it took from the receipt to 0 V [s]."""

    by: str = ""
    took_s: float = nan
    confirmed: bool = False


@dataclass
class SessionFindings:
    """What this session has found out."""

    loop: Recording | None = None
    model: SensingModel | None = None
    model_file: str = ""
    steered: SteeredReference | None = None


@dataclass
class BenchSession:
    """A bench in operation."""

    name: str  # of the rig, or path of its rig file, as the command line gave it
    folder: Path
    shown: PublishedState  # what pages see
    ring: RowRing
    seed: int | None = None
    # A run that heats ends when whoever has control gives no sign for so long.
    max_silence_s: float = LEASE_S
    simulated: bool = False
    rig: GuardedRig | None = None
    pacer: SamplePacer | None = None
    work: SessionFindings = field(default_factory=SessionFindings)
    stopped: BenchStop = field(default_factory=BenchStop)
    # How many stops there have been, whoever asked.
    stops: int = 0
    # Held while the phase becomes "starting", "ready" or "busy" and while a stop makes it "stopped": neither may come
    # between the other's look and what it shows. Re-entrant: a signal's stop interrupts the main thread anywhere.
    deciding: AbstractContextManager[bool] = field(default_factory=RLock)
    # Why the present run is to end after its sample; "" while it may go on.
    ending: str = ""
    # The command that waits for the loop or is being carried out; "" for none.
    queued: str = ""
    quitting: bool = False
    # Whether somebody has to be there: a run that may heat the wire.
    heating: bool = False
    # Called with the first row of what is being done: it has begun.
    on_first_row: Callable[[], None] | None = None
    _columns: dict[tuple[str, ...], int] = field(default_factory=dict)
    _since_s: float = 0.0
    _now_s: float = 0.0
    protection_seen: tuple[int, int] = (-1, -1)
    _counting: AbstractContextManager[bool] = field(default_factory=RLock)

    def stop(self, requested_by: str) -> None:
        """Switch the drive off now, whichever thread asks, and for good: a later ``switch_on`` opens the rig again."""
        received_s = time.perf_counter()
        with self._counting:
            self.stops += 1
        rig, requested_by = self.rig, self.stopped.by or requested_by  # the first who stopped stays the reason
        done = self.stopped = BenchStop(requested_by)
        if rig is not None:
            rig.close()  # before the lock: the drive waits for nobody who sends a state to the server
            done = BenchStop(requested_by, time.perf_counter() - received_s, rig.off_confirmed)
        with self.deciding:
            self.stopped = done
            why = f"stopped by {requested_by}: the drive is off; switch on again when it is safe"
            self.shown.change(phase="stopped", why=why, doing=None)

    def steer(self, target: float) -> None:
        """Move the target of the present loop. Raises CallerError if none is steered, or outside the model's range."""
        steered = self.work.steered
        if steered is None:
            raise CallerError("no loop is being steered: start 'control' with the reference 'steer'")
        steered.steer(target)

    @property
    def now_s(self) -> float:
        """Time of the newest row in this session [s], as the plots count it."""
        return self._now_s

    @property
    def sample_s(self) -> float:
        """Time between two samples [s]; 0 without a rig."""
        return 0.0 if self.rig is None else self.rig.sample_period_s

    def note_recordings(self) -> None:
        """Show which recordings are in the folder."""
        files = sorted(self.folder.glob("*.h5"), key=lambda path: path.name)
        self.shown.change(recordings=[{"name": path.name, "bytes": path.stat().st_size} for path in files])

    @property
    def above_sense_voltage(self) -> bool:
        """Whether more than the sense voltage was ordered last, or has been ordered and is not answered yet."""
        return self.rig is not None and self.rig.is_driven

    def set_clock_speed(self, factor: float) -> None:
        """Let a simulated rig run faster or slower than the clock from now on. Raises CallerError for a real one."""
        clock = None if self.rig is None else adjustable_clock_of(self.rig)
        if clock is None:
            raise CallerError("this rig's clock is its own: only a simulated rig runs faster or slower than the clock")
        clock.set_speed(factor)
        self.shown.change(clock_speed=clock.speed)

    def end_asked(self) -> bool:
        """Return whether whoever has control has ended the present run: a steered loop is then done."""
        return self.ending == AS_ASKED

    def on_sample(self, row: Mapping[str, float | None]) -> None:
        """Show a row of a run; raise RunEndedError if the run is to end, unless that is how a steered loop ends."""
        self.show_row(row)
        begun, self.on_first_row = self.on_first_row, None
        if begun is not None:
            begun()
        if self.pacer is not None:
            self.pacer.wait()
        if self.ending and not (self.end_asked() and self.work.steered is not None):
            raise RunEndedError(self.ending)

    def on_probe(self, sample: RawSample) -> None:
        """Show a sample of the doctor's."""
        self._since_s = self._since_s or sample.time_s
        self.on_sample({**sample._asdict(), "time_s": sample.time_s - self._since_s})

    def show_rest(self, sample: RawSample) -> None:
        """Show a sample at rest."""
        self.show_row({**sample._asdict(), "time_s": nan})
        if self.pacer is not None:
            self.pacer.wait()

    def show_row(self, row: Mapping[str, float | None]) -> None:
        """Write a row into the ring, with its time in this session and in its run."""
        rig = self.rig
        assert rig is not None
        protection = rig.protection
        self._now_s += rig.sample_period_s
        names = tuple(name for name, value in row.items() if value is not None and name != "time_s")
        layout = self._columns.get(names)
        if layout is None:
            layout = self.new_layout(names)
        values = (self._now_s, row["time_s"], *(row[name] for name in names), protection.temperature_k)
        self.ring.write(layout, values)  # type: ignore[arg-type]  # the names are those of columns with a value
        if (protection.state, protection.event) != self.protection_seen:
            self.protection_seen = (protection.state, protection.event)
            self.shown.change(protection=described_protection(rig))

    def new_layout(self, names: tuple[str, ...]) -> int:
        """Announce columns and return the number of their layout."""
        layout = self._columns[names] = len(self._columns) + 1
        columns = [*FIRST_COLUMNS, *names, PROTECTION_COLUMN]
        self.shown.change(layout=layout, layouts={**self.shown.state.layouts, str(layout): columns})
        return layout
