"""Kinds of devices by the name that ``kind = "..."`` has in a rig file: built-in ones and those of other packages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, Self, TypeVar

from pydantic import Field

from musclewire.errors import CallerError
from musclewire.parameters import CheckedFile, is_wire_file
from musclewire.registry import Registry
from musclewire.rigs._beyond_catalogue import confirmed_beyond
from musclewire.rigs._device import Device


class DeviceConfiguration(CheckedFile):
    """A rig file, checked by its schema; plain data.

    Parameters
    ----------
    kind
        Name of the device's kind in ``DEVICES``.
    beyond_catalogue
        Whether numbers that no wire of the catalogue has or survives are meant so; otherwise they are refused.

    Raises
    ------
    CallerError
        For an unknown key, suggesting the nearest, and for a value that a key does not allow.
    """

    kind: str
    beyond_catalogue: bool = Field(
        default_factory=confirmed_beyond,
        description="Whether numbers that no wire of the catalogue has or survives are meant so.",
    )

    def with_files_in(self, folder: Path) -> Self:
        """Return the configuration with the files that it names taken from a folder; by default its wire file.

        Parameters
        ----------
        folder
            Folder of the rig file.

        Returns
        -------
        A configuration whose paths are valid from anywhere.
        """
        wire = dict(self).get("wire")
        known = isinstance(wire, str) and is_wire_file(wire)
        return self.model_copy(update={"wire": str(folder / wire)}) if known and wire else self


Settings = TypeVar("Settings", bound=DeviceConfiguration)


@dataclass(frozen=True)
class DeviceKind(Generic[Settings]):
    """A kind of device: the schema of its rig files, and the function that opens it.

    Parameters
    ----------
    configuration
        Schema of its rig files.
    opened
        Opens the device of a configuration, with 0 V out. It raises MissingExtraError if a package is not installed,
        RigError if the device cannot be opened, CallerError if the file contradicts the device.
    """

    configuration: type[Settings]
    opened: Callable[[Settings], Device]

    def open(self, configuration: DeviceConfiguration) -> Device:
        """Return the open device.

        Parameters
        ----------
        configuration
            A rig file of this kind.

        Returns
        -------
        The device with 0 V out; nothing guards it yet.

        Raises
        ------
        CallerError
            For a rig file of another kind.
        """
        if not isinstance(configuration, self.configuration):
            raise CallerError(
                f"a rig file of kind '{configuration.kind}' is not a {self.configuration.__name__}: open it by its "
                "own kind"
            )
        return self.opened(configuration)


# A kind is loaded only when a rig file names it.
DEVICES: Registry[DeviceKind[Any]] = Registry(
    "kind of rig",
    "devices",
    {
        "simulated": "musclewire.rigs._configuration:SIMULATED_KIND",
        "replay": "musclewire.rigs._replay:REPLAY",
    },
)
