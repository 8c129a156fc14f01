"""What the benchmark has computed, in a folder, by content: the same wire, settings and sources are not run twice."""

from __future__ import annotations

import hashlib
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

from musclewire.extras.studies._robustness.characterizing import UsersKnowledge, characterized
from musclewire.extras.studies._robustness.population import PopulationWire, drawn_wire
from musclewire.extras.studies._robustness.recorded_run import RecordedRun
from musclewire.extras.studies._robustness.recording_runs import record_run
from musclewire.extras.studies._robustness.settings import Condition, settings
from musclewire.identify import users_wire
from musclewire.sensing import SensingModel, load_model
from musclewire.wire import WireConstants

# Where runs are kept by default.
FOLDER = Path("robustness")
# Rooms whose sources and data decide what a wire does and what its user knows of it: an edit of any runs all again. An
# estimator decides neither: whoever works on one keeps all runs.
ROOMS = (
    *("physics", "wire", "parameters", "sensing", "controllers", "rigs", "identify", "experiment"),
    *("extras/grip", "extras/particles", "extras/studies/_segmented", "extras/studies/_robustness"),
)
OF_ESTIMATORS = ("estimator", "gated", "particles", "tick")


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
def sources(*, with_estimators: bool = False) -> str:
    """Return a short hash of the sources and data of ``ROOMS``; those of estimators count if results depend on them."""
    package = Path(str(files("musclewire")))
    found = hashlib.sha256()
    for file in (file for room in ROOMS for file in sorted((package / room).rglob("*"))):
        of_an_estimator = any(word in file.relative_to(package).as_posix() for word in OF_ESTIMATORS)
        if file.suffix in (".py", ".toml", ".csv", ".json") and (with_estimators or not of_an_estimator):
            found.update(file.relative_to(package).as_posix().encode())
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
