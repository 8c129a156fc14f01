"""The file of a study: which rig, what varies on it and how, what is run, what is kept."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from musclewire.errors import CallerError
from musclewire.extras.studies._varied_parameters import ParameterTable
from musclewire.parameters import validated
from musclewire.small_files import read_toml


class Sampling(BaseModel):
    """The table ``[sampling]``: how the distributions of the parameters are sampled.

    Parameters
    ----------
    method
        "sobol" (a scrambled quasi-random sequence), "latin-hypercube", "halton", "random", or "saltelli", from which
        first and total Sobol indices follow.
    samples
        Samples at each point of the grid. "sobol" and "saltelli" take a power of 2; "saltelli" makes as many times the
        number of sampled parameters plus two.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    method: Literal["sobol", "latin-hypercube", "halton", "random", "saltelli"] = "sobol"
    samples: int = Field(ge=1, le=10_000_000)


class StudyFile(BaseModel):
    """A study, checked as far as it can be without its kind of run; plain data.

    Parameters
    ----------
    format
        "musclewire-study".
    version
        Version of the format, 1.
    name
        Name of the study.
    description
        What it is for, in a sentence.
    rig
        A rig's name, a rig file next to the study's, or the keys of a rig file as a table ``[rig]``. It is simulated.
    seed
        Seed of the sampling and of the noise of every run.
    run
        What is run: ``kind``, the keys of that kind, and ``keep``, the quantities that are kept (by default every one
        that is a number).
    sampling
        How distributions are sampled; None if all parameters are axes of a grid.
    parameters
        What varies, by name: any number of wire, alloy or bench, any key of the rig file, and ``run.KEY``.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    format: Literal["musclewire-study"]
    version: Literal[1]
    name: str = Field(min_length=1)
    description: str = ""
    rig: str | dict[str, Any] = "simulated"
    seed: int = Field(default=1, ge=0)
    run: dict[str, Any]
    sampling: Sampling | None = None
    parameters: dict[str, ParameterTable]


def read_study_file(path: Path) -> StudyFile:
    """Return a study's file, checked. Raises CallerError that names the file, the key and the nearest right key."""
    return study_file(read_toml(path, "study file"), f"study file {path}")


def study_file(data: dict[str, Any], where: str) -> StudyFile:
    """Return a study from the content of its file. Raises CallerError that names the key and the nearest right one."""
    tables = data.get("parameters", {})
    if not isinstance(tables, dict):
        raise CallerError(f"{where}: parameters must be tables, as [parameters.pretension_n]")
    return validated(StudyFile, {**data, "parameters": flat(tables)}, where)


def flat(tables: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return the tables of parameters by their whole names: [parameters.load.spring.stiffness] is nested in TOML."""
    found: dict[str, Any] = {}
    for name, table in tables.items():
        nested = isinstance(table, dict) and table and all(isinstance(item, dict) for item in table.values())
        # A table whose only key is 'shape' is a distribution that lacks its name, and no parameter called shape.
        if nested and set(table) != {"shape"}:
            found |= flat(table, f"{prefix}{name}.")
        else:
            found[f"{prefix}{name}"] = table
    return found
