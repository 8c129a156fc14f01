"""A device around another one that looks at, or changes, what comes back: faults below the protection."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from musclewire.rigs import Answer, Device
from musclewire.signals import Command


class AlteredDevice:
    """Another device, whose answers go through a function; everything else, its abilities too, is that device's."""

    def __init__(self, device: Device, altered: Callable[[Answer], Answer]) -> None:
        self._device, self._altered = device, altered

    def exchange(self, command: Command) -> Answer:
        return self._altered(self._device.exchange(command))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._device, name)
