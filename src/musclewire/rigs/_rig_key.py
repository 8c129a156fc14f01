"""A key of simulated rigs' files that a part outside the core offers: what it holds, and the device it asks for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class RigKey:
    """A key of simulated rigs' files, offered by ``rig_keys`` of a manifest; its module is imported with their schema.

    Parameters
    ----------
    held
        Type of its value, as pydantic takes it. A value that is false asks for nothing.
    field
        pydantic's ``Field`` of it, with the value of a file without the key, and what it is for.
    written
        How a file writes it, "[[fault]]" for example.
    what
        What it asks for in messages, "faults" for example.
    device
        Place of what makes its device, of its value, a spool and the keywords of ``SimulatedDevice``, from which the
        device is derived; imported when a rig is opened.
    misfit
        Returns for its value and the whole configuration why they do not fit together; None if they do.
    """

    held: Any
    field: Any
    written: str
    what: str
    device: str
    misfit: Callable[[Any, Any], str | None] = lambda _value, _configuration: None
