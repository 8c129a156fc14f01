"""Settings of the fuzzy PID as commands take them: from a TOML file, and the rule base by an option."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from musclewire.errors import CallerError

if TYPE_CHECKING:
    from musclewire.controllers import FuzzyPidSettings


def read_settings(path: Path | None, rules: str | None) -> FuzzyPidSettings:
    """Return a TOML file's settings, with the rules that an option names. Raises CallerError naming file and key."""
    from musclewire.controllers import FuzzyPidSettings
    from musclewire.small_files import read_toml

    given: dict[str, Any] = {} if path is None else read_toml(path, "settings file")
    if rules is not None:
        given["rule_base"] = rules
    try:
        return FuzzyPidSettings(**given)
    except CallerError as error:
        raise CallerError(f"settings file {path}: {error}" if path else str(error)) from None
