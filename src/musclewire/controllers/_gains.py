"""The gains of a wire: a controller by name with its settings, kept in its model or in a gains file of their own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from musclewire.errors import CallerError, nearest_hint
from musclewire.manifest import loaded
from musclewire.registry import REPLACED
from musclewire.small_files import toml_text

if TYPE_CHECKING:
    from musclewire.controllers._fuzzy_pid import FuzzyPidSettings
    from musclewire.controllers._known_wire import FeedforwardSettings

FORMAT, KEYS = "musclewire-gains", {"format", "controller", "settings"}
# Settings that older files have and nothing reads any more.
OF_OLDER_FILES = ("pulse_time_s", "tolerance", "gap_fraction")
# The controllers whose settings a model may keep, and where these are: who does without one does not import it.
KINDS = {
    "fuzzy-pid": "musclewire.controllers._fuzzy_pid:FuzzyPidSettings",
    "inverse-model": "musclewire.controllers._known_wire:FeedforwardSettings",
}


def controller_of(settings: Any) -> str:
    """Return the name of the controller that settings belong to; CallerError for settings that do not say it."""
    name = getattr(settings, "of_controller", "")
    if not name:
        kind = type(settings).__name__
        raise CallerError(f"settings of the kind {kind} do not say whose they are: name the controller")
    return str(name)


@dataclass(frozen=True)
class Gains:
    """The gains of a wire: a controller and its settings."""

    controller: str  # name of the controller: "inverse-model" or "fuzzy-pid"
    settings: FeedforwardSettings | FuzzyPidSettings  # its settings; those of the fuzzy PID name their rule base

    @classmethod
    def read(cls, kept: Mapping[str, Any], place: str) -> Gains:
        """Return the gains of a table, as ``table`` gives it; ``place`` begins every message."""
        settings = dict(kept)
        controller = str(settings.pop("controller", ""))
        controller = REPLACED.get(controller, controller)  # of an older file
        for name in OF_OLDER_FILES:
            settings.pop(name, None)
        if controller not in KINDS:
            raise CallerError(f"{place}: no controller '{controller}'{nearest_hint(controller, KINDS)}")
        try:
            return cls(controller, loaded(KINDS[controller])(**settings))
        except CallerError as error:
            raise CallerError(f"{place}: {error}") from None

    def serve(self, controller: object) -> bool:
        """Return whether a controller, by its name, takes settings of this kind."""
        return controller == self.settings.of_controller

    def table(self) -> dict[str, Any]:
        """Return the controller's name and its settings by name, as a model keeps them."""
        return {"controller": self.controller, **self.settings.model_dump()}


def load_gains(path: str | Path) -> Gains:
    """Read a gains file.

    Parameters
    ----------
    path
        A file that ``musclewire tune`` has written.

    Returns
    -------
    Controller and settings.

    Raises
    ------
    CallerError
        If the file is missing or no gains file, or for an unknown controller or key; the message is one line.
    """
    from musclewire.small_files import read_toml

    content = read_toml(Path(path), "gains file", ": make one with 'musclewire tune MODEL RECORDING -o FILE'")
    controller, settings = content.get("controller"), content.get("settings")
    if content.get("format") != FORMAT or not isinstance(settings, dict):
        raise CallerError(f"{path} is not a gains file of musclewire: make one with 'musclewire tune'")
    if unknown := sorted(set(content) - KEYS):
        raise CallerError(f"gains file {path}: unknown key '{unknown[0]}'{nearest_hint(unknown[0], KEYS)}")
    return Gains.read({"controller": controller, **settings}, f"gains file {path}")


def save_gains(gains: Gains, path: str | Path, notes: tuple[str, ...] = ()) -> None:
    """Write a gains file, or replace one, with notes as comments at its top, a line each."""
    content = {"format": FORMAT, "controller": gains.controller, "settings": gains.settings.model_dump()}
    try:
        Path(path).write_text("".join(f"# {note}\n" for note in notes) + toml_text(content), "utf-8")
    except OSError as error:
        raise CallerError(f"cannot write gains file {path}: {error.strerror or error}") from None
