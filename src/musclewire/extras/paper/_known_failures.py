"""The committed list of rows of ``musclewire reproduce`` that are known to fail, each with its reason."""

from __future__ import annotations

import tomllib
from importlib.resources import files

from musclewire.errors import CallerError

FILE = "known_failures.toml"


def known_failures() -> dict[str, str]:
    """Return the reason of each known failure by the name of its row."""
    return parsed_known_failures((files("musclewire.extras.paper") / FILE).read_text("utf-8"))


def parsed_known_failures(text: str) -> dict[str, str]:
    """Return the list in a TOML text. Raises CallerError if a row has no reason in words."""
    listed = tomllib.loads(text)
    for name, reason in listed.items():
        if not (isinstance(reason, str) and reason.strip()):
            raise CallerError(f"{FILE}: '{name}' needs its reason as text")
    return listed
