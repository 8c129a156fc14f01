"""The fault matrix as data: matrix.toml, checked."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

__all__ = ["FaultRow", "fault_matrix"]

MATRIX = Path(__file__).with_name("matrix.toml")


class FaultRow(BaseModel):
    """One fault: what fails, how it is injected, and how it must end."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)

    name: str
    where: Literal["wire", "circuit", "converter", "line", "board", "host"]
    run: Literal["lockstep", "clock", "command", "simulated"]
    inject: str
    arguments: dict[str, Any] = Field(default={}, alias="with")
    drive_v: float = 1.8
    limits: dict[str, float] = {}
    event: tuple[str, ...]
    within_s: float = Field(gt=0.0, le=0.5)
    acts: Literal["host", "board", "both"]
    exit: Literal["3", "130", "143", "-"] = "3"
    judged_by: Literal["output_voltage_v", "code"] = "output_voltage_v"

    @property
    def survived(self) -> bool:
        """Whether the run goes on."""
        return not self.event


def fault_matrix() -> list[FaultRow]:
    """Return all rows."""
    return [FaultRow.model_validate(row) for row in tomllib.loads(MATRIX.read_text(encoding="utf-8"))["fault"]]
