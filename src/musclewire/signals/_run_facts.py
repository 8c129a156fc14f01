"""The facts of a run besides its columns: sample period, shunt, lengths, settings of the experiment.

A recording keeps these facts as metadata, and a file of another program states few of them. Code that needs a fact
reads it from :class:`RunFacts`, which raises RecordingError if it is missing or impossible: no default replaces a
measured length.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Self, overload

from musclewire.errors import RecordingError
from musclewire.signals._metadata import MetadataValue


@dataclass(frozen=True)
class NumberFact:
    """A number that a run states under the name of the attribute; reading it raises RecordingError if it is missing."""

    what: str  # its name in words
    option: str = ""  # of the command line that gives it
    may_be_zero: bool = False  # one that appears in a denominator may not

    def __set_name__(self, owner: type, name: str) -> None:
        """Take the attribute's name as the metadata key."""
        object.__setattr__(self, "key", name)

    @overload
    def __get__(self, facts: None, owner: type) -> Self: ...
    @overload
    def __get__(self, facts: RunFacts, owner: type) -> float: ...
    def __get__(self, facts: RunFacts | None, owner: type) -> Self | float:
        """Return the number, which is finite and not negative; of the class, the fact itself."""
        if facts is None:
            return self
        key: str = self.key  # type: ignore[attr-defined]  # set with the name
        value = facts.number(key, self.what, self.option)
        if value < 0.0 or (value == 0.0 and not self.may_be_zero):
            needed = "a number that is not negative" if self.may_be_zero else "a number above 0"
            raise RecordingError(f"{facts.whose} states {key} = {value:g} ({self.what}): give {needed}")
        return value


@dataclass(frozen=True)
class RunFacts:
    """The facts of one run; an attribute raises RecordingError if what the recording states of it is nothing or wrong.

    What may be absent has a method or attribute whose name says so.
    """

    stated: Mapping[str, MetadataValue]
    whose: str = "this recording"  # in messages

    sample_period_s = NumberFact("time between two samples")
    shunt_resistance_ohm = NumberFact("resistance of the shunt", "--shunt")
    wire_diameter_m = NumberFact("diameter of the wire")
    wire_length_m = NumberFact("length of the wire, all legs together")
    pretension_n = NumberFact("force of the cold wire", may_be_zero=True)
    drive_amplitude_v = NumberFact("amplitude of the slow sine on its rig")
    amplitude_v = NumberFact("amplitude of this slow sine")
    period_s = NumberFact("period of the slow sine")
    approach_s = NumberFact("time before the reference of a closed loop begins", may_be_zero=True)
    closing_s = NumberFact("time in which a grip closes")
    limit_heat_capacity_j_per_k = NumberFact("heat capacity of the wire")
    limit_heat_loss_w_per_k = NumberFact("heat loss of the wire to the air")
    limit_ambient_temperature_k = NumberFact("temperature of the air")
    time_step_s = NumberFact("fixed step of the simulation; 0 for chosen steps", may_be_zero=True)

    @property
    def leg_length_m(self) -> float:
        """Length whose shortening is the strain [m]: stated, or the wire's length over its number of legs."""
        found = self.leg_length_or_none_m
        if found is None:
            raise self.missing("leg_length_m", "length whose shortening is the strain", "--leg-length")
        return found

    @property
    def leg_length_or_none_m(self) -> float | None:
        """Length whose shortening is the strain [m]; None if neither leg nor wire has a stated length."""
        leg, whole = self.positive_or_none("leg_length_m"), self.positive_or_none("wire_length_m")
        if leg is not None:
            return leg
        return None if whole is None else whole / self.legs

    @property
    def legs(self) -> float:
        """Number of legs: 1 if none is stated, which is a straight wire; our rigs state the leg's length itself."""
        stated = self.positive_or_none("legs")
        return 1.0 if stated is None else stated

    @property
    def wires(self) -> float:
        """Number of wires that pull. Only rigs with more than one state it, so it is 1 otherwise."""
        stated = self.positive_or_none("wires")
        return 1.0 if stated is None else stated

    @property
    def load(self) -> tuple[str, ...]:
        """Names of the parts that the wire pulls; none if the recording names no parts."""
        stated = self.text_or_none("load")
        return () if stated is None else tuple(stated.split(", "))

    @property
    def cut_off(self) -> str:
        """That the recording states that its run ended early, which files of other programs do not state; else ""."""
        ended = self.text_or_none("ended")
        how = "goes on" if ended == "running" else f"ended with '{ended}'"
        return "" if ended in (None, "done") else f"this recording is cut off: its run {how}"

    def number(self, key: str, what: str, option: str = "") -> float:
        """Return a number; ``what`` is its name in words. Raises RecordingError if it is not stated."""
        value = self.number_or_none(key)
        if value is None:
            raise self.missing(key, what, option)
        return value

    def number_or_none(self, key: str) -> float | None:
        """Return a number, None if it is not stated. Raises RecordingError if it is not finite."""
        value = self.stated.get(key)
        if value is None:
            return None
        if isinstance(value, (bool, str)) or not isfinite(value):
            raise RecordingError(f"{self.whose} states {key} = {value!r}, which is no number: give one in SI units")
        return float(value)

    def positive_or_none(self, key: str) -> float | None:
        """Return a number above 0, None if it is not stated. Raises RecordingError for any other value."""
        value = self.number_or_none(key)
        if value is not None and value <= 0.0:
            raise RecordingError(f"{self.whose} states {key} = {value:g}: give a number above 0")
        return value

    def text(self, key: str, what: str) -> str:
        """Return a text; ``what`` is its name in words. Raises RecordingError if it is not stated."""
        found = self.text_or_none(key)
        if found is None:
            raise self.missing(key, what)
        return found

    def text_or_none(self, key: str) -> str | None:
        """Return a text, None if it is not stated; a number is returned as text, since a wire may be called 100."""
        value = self.stated.get(key)
        return None if value is None else str(value)

    def missing(self, key: str, what: str, option: str = "") -> RecordingError:
        """Return the error that says which fact is missing, in which recording, and how to state it."""
        ways = [f"{option} on the command line"] if option else []
        ways += [f"a line '# {key} = ...' at the top of a CSV file", f"Recording.with_metadata({key}=...)"]
        return RecordingError(f"{self.whose} does not state {key}, the {what}: give it by {', or by '.join(ways)}")
