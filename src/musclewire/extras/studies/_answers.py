"""What the command ``sweep`` prints with --json."""

from __future__ import annotations

from pydantic import Field

from musclewire.app import AnswerModel

Words = tuple[str, ...]


class QuantitySpread(AnswerModel):
    """Least, median and largest value of a quantity; null if every run failed."""

    least: float | None
    median: float | None
    largest: float | None


class OverheatedRun(AnswerModel):
    """A run whose wire went beyond the highest temperature that its protection allows."""

    run: int
    temperature_max_k: float
    limit_k: float


class SweepAnswer(AnswerModel):
    """Of ``sweep``."""

    runs: int
    evaluated: int
    failed: int
    fingerprint: str
    quantities: dict[str, QuantitySpread]
    overheated: tuple[OverheatedRun, ...]
    wall_s: float
    files: Words


class SweepKinds(AnswerModel):
    """Of ``sweep --list``: the keys of each kind of run, and what may vary with its unit."""

    kinds: dict[str, Words]
    parameters: dict[str, str]


class VariedRange(AnswerModel):
    """The ends of what varies: numbers in the unit, or names."""

    unit: str
    least: float | str = Field(serialization_alias="from")
    most: float | str = Field(serialization_alias="to")


class PlannedSweep(AnswerModel):
    """Of ``sweep --plan``."""

    runs: int
    kind: str
    keep: Words
    parameters: dict[str, VariedRange]


SweepAnswers = SweepAnswer | PlannedSweep | SweepKinds
