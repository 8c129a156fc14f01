"""A key of simulated rigs' files that a part outside the core offers: what it holds, and the device it asks for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class RigKey:
    """A key of simulated rigs' files, offered by ``rig_keys`` of a manifest and imported with their schema."""

    held: Any  # type of its value, as pydantic takes it; a value that is false asks for nothing
    field: Any  # pydantic's ``Field`` of it, with the value of a file without the key, and what it is for
    written: str  # how a file writes it, "[[fault]]" for example
    what: str  # what it asks for in messages, "faults" for example
    # Place of what makes its device, of its value, a spool and the keywords of ``SimulatedDevice``; imported when a rig
    # is opened.
    device: str
    # Says for its value and the whole configuration why they do not fit together.
    misfit: Callable[[Any, Any], str | None] = lambda _value, _configuration: None
