"""The committed list of rows of ``musclewire reproduce`` that are known to fail, each with its reason."""

from __future__ import annotations

import tomllib

from musclewire.errors import CallerError
from musclewire.parameters.library import published_text

__all__ = ["known_failures", "parsed_known_failures"]

FILE = "known_failures.toml"


def known_failures() -> dict[str, str]:
    """Return the reason of each known failure by the name of its row."""
    return parsed_known_failures(published_text(FILE))


def parsed_known_failures(text: str) -> dict[str, str]:
    """Return the list in a TOML text. Raises CallerError if a row has no reason in words."""
    listed = tomllib.loads(text)
    for name, reason in listed.items():
        if not (isinstance(reason, str) and reason.strip()):
            raise CallerError(f"{FILE}: '{name}' needs its reason as text")
    return listed
