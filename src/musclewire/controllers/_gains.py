"""The gains file: a controller by name with its settings, as ``tune`` finds them and ``control --gains`` reads them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from musclewire.controllers._feedforward import FeedforwardSettings
from musclewire.controllers._fuzzy_pid import FuzzyPidSettings
from musclewire.errors import CallerError, nearest_hint

FORMAT = "musclewire-gains"
KINDS: dict[str, type[Any]] = {"feedforward": FeedforwardSettings, "fuzzy-pid": FuzzyPidSettings}


@dataclass(frozen=True)
class Gains:
    """The gains of a wire: a controller and its settings.

    Parameters
    ----------
    controller
        Name of the controller: "feedforward" or "fuzzy-pid".
    settings
        Its settings; those of the fuzzy PID name their rule base.
    """

    controller: str
    settings: FeedforwardSettings | FuzzyPidSettings


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
    from musclewire.parameters import read_toml

    content = read_toml(Path(path), "gains file", ": make one with 'musclewire tune MODEL RECORDING -o FILE'")
    controller, settings = content.get("controller"), content.get("settings")
    if content.get("format") != FORMAT or not isinstance(settings, dict):
        raise CallerError(f"{path} is not a gains file of musclewire: make one with 'musclewire tune'")
    if controller not in KINDS:
        raise CallerError(f"gains file {path}: no controller '{controller}'{nearest_hint(str(controller), KINDS)}")
    try:
        return Gains(str(controller), KINDS[str(controller)](**settings))
    except CallerError as error:
        raise CallerError(f"gains file {path}: {error}") from None


def save_gains(gains: Gains, path: str | Path, notes: tuple[str, ...] = ()) -> None:
    """Write a gains file.

    Parameters
    ----------
    gains
        Controller and settings.
    path
        File to write; one that exists is replaced.
    notes
        Comments at its top, a line each.

    Raises
    ------
    CallerError
        If the file cannot be written there.
    """
    lines = [f"# {note}" for note in notes]
    lines += [f'format = "{FORMAT}"', f'controller = "{gains.controller}"', "", "[settings]"]
    lines += [f"{name} = {toml_value(value)}" for name, value in gains.settings.model_dump().items()]
    try:
        Path(path).write_text("\n".join(lines) + "\n", "utf-8")
    except OSError as error:
        raise CallerError(f"cannot write gains file {path}: {error.strerror or error}") from None


def toml_value(value: Any) -> str:
    """Return a text, a number or a row of numbers as TOML."""
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    if isinstance(value, tuple):
        return f"[{', '.join(repr(float(one)) for one in value)}]"
    return repr(float(value))
