"""A study whose runs count themselves."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


class Counted:
    """A study of runs that count themselves, and what they have noted."""

    def __init__(self, folder: Path) -> None:
        self.notes = folder / "notes.txt"
        self.folder = folder / "study"

    def study(self, runs: int = 24, kind: str = "COUNTING", **options: Any) -> dict[str, Any]:
        return {
            "format": "musclewire-study",
            "version": 1,
            "name": "counted",
            "run": {"kind": f"counting_runs:{kind}", "notes": str(self.notes), **options},
            "parameters": {"pretension": {"values": [0.1 * (1 + number) for number in range(runs)]}},
        }

    def written(self, path: Path, **options: Any) -> Path:
        """Write the study as a file."""
        study = self.study(**options)
        lines = [f"{key} = {json.dumps(study[key])}" for key in ("format", "version", "name")]
        lines += ["[run]", *(f"{key} = {json.dumps(value)}" for key, value in study["run"].items())]
        lines += ["[parameters.pretension]", f"values = {json.dumps(study['parameters']['pretension']['values'])}"]
        path.write_text("\n".join(lines) + "\n", "utf-8")
        return path

    def evaluated(self) -> list[int]:
        """Return the numbers of the runs that were evaluated, in the order in which they were."""
        return [int(line) for line in self.notes.read_text("utf-8").split()] if self.notes.exists() else []
