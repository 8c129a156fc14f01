"""What is in an FMU: a model's variables, its C sources, and what it does not contain."""

from __future__ import annotations

import uuid
from collections.abc import Mapping
from importlib.resources import files
from typing import NamedTuple

from musclewire.extras.board import library_license
from musclewire.extras.interfaces._fmu.description import ModelDescription, description_text
from musclewire.extras.interfaces._fmu.header import variables_header
from musclewire.extras.interfaces._fmu.variables import FmuVariables

# Exports of the same content have the same GUID, those of other content another.
NAMESPACE = uuid.UUID("6d1e5c1e-6f0b-5b0c-9a53-8f7f2b6a3c10")
LOG_OWNERS = {
    "caller": "what the importing tool or its user must change: a value, an order of calls",
    "numerics": "a step that could not be computed: communicate in shorter steps",
    "protection": "what the controller's protection did, and why",
}


class FmuContents(NamedTuple):
    """A model to export.

    ``sources`` are all its C files but those that every FMU has; ``step_s`` is the communication step that tools
    should take by default [s]; ``left_out`` names what the rig or model has and the FMU has not.
    """

    title: str
    variables: FmuVariables
    sources: Mapping[str, str]
    step_s: float
    owners: tuple[str, ...]
    left_out: tuple[str, ...]


def c_files(folder: str, *, without: tuple[str, ...] = ()) -> dict[str, str]:
    """Return the C files of a folder of ``musclewire.extras.interfaces``, by name."""
    return {
        item.name: item.read_text(encoding="utf-8")
        for item in (files("musclewire.extras.interfaces") / folder).iterdir()
        if item.name.endswith((".c", ".h")) and item.name not in without
    }


def fmu_sources(contents: FmuContents, guid: str) -> dict[str, str]:
    """Return all C files of an FMU by name."""
    models = tuple(name for name in c_files("c_fmu") if name.endswith("_model.c"))
    return {
        **c_files("c_fmu", without=models),
        **contents.sources,
        "mw_variables.h": variables_header(contents.variables, guid),
    }


def fmu_texts(name: str, contents: FmuContents) -> dict[str, str]:
    """Return every text of an FMU by its path in the archive."""
    nameless = fmu_sources(contents, "")
    text_of_all = "\n".join(f"{file}\n{nameless[file]}" for file in sorted(nameless))
    guid = f"{{{uuid.uuid5(NAMESPACE, f'{name}{contents.title}{contents.step_s!r}{text_of_all}')}}}"
    sources = fmu_sources(contents, guid)
    compiled = sorted(file for file in sources if file.endswith(".c"))
    owners = [(owner, LOG_OWNERS[owner]) for owner in contents.owners]
    about = ModelDescription(name, contents.title, guid, contents.step_s, compiled, owners)
    license_text = library_license()
    return {
        "modelDescription.xml": description_text(about, contents.variables),
        **{f"sources/{file}": text for file, text in sorted(sources.items())},
        "documentation/licenses/license.txt": license_text,
    }
