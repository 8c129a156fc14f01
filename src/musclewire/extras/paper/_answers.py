"""What the command ``reproduce`` prints with --json."""

from __future__ import annotations

from typing import Annotated

from musclewire.app import AnswerModel, AnswerRecord
from musclewire.extras.paper._reproduce.verdicts import OriginCount, ReproductionRow


class ReproduceAnswer(AnswerModel):
    """Of ``reproduce``; ``seed`` is that of a single one, null for medians."""

    rows: tuple[Annotated[ReproductionRow, AnswerRecord(ok=bool)], ...]
    failing: tuple[str, ...]
    new_failures: tuple[str, ...]
    repaired: tuple[str, ...]
    origins: dict[str, Annotated[OriginCount, AnswerRecord(without=("origin",))]]
    lacking: dict[str, str]
    seeds: tuple[int, ...]
    seed: int | None
    wall_s: float
    report: str
