"""An FMU opened by FMPy, step by step, and what its tests share."""

from __future__ import annotations

import ctypes
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from tests.tools import require_oracle

OK, WARNING, DISCARD, ERROR = range(4)


class Slave:
    """An instance of an FMU, with values by name and its messages."""

    def __init__(self, path: Path, folder: Path | None = None) -> None:
        """Unpack and instantiate it; ``folder`` is where it has been unpacked already."""
        fmpy, fmi2 = require_oracle("fmpy"), require_oracle("fmpy.fmi2")
        self.folder = folder or Path(fmpy.extract(str(path)))
        self.description = fmpy.read_model_description(str(self.folder))
        self.time_s = 0.0
        self._by_name = {variable.name: variable for variable in self.description.modelVariables}
        simulation = self.description.coSimulation
        assert simulation is not None
        self.fmu = fmi2.FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=str(self.folder),
            modelIdentifier=simulation.modelIdentifier,
            instanceName="tested",
        )
        outputs = [variable for variable in self.description.modelVariables if variable.causality == "output"]
        kinds = {"Real": self.fmu.getReal, "Boolean": self.fmu.getBoolean}
        self._outputs = [
            (kinds.get(kind, self.fmu.getInteger), [variable for variable in outputs if variable.type == kind])
            for kind in sorted({variable.type for variable in outputs})
        ]
        self.messages: list[tuple[int, str]] = []
        self._callbacks = fmi2.fmi2CallbackFunctions()
        self._callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(self._log)
        self.fmu.instantiate(callbacks=self._callbacks)

    def _log(self, _environment: Any, _name: bytes, status: int, category: bytes, message: bytes) -> None:
        """Keep a message with its status and its category."""
        self.messages.append((status, f"{category.decode()}: {message.decode()}"))

    def __enter__(self) -> Self:
        """Return the instance."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Free it."""
        self.fmu.freeInstance()

    def start(self, **values: float) -> None:
        """Initialize with these start values."""
        self.fmu.setupExperiment(startTime=0.0)
        self.set(**values)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.time_s = 0.0

    def set(self, **values: float) -> None:
        """Set values by name."""
        for name, value in values.items():
            variable = self._by_name[name]
            if variable.type == "Real":
                self.fmu.setReal([variable.valueReference], [value])
            elif variable.type == "Boolean":
                self.fmu.setBoolean([variable.valueReference], [value])
            else:
                self.fmu.setInteger([variable.valueReference], [value])

    def knows(self, name: str) -> bool:
        """Return whether it has a variable of this name."""
        return name in self._by_name

    def get(self, name: str) -> float:
        """Return a value by name."""
        variable = self._by_name[name]
        if variable.type == "Real":
            return float(self.fmu.getReal([variable.valueReference])[0])
        if variable.type == "Boolean":
            return float(self.fmu.getBoolean([variable.valueReference])[0])
        return float(self.fmu.getInteger([variable.valueReference])[0])

    def step(self, step_s: float) -> None:
        """Take one communication step."""
        self.fmu.doStep(currentCommunicationPoint=self.time_s, communicationStepSize=step_s)
        self.time_s += step_s

    def status_of_step(self, time_s: float, step_s: float) -> int:
        """Return the status of a communication step that may fail."""
        step = self.fmu.dll.fmi2DoStep
        return int(step(self.fmu.component, ctypes.c_double(time_s), ctypes.c_double(step_s), ctypes.c_int(1)))

    def outputs(self) -> dict[str, float]:
        """Return all outputs by name."""
        found = {}
        for get, variables in self._outputs:
            values = get([variable.valueReference for variable in variables])
            found |= {variable.name: float(value) for variable, value in zip(variables, values, strict=True)}
        return found
