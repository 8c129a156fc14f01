"""What a part outside the core offers, and which parts are there.

The core does not know its extras. Each folder of ``musclewire/extras`` holds a ``manifest.py`` with a
:class:`Manifest`: plain data that names commands, readers, kinds of rigs and the like, and where each is defined.
Nothing named in it is imported before it is used. Packages of others offer the same object through an entry point of
the group ``musclewire.extras``.
"""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from importlib.resources import files
from pathlib import Path
from typing import Any

from musclewire.errors import CallerError, require_extra
from musclewire.small_files import read_toml

ENTRY_POINTS = "musclewire.extras"
EXTRAS = Path(__file__).parent / "extras"
PARTS = Path(__file__).parent / "parts.toml"


@dataclass(frozen=True)
class Command:
    """A command as ``musclewire --help`` lists it, and the function that it becomes.

    Parameters
    ----------
    name
        Its name.
    function
        "module:function", imported when the command is called.
    help
        First paragraph of its help, repeated here so that the list of all commands imports none of them.
    panel
        Title of the panel in which it is listed; of no use in a group.
    group
        Name of the group it belongs to, "export" for example; "" for none.
    before
        Command or group of the same panel before which it is listed; last of its panel if that one is not there.
    answer
        "module:model" of what it prints with --json, for ``musclewire schema``; "" if it prints none.
    """

    name: str
    function: str
    help: str
    panel: str = ""
    group: str = ""
    before: str = ""
    answer: str = ""


@dataclass(frozen=True)
class CommandGroup:
    """A group of commands, listed if any command is in it.

    Parameters
    ----------
    name
        What is typed before the name of a command.
    help
        Its line in ``musclewire --help``.
    panel
        The panel of ``--help`` in which it is listed.
    before
        The command before which it is listed.
    """

    name: str
    help: str
    panel: str = ""
    before: str = ""


@dataclass(frozen=True)
class Manifest:
    """What a part offers. Every "place" is "module:attribute", imported when it is first needed.

    Parameters
    ----------
    name
        Its name: that of its folder, or of the entry point.
    commands
        Its commands.
    groups
        Groups of commands that are its own.
    names
        Names of ``import musclewire as mw`` by their places.
    estimators, controllers, devices, load_parts, plots, run_kinds, fits
        Kinds by name, each with its place, as the registries of the core take them. Devices are the kinds of rigs,
        ``fits`` dataclasses of options of ``musclewire fit`` (``OtherFit`` in ``app/_model_commands.py``).
    rig_keys
        Keys of simulated rigs' files by name, each with the place of a :class:`musclewire.rigs._rig_key.RigKey`.
    rig_files
        "package:folder" with the rig files that come with it, "" for none; "package:" is the package's own folder.
    rig_names
        Other names of its rig files: name to file name without suffix.
    needs
        The extra of pyproject.toml without which a kind of rig cannot be opened, by kind.
    readers
        Places of functions that take a path and return what reads that file, or None for a file of no concern to them.
    suffixes_read
        Suffixes of the files that it reads, for messages.
    writers
        Places of :class:`musclewire.signals._writing.FileWriter` by the suffix that they write.
    schemas
        Kinds of files by name, each with the place of the model that checks it.
    kernels
        Packages and modules that hold compiled functions: an edit of any starts a new cache for these, and for no
        others.
    versions
        What ``musclewire --version`` states about it: key to place of a number or text.
    """

    name: str
    commands: tuple[Command, ...] = ()
    groups: tuple[CommandGroup, ...] = ()
    names: Mapping[str, str] = field(default_factory=dict)
    estimators: Mapping[str, str] = field(default_factory=dict)
    controllers: Mapping[str, str] = field(default_factory=dict)
    devices: Mapping[str, str] = field(default_factory=dict)
    load_parts: Mapping[str, str] = field(default_factory=dict)
    plots: Mapping[str, str] = field(default_factory=dict)
    run_kinds: Mapping[str, str] = field(default_factory=dict)
    fits: Mapping[str, str] = field(default_factory=dict)
    rig_keys: Mapping[str, str] = field(default_factory=dict)
    rig_files: str = ""
    rig_names: Mapping[str, str] = field(default_factory=dict)
    needs: Mapping[str, str] = field(default_factory=dict)
    readers: tuple[str, ...] = ()
    suffixes_read: tuple[str, ...] = ()
    writers: Mapping[str, str] = field(default_factory=dict)
    schemas: Mapping[str, str] = field(default_factory=dict)
    kernels: tuple[str, ...] = ()
    versions: Mapping[str, str] = field(default_factory=dict)


def folder_of(place: str) -> Path:
    """Return a folder with data of a part, given as "package:folder"."""
    package, _, folder = place.partition(":")
    return Path(str(files(package))) / folder


def loaded(place: str) -> Any:
    """Return what is at a place, "module:attribute", whose module is imported now if it was not before."""
    module, _, attribute = place.partition(":")
    return getattr(import_module(module), attribute)


@cache
def manifests() -> tuple[Manifest, ...]:
    """Return the manifests of our extras in the order of their names, then those of others that can be imported."""
    return (*own_manifests(), *manifests_of_others())


def own_manifests() -> Iterator[Manifest]:
    """Yield the manifests of the folders of ``extras``."""
    for folder in sorted(EXTRAS.iterdir()) if EXTRAS.is_dir() else ():
        if (folder / "manifest.py").is_file():
            yield import_module(f"musclewire.extras.{folder.name}.manifest").MANIFEST


def manifests_of_others() -> Iterator[Manifest]:
    """Yield the manifests that installed packages offer."""
    for point in entry_points(group=ENTRY_POINTS):
        try:
            manifest = point.load()
        except Exception as error:  # a stranger's package must not take every command with it
            complain(point.name, f"its manifest {point.value} cannot be imported: {type(error).__name__}: {error}")
            continue
        if isinstance(manifest, Manifest):
            yield manifest
        else:
            complain(point.name, f"{point.value} is no musclewire.manifest.Manifest")


def complain(name: str, what: str) -> None:
    """Say that a package's offers are not there, and what to do."""
    sys.stderr.write(f"musclewire: package '{name}' adds nothing: {what}; update or uninstall it\n")


def offered(kind: str) -> dict[str, str]:
    """Return the places, by name, of what all parts offer of a kind, a field of a manifest; our own count first."""
    found: dict[str, str] = {}
    for manifest in manifests():
        for name, place in getattr(manifest, kind, {}).items():
            found.setdefault(name, place)
    return found


def require_packages_of(rig: str) -> None:
    """Raise MissingExtraError for an extra that a rig's kind needs, before anything is imported for it."""
    named = f"{offered('rig_names').get(rig, rig)}.toml"
    shipped = (folder_of(manifest.rig_files) / named for manifest in manifests() if manifest.rig_files)
    try:
        file = next((path for path in shipped if path.is_file()), Path(rig))
        kind = read_toml(file, "rig file").get("kind") if file.is_file() else None  # a pipe can be read only once
    except (CallerError, ValueError):
        return
    if isinstance(kind, str) and kind in offered("needs"):
        require_extra(f"a rig of kind {kind}", offered("needs")[kind])


@cache
def parts() -> Mapping[str, Mapping[str, Any]]:
    """Return what our own parts and packages offer by name, whether they are there or not (``parts.toml``)."""
    return tomllib.loads(PARTS.read_text(encoding="utf-8"))


def absent_part(kind: str, name: str) -> CallerError | None:
    """Return the error for a name of a kind in ``parts.toml`` whose part is not there, None for any other."""
    there = {manifest.name for manifest in manifests()}
    for part, offer in parts().items():
        if part not in there and name in offer.get(kind, ()):
            if "install" in offer:
                return CallerError(
                    f"'{name}' belongs to the package '{part}' ({offer['what']}), which is not installed: "
                    f"{offer['install']} in the checkout"
                )
            return CallerError(
                f"'{name}' belongs to the part '{part}' ({offer['what']}), which this installation does not have: put "
                f"the folder musclewire/extras/{part} back, or install musclewire again"
            )
    return None
