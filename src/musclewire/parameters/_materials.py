"""Materials of flexures: those that ship with musclewire (``data/materials``), by name, and the user's own, by file."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field, model_validator

from musclewire.errors import CallerError, nearest_hint
from musclewire.parameters._parameter_groups import Parameter, ParameterGroup, parameter
from musclewire.parameters._validation import DATA, load_named, shipped_names

# What printers' owners call the processes.
SYNONYMS = {"fdm": "print", "fff": "print", "sls": "sinter"}


class Material(ParameterGroup):
    """An isotropic elastic material, the stress it may bear, and how thin each process makes it."""

    format: Literal["musclewire-material"]
    version: Literal[1]
    youngs_modulus_pa: Parameter = parameter("Pa", "E: Young's modulus")
    poisson_ratio: Parameter = parameter("1", "nu: Poisson's ratio", "not negative")
    yield_stress_pa: Parameter = parameter("Pa", "stress at which it yields")
    allowable_stress_pa: Parameter = parameter("Pa", "stress that a flexure bears for long and in many cycles")
    density_kg_per_m3: Parameter = parameter("kg/m^3", "density")
    minimum_thickness_m: dict[str, Parameter] = Field(description="thinnest flexure by process", min_length=1)

    @model_validator(mode="after")
    def _numbers_belong_together(self) -> Material:
        for process, item in self.minimum_thickness_m.items():
            if item.unit != "m":
                raise ValueError(f"minimum_thickness_m.{process} has the unit '{item.unit}', it must be given in 'm'")
            if item.value <= 0.0:
                raise ValueError(f"minimum_thickness_m.{process} is {item.value:g} m, it must be above 0")
        if self.poisson_ratio.value >= 0.5:
            raise ValueError(f"poisson_ratio is {self.poisson_ratio.value:g}, it must be below 0.5")
        if self.allowable_stress_pa.value > self.yield_stress_pa.value:
            raise ValueError(
                f"allowable_stress_pa ({self.allowable_stress_pa.value:g}) is above yield_stress_pa "
                f"({self.yield_stress_pa.value:g}): give at most that"
            )
        return self

    @property
    def processes(self) -> list[str]:
        """The processes known for this material, the usual one first."""
        return list(self.minimum_thickness_m)

    def process_called(self, name: str | None) -> str:
        """Return a process by its name or a common synonym (fdm, fff, sls); by default the usual one."""
        if name is None:
            return self.processes[0]
        chosen = name if name in self.minimum_thickness_m else SYNONYMS.get(name.lower(), name)
        if chosen not in self.minimum_thickness_m:
            raise CallerError(f"{self.name} is not made by '{name}'{nearest_hint(name, self.processes)}")
        return chosen

    def minimum_thickness_by(self, process: str | None) -> float:
        """Return the thinnest flexure that a process, by default the usual one, makes."""
        return self.minimum_thickness_m[self.process_called(process)].value


def folder_of_materials() -> Path:
    """Return the folder of the materials that ship with musclewire."""
    return DATA / "materials"


def material_names() -> list[str]:
    """Return the names of the materials that ship with musclewire."""
    return shipped_names("materials")


def load_material(name: str) -> Material:
    """Return a material of flexures.

    Parameters
    ----------
    name
        One that ships with musclewire, or a file (.toml), which is read at every call.

    Returns
    -------
    The material, checked.

    Raises
    ------
    CallerError
        For an unknown name or a wrong file, naming the key and the nearest right one.
    """
    return load_named(Material, "materials", "material", name)
