"""Reading a user's TOML file, with errors in one line."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from musclewire.errors import CallerError

__all__ = ["read_toml"]


def read_toml(path: Path, kind: str, instead: str = "") -> dict[str, Any]:
    """Return the content of a TOML file; ``kind`` is its name in messages, such as "wire file".

    Raises CallerError if the file does not exist (the message ends with ``instead``), or is no TOML.
    """
    try:
        return tomllib.loads(path.read_text("utf-8"))
    except FileNotFoundError:
        raise CallerError(f"there is no {kind} {path}{instead}") from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise CallerError(f"{kind} {path} cannot be read: {error}") from None
