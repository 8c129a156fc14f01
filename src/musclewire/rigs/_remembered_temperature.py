"""The wire's estimated temperature in a file, where it outlives the rig, its opening and its process.

A file says: at this time the wire was at most this warm. While a rig runs, that is the estimate and what the largest
drive can add until the file is written again, so that a killed process leaves no colder wire in its file than there is;
when the rig is closed, it is the estimate itself. From then on the wire cools by the heat balance of its limits.

Time is counted from the start of the machine, by a clock that nobody sets. Whoever does not know how warm the wire is
counts it as its limit and lets it rest at the sense voltage before it is heated. So a file says something for that time
only: another user, port or rig file, which has none or an older one, cannot have heated the same wire within it.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import sys
import time
import weakref
from collections.abc import Callable, Mapping
from contextlib import suppress
from math import inf, isfinite
from pathlib import Path
from threading import Event, Thread
from typing import NamedTuple, Protocol

from musclewire.controllers import ProtectionLimits, largest_power_w_per_v2
from musclewire.errors import CallerError
from musclewire.signals import remove_parts, write_text_whole

STATE_HOME = "MUSCLEWIRE_STATE_HOME"
LOOK_EVERY_S = 0.1  # [s] after which the thread looks for a new temperature again
WRITE_EVERY_S = 1.0  # [s] from one write to the next at least
# For how long after an estimate the wire may warm by more than its file says, if the process is killed: until the next
# one would have been written, and until a board or a card whose host is dead has switched off, with time to spare.
AHEAD_S = 1.5
# How long closing waits for the last write: a network drive may hang, and the drive is off by then.
LAST_WRITE_S = 2.0
MELTING_K = 1583.0  # [K] at which nitinol melts: no wire is warmer
COLDEST_K = 200.0  # [K]: a smaller number is one in degrees Celsius
MAX_FILE_BYTES = 4096
# Time constants at the sense voltage after which every wire is cold: 1.2 K are left of 180 K.
REST_TIME_CONSTANTS = 5.0
# Clocks of one machine that are read one after the other differ by less; a machine that sleeps does so for longer [s].
SLEEP_S = 0.5
BOOT_ID = Path("/proc/sys/kernel/random/boot_id")
MAX_NAME = 60


class Moment(NamedTuple):
    """A moment of one start of the machine: for how long it had been awake by then, and asleep [s]."""

    boot: str
    awake_s: float
    asleep_s: float


def this_moment(boot: str | None = None) -> Moment | None:
    """Return this moment, of a start that is known already or is looked up; None on a system that names no start."""
    try:
        boot = boot or BOOT_ID.read_text("ascii").strip()
        awake_s = time.clock_gettime(time.CLOCK_MONOTONIC)
        return Moment(boot, awake_s, time.clock_gettime(time.CLOCK_BOOTTIME) - awake_s)
    except (OSError, ValueError, AttributeError):
        return None


class WireTemperature(NamedTuple):
    """At most so warm [K] was the wire at a moment."""

    temperature_k: float
    moment: Moment


class TemperatureAtOpening(NamedTuple):
    """How warm a wire counts when its rig is opened."""

    temperature_k: float
    rest_s: float  # how long the wire rests at its sense voltage before it is heated; 0 if its temperature is known
    reason: str | None  # one line to be said, None if there is nothing to say


class KeptText(Protocol):
    """A text that outlives the process."""

    @property
    def place(self) -> str:
        """Where it is, for messages."""
        ...

    def read(self) -> str | None:
        """Return the text, None if there is none. Raises OSError or ValueError for one that cannot be read."""
        ...

    def write(self, text: str) -> None:
        """Replace the text, whole or not at all. Raises OSError or CallerError."""
        ...


class KeptFile:
    """A device's file in the user's state folder; folder and file are made with the first text."""

    def __init__(self, identity: str, folder: Path | None = None) -> None:
        """Take the file of a device's identity, in the user's folder as it is now or in another one."""
        self._name, self._folder = file_name_of(identity), folder
        if folder is None:
            with suppress(FileNotFoundError):
                self._folder = state_folder()

    def path(self) -> Path:
        """Return the file. Raises FileNotFoundError for a user without a home folder."""
        if self._folder is None:
            raise FileNotFoundError("this user has no home folder")
        return self._folder / "wire_temperatures" / self._name

    @property
    def place(self) -> str:
        """The file, for messages."""
        try:
            return str(self.path())
        except OSError:
            return self._name

    def read(self) -> str | None:
        """Return the text, None without a file; remove what a killed process left. Raises OSError or ValueError."""
        try:
            path = self.path()
            with suppress(OSError):
                remove_parts(path)
            with path.open("rb") as file:
                return file.read(MAX_FILE_BYTES).decode("utf-8")
        except (FileNotFoundError, NotADirectoryError):
            return None

    def write(self, text: str) -> None:
        """Replace the file. Raises OSError or CallerError."""
        path = self.path()
        path.parent.mkdir(parents=True, exist_ok=True)
        write_text_whole(path, text)


def state_folder(environment: Mapping[str, str] = os.environ, system: str = sys.platform) -> Path:
    """Return this user's folder of what outlives a process. Raises FileNotFoundError without a home folder."""
    if given := environment.get(STATE_HOME):
        return Path(given).absolute()
    try:
        if system == "win32":
            return Path(environment.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "musclewire"
        if system == "darwin":
            return Path.home() / "Library" / "Application Support" / "musclewire"
        base = environment.get("XDG_STATE_HOME", "")
        # The XDG specification: a path that is not absolute is ignored.
        return (Path(base) if base.startswith("/") else Path.home() / ".local" / "state") / "musclewire"
    except RuntimeError:
        raise FileNotFoundError("this user has no home folder") from None


def file_name_of(identity: str) -> str:
    """Return a device's file name, which every system takes and no other identity has."""
    readable = re.sub(r"[^A-Za-z0-9]+", "-", identity).strip("-")[:MAX_NAME]
    return f"{readable}-{hashlib.sha256(identity.encode('utf-8', 'backslashreplace')).hexdigest()[:12]}.json"


def text_of(identity: str, stored: WireTemperature) -> str:
    """Return the text that keeps a device's temperature."""
    return json.dumps({"identity": identity, "temperature_k": stored.temperature_k, **stored.moment._asdict()}) + "\n"


def parsed_temperature(text: str, identity: str) -> WireTemperature:
    """Return the temperature that a text keeps. Raises ValueError for what is none, or of another device."""
    try:
        found = json.loads(text)
        moment = Moment(str(found["boot"]), float(found["awake_s"]), float(found["asleep_s"]))
        stored = WireTemperature(float(found["temperature_k"]), moment)
    except (KeyError, TypeError, OverflowError, RecursionError):
        raise ValueError("it has no temperature and time") from None
    if found.get("identity") != identity:
        raise ValueError("it is of another device")
    if not (0.0 < stored.temperature_k < MELTING_K and isfinite(moment.awake_s) and isfinite(moment.asleep_s)):
        raise ValueError("its numbers make no sense")
    return stored


def rest_s(limits: ProtectionLimits) -> float:
    """Return how long a wire rests until it is cold, however warm it was [s]; 0 for one that no drive makes too hot."""
    if warmest_k(limits.ambient_temperature_k, limits, inf) < limit_k(limits):
        return 0.0
    return REST_TIME_CONSTANTS * limits.heat.lag_s


def why_outdated(moment: Moment, present: Moment, limits: ProtectionLimits) -> str | None:
    """Return why what was written at a moment says nothing of now, None if it does."""
    if present.boot != moment.boot or present.awake_s - moment.awake_s < -AHEAD_S:
        return "the machine has been started again since it was known"
    if abs(present.asleep_s - moment.asleep_s) > SLEEP_S:
        return "the machine has slept since it was known"
    if present.awake_s - moment.awake_s > rest_s(limits) - AHEAD_S:
        return "it was known too long ago: others may have heated it since"
    return None


def cooled_k(stored: WireTemperature, limits: ProtectionLimits, present: Moment) -> float:
    """Return how warm a wire is [K] that has had no drive since a moment; one that is still to come counts as now."""
    passed_s = max(present.awake_s - stored.moment.awake_s, 0.0)
    return limits.heat.after_k(max(stored.temperature_k, limits.ambient_temperature_k), 0.0, passed_s)


def limit_k(limits: ProtectionLimits) -> float:
    """Return the highest temperature [K] up to which the protection lets a wire be heated."""
    return min(limits.maximum_temperature_k, MELTING_K)


def warmest_k(temperature_k: float, limits: ProtectionLimits, within_s: float) -> float:
    """Return how warm the largest drive makes a wire [K] within a time, as far as the protection lets it."""
    power_w = limits.maximum_voltage_v**2 * largest_power_w_per_v2(limits)
    return max(temperature_k, min(limits.heat.after_k(temperature_k, power_w, within_s), limit_k(limits)))


class TemperatureKeeper:
    """Writes the last temperature that was noted; all of it runs in one thread, which is not that of the samples."""

    def __init__(
        self, identity: str, limits: ProtectionLimits, kept: KeptText, elapsed_s: Callable[[], float] = time.monotonic
    ) -> None:
        """Keep nothing yet; ``elapsed_s`` is a clock that nobody sets."""
        self._identity, self._limits, self._kept, self._elapsed_s = identity, limits, kept, elapsed_s
        self._written: WireTemperature | None = None
        self._written_at_s: float | None = None
        # The thread of the samples replaces it, which is one step of Python: no lock, and no half of it is read.
        self.noted: WireTemperature | None = None
        self.ended = Event()

    def write_if_due(self) -> None:
        """Write what was noted since the last time and what the drive can add, if a second has passed since then."""
        noted, now_s = self.noted, self._elapsed_s()
        if noted is None or noted is self._written:
            return
        if self._written_at_s is None or now_s - self._written_at_s >= WRITE_EVERY_S:
            self._written, self._written_at_s = noted, now_s
            warmest = warmest_k(noted.temperature_k, self._limits, AHEAD_S)
            ahead = noted.moment._replace(awake_s=noted.moment.awake_s + AHEAD_S)
            self._write(WireTemperature(warmest, ahead))

    def write_last(self) -> None:
        """Write what was noted last as it is: the drive is off."""
        if self.noted is not None:
            self._write(self.noted)

    def _write(self, stored: WireTemperature) -> None:
        try:
            self._kept.write(text_of(self._identity, stored))
        except (OSError, CallerError):
            return  # it was possible at opening, or said there; a run does not end for it

    def run(self) -> None:
        """Write until the end is asked for."""
        while not self.ended.wait(LOOK_EVERY_S):
            self.write_if_due()
        self.write_last()


def opened(
    identity: str, limits: ProtectionLimits, kept: KeptText, present: Moment | None, stated_k: float | None = None
) -> TemperatureAtOpening:
    """Return how warm a wire counts now, from the text that is kept, and keep that, to see whether it can be done."""
    reasons, why = [], None
    temperature_k = warmest_k(limits.ambient_temperature_k, limits, inf)
    try:
        text = kept.read()
        stored = None if text is None else parsed_temperature(text, identity)
    except (OSError, ValueError) as problem:
        why = f"{kept.place} cannot be read: {in_one_line(problem)}"
    else:
        if present is None:
            why = "this system does not say when it was started"
        elif stored is None:
            why = "it is opened for the first time"
        elif (why := why_outdated(stored.moment, present, limits)) is None:
            temperature_k = cooled_k(stored, limits, present)
    resting_s = 0.0
    if why is not None and rest_s(limits) > 0.0:
        temperature_k = max(limits.ambient_temperature_k, limit_k(limits) if stated_k is None else stated_k)
        resting_s = rest_s(limits) if stated_k is None else 0.0
        rests = f"it rests at its sense voltage for {resting_s:.1f} s before it is heated, unless you state it"
        counts = f"it counts as {temperature_k - 273.15:.0f} C, as stated"
        reasons.append(f"how warm the wire is is not known ({why}): {rests if resting_s else counts}")
    try:
        if present is not None:
            kept.write(text_of(identity, WireTemperature(temperature_k, present)))
    except (OSError, CallerError) as problem:
        reasons.append(
            f"{kept.place}: how warm the wire is cannot be kept ({in_one_line(problem)}): let it cool before you open "
            f"it again, or set {STATE_HOME} to a folder that you may write to"
        )
    return TemperatureAtOpening(temperature_k, resting_s, "; ".join(reasons) or None)


def in_one_line(problem: Exception) -> str:
    """Return an error's text without line breaks."""
    return " ".join(str(problem).split()) or type(problem).__name__


class RememberedTemperature:
    """How warm a wire counts at opening, kept from then on; without an identity it is as warm as stated."""

    def __init__(
        self,
        identity: str | None,
        limits: ProtectionLimits,
        *,
        stated_k: float | None = None,
        kept: KeptText | None = None,
        clock: Callable[[], Moment | None] | None = None,
    ) -> None:
        """Read what is kept, and let a thread keep what is noted; a folder that cannot be used is no error."""
        self._keeper: TemperatureKeeper | None = None
        begins_k = max(limits.ambient_temperature_k, stated_k or 0.0)
        self.at_opening = TemperatureAtOpening(begins_k, rest_s=0.0, reason=None)
        if identity is None:
            return
        kept, moment = kept or KeptFile(identity), (clock or this_moment)()
        self.at_opening = opened(identity, limits, kept, moment, stated_k)
        if moment is None:
            return
        boot = moment.boot
        self._now = clock or (lambda: this_moment(boot))
        self._keeper = TemperatureKeeper(identity, limits, kept)
        self._thread = Thread(target=self._keeper.run, name="wire temperature", daemon=True)
        self._thread.start()
        # The thread does not hold this object: one that nobody closes ends it nevertheless.
        weakref.finalize(self, self._keeper.ended.set)

    def note(self, temperature_k: float) -> None:
        """Note the estimate [K] of a sample: two numbers are stored, nothing waits, nothing raises."""
        if self._keeper is not None and (moment := self._now()) is not None:
            self._keeper.noted = WireTemperature(temperature_k, moment)

    def close(self) -> None:
        """Write what was noted last, and end; for a rig whose drive is off. May be called twice; never raises."""
        if self._keeper is not None:
            self._keeper.ended.set()
            self._thread.join(LAST_WRITE_S)
