"""Plants of anybody's: ``kind = "python:module:Class"`` in a rig file runs a class of a user's own module.

That is code. So a module is imported for one reason only: a command, or ``open_rig``, was given the path of a rig file
that names it. No recording, study, page or other file that refers to a rig ever leads here.
"""

from __future__ import annotations

import re
import sys
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from threading import RLock
from types import ModuleType
from typing import Any

from musclewire.errors import CallerError, MusclewireError, nearest_hint
from musclewire.rigs._device import DEVICE_METHODS, DEVICE_PROPERTIES, Device, DeviceFacts
from musclewire.rigs._kinds import DeviceConfiguration, DeviceKind
from musclewire.rigs._mounted_wire import MountedWire

FORM = re.compile(r"python:([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*):([A-Za-z_]\w*)")
# Of two threads that open the same plant the second waits until the first has run its module.
IMPORTING = RLock()
# Kinds whose modules were imported for a rig file that the user named; nothing else fills it.
imported: dict[str, DeviceKind[Any]] = {}


class OutsideConfiguration(MountedWire, DeviceConfiguration):
    """The keys of a plant whose class has no schema of its own: those of every real rig."""


def is_outside(kind: str) -> bool:
    """Return whether a kind names a class of a module from outside."""
    return kind.startswith("python:")


def known_kind(kind: str) -> DeviceKind[Any]:
    """Return the kind of a plant whose rig file the user has named. Raises CallerError for any other."""
    if kind not in imported:
        raise CallerError(f"kind '{kind}' runs code of a module: open it by the path of its rig file")
    return imported[kind]


def imported_kind(kind: str, folder: Path) -> DeviceKind[Any]:
    """Return the kind of a plant, from a rig file's folder or installed. Raises CallerError if it is no device."""
    form = FORM.fullmatch(kind)
    if form is None:
        raise CallerError(f"kind '{kind}' is not of the form \"python:module:Class\"")
    name, class_name = form.groups()
    with IMPORTING:
        module = imported_module(name, folder)
    plant = getattr(module, class_name, None)
    if plant is None:
        classes = [each for each, value in vars(module).items() if isinstance(value, type)]
        raise CallerError(f"module '{name}' has no class '{class_name}'{nearest_hint(class_name, classes)}")
    schema = schema_of(plant, kind)
    found: DeviceKind[Any] = DeviceKind(schema, lambda configuration: opened(plant, configuration))
    imported[kind] = found
    return found


def imported_module(name: str, folder: Path) -> ModuleType:
    """Return a module: the file of that name next to the rig file, otherwise an installed one."""
    file = (folder / f"{name}.py").resolve()
    known = sys.modules.get(name)
    if file.is_file() and known is not None and Path(getattr(known, "__file__", None) or "").resolve() != file:
        raise CallerError(f"there is already another module named '{name}': give {file.name} another name")
    try:
        return known if known is not None else module_in(name, file) if file.is_file() else import_module(name)
    except ModuleNotFoundError as error:
        if error.name == name.partition(".")[0] or error.name == name:
            raise CallerError(
                f"there is no module '{name}': put {file.name} next to the rig file, or install the package that has it"
            ) from None
        raise CallerError(f"module '{name}' needs a module '{error.name}', which is not installed") from error
    except MusclewireError:
        raise
    except Exception as error:
        raise CallerError(f"module '{name}' cannot be imported: {type(error).__name__}: {error}") from error


def module_in(name: str, file: Path) -> ModuleType:
    """Return a file's module; it may import what lies next to it, as a script may, but installed modules come first."""
    place = spec_from_file_location(name, file)
    assert place is not None
    assert place.loader is not None
    module = module_from_spec(place)
    sys.modules[name] = module
    sys.path.append(str(file.parent))
    try:
        place.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    finally:
        sys.path.remove(str(file.parent))
    return module


def schema_of(plant: Any, kind: str) -> type[DeviceConfiguration]:
    """Return a plant's schema: its ``configuration`` or a real rig's keys. Raises CallerError for what is no device."""
    if not isinstance(plant, type):
        raise CallerError(f"kind '{kind}' names a {type(plant).__name__}: it must be a class")
    missing = [name for name in DEVICE_METHODS if not callable(getattr(plant, name, None))]
    if missing:
        raise CallerError(
            f"class '{plant.__name__}' is no Device: no method {', '.join(missing)}, add it "
            "(docs/how-to/bring_your_own_plant.md)"
        )
    schema = getattr(plant, "configuration", OutsideConfiguration)
    if not (isinstance(schema, type) and issubclass(schema, DeviceConfiguration)):
        raise CallerError(f"'configuration' of class '{plant.__name__}' must be a subclass of DeviceConfiguration")
    return schema


def opened(plant: Any, configuration: DeviceConfiguration) -> Device:
    """Return an open plant. Raises CallerError if it is not made from a configuration, or is no device once made."""
    try:
        device: Device = plant(configuration)
    except MusclewireError:
        raise
    except Exception as error:
        raise CallerError(
            f"class '{plant.__name__}' cannot be made from its rig file: {type(error).__name__}: {error}"
        ) from error
    missing = [name for name in DEVICE_PROPERTIES if not hasattr(device, name)]
    wrong = f"it has no {', '.join(missing)}" if missing else ""
    if not missing and not isinstance(device.facts, DeviceFacts):
        wrong = "its facts are no DeviceFacts"
    elif not missing and device.drive_voltage_v != 0.0:
        wrong = f"its output is {device.drive_voltage_v} V at the beginning, and must be 0 V"
    if wrong:
        device.off()
        raise CallerError(f"class '{plant.__name__}' is no Device: {wrong} (docs/how-to/bring_your_own_plant.md)")
    return device
