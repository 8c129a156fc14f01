"""Recordings of the benchmark in a folder, by content: the same wire, settings and sources are not run twice.

What estimators and loops make of them is kept by the study, for one selection; the recordings serve every selection.
"""

from __future__ import annotations

import hashlib
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

from musclewire import SensingModel, load_model
from musclewire.identify import users_wire
from musclewire.wire import WireConstants
from musclewire_robustness.characterizing import UsersKnowledge, characterized
from musclewire_robustness.population import PopulationWire, drawn_wire
from musclewire_robustness.recorded_run import RecordedRun
from musclewire_robustness.recording_runs import record_run
from musclewire_robustness.settings import Condition, settings

# Where runs are kept by default.
FOLDER = Path("robustness")
# Rooms of musclewire whose sources and data decide what a wire does, what its user knows of it and what estimators say.
ROOMS = (
    *("physics", "wire", "parameters", "sensing", "controllers", "rigs", "identify", "experiment"),
    *("extras/calibration", "extras/grip", "extras/studies"),
)


class BenchmarkRun(NamedTuple):
    """A recorded run with all that its user knows.

    Parameters
    ----------
    run
        The recorded run.
    knowledge
        Model (after any home move), wire file and stroke, as the user has them.
    wire
        The constants of the user's wire file on his load.
    condition
        The condition.
    """

    run: RecordedRun
    knowledge: UsersKnowledge
    wire: WireConstants | None
    condition: Condition


class ResultStore:
    """A folder of characterized wires and recorded runs."""

    def __init__(self, folder: Path) -> None:
        """Use a folder; it is made when something is kept in it."""
        self._folder = folder
        self._known: dict[int, UsersKnowledge] = {}

    def knowledge(self, wire: PopulationWire) -> UsersKnowledge:
        """Return what the user of a wire knows, characterized now or before."""
        if wire.seed not in self._known:
            self._known[wire.seed] = characterized(wire, self._of(wire))
        return self._known[wire.seed]

    def run(self, wire: PopulationWire, condition: Condition, reference: str) -> tuple[RecordedRun, SensingModel]:
        """Return a recorded run, recorded now or before, and the user's model at its beginning."""
        knowledge = self.knowledge(wire)
        made_of = (repr(condition), reference, repr(settings().run))
        path = self._of(wire) / f"{digest(*made_of)}.npz"
        model_path = path.with_suffix(".model.json")
        if not path.exists():
            run, model = record_run(wire, condition, reference, knowledge)
            if condition.home:
                model.save(model_path)
            run.save(path)  # last: it says that both are there
        return RecordedRun.load(path), load_model(model_path) if condition.home else knowledge.model

    def _of(self, wire: PopulationWire) -> Path:
        """Return the folder of a wire: it is named by all that makes its characterization."""
        known = settings()
        made_of = digest(sources(), repr(wire), repr(known.rig), repr(known.characterization))
        return self._folder / "wires" / f"{wire.seed}-{made_of}"


def digest(*texts: str) -> str:
    """Return a short hash of texts."""
    return hashlib.sha256("\n".join(texts).encode()).hexdigest()[:12]


@cache
def sources() -> str:
    """Return a short hash of the sources and data of ``ROOMS`` and of this package: an edit of any runs all again."""
    package, own = Path(str(files("musclewire"))), Path(__file__).parent
    found = hashlib.sha256()
    for folder in (*(package / room for room in ROOMS), own):
        for file in sorted(folder.rglob("*")):
            if file.suffix in (".py", ".toml", ".csv", ".json"):
                found.update(f"{folder.name}/{file.relative_to(folder).as_posix()}".encode())
                found.update(file.read_bytes())
    return found.hexdigest()[:12]


def known_wire(knowledge: UsersKnowledge) -> WireConstants | None:
    """Return the constants of a user's wire file on the load that it states, as a loop has them; None without one."""
    return None if knowledge.wire_file is None else users_wire(knowledge.wire_file, {})


def runs_of(seed: int, condition: str, reference: str, folder: str | Path = FOLDER) -> BenchmarkRun:
    """Return a recorded run of the population with what its user knows, as estimators are tuned and judged on.

    Parameters
    ----------
    seed
        Seed of the wire; tuning takes those of ``tuning_seeds``.
    condition
        Name of a condition, "none" for an undisturbed run.
    reference
        "staircase", "random steps", "sines" or "minor loops".
    folder
        Where wires and runs are kept.

    Returns
    -------
    The run and the knowledge.

    Raises
    ------
    CallerError
        For an unknown condition or reference.
    """
    (found,) = settings().conditions((condition,))
    wire, store = drawn_wire(seed), ResultStore(Path(folder))
    run, model = store.run(wire, found, reference)
    knowledge = store.knowledge(wire)
    return BenchmarkRun(run, knowledge._replace(model=model), known_wire(knowledge), found)
