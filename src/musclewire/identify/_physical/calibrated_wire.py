"""The wire of a calibration as a file."""

from __future__ import annotations

from pathlib import Path

from musclewire.errors import CallerError
from musclewire.identify._physical.bench import SETTABLE
from musclewire.identify._physical.calibration import Calibration
from musclewire.identify._physical.isobaric import IsobaricObservation
from musclewire.parameters import Bench, Parameter, is_wire_file, wire_file_text
from musclewire.signals import write_text_whole

# Numbers of a bench that belong to the recording's rig and not to the wire's bench.
NOT_KEPT = ("sample_period_s",)


def save_wire(calibration: Calibration, path: str | Path, name: str | None = None) -> None:
    """Write the fitted wire, its alloy and the known numbers of the bench as one wire file, whole or not at all.

    Parameters
    ----------
    calibration
        The calibration.
    path
        File to write; it ends in .toml, and an existing one is replaced.
    name
        Name of the wire; the file's without its suffix if it is None.

    Raises
    ------
    CallerError
        If the path has another suffix, or its folder cannot be written to.
    """
    path = Path(path)
    if not is_wire_file(path.name):
        raise CallerError(f"{path}: a wire is a .toml file, end its name so")
    text = wire_file_text(
        name or path.stem, description(calibration), calibration.wire, calibration.alloy, known_bench(calibration)
    )
    write_text_whole(path, text)


def description(calibration: Calibration) -> str:
    """Return a sentence that states how a wire was fitted."""
    identifiable, whole = len(calibration.identifiable), len(calibration.estimates)
    verdict = "" if calibration.holds else "; the fit does not hold: the model does not follow every channel"
    return (
        f"Fitted to {', '.join(calibration.inputs.sources)}, started from {calibration.inputs.wire} with the priors "
        f"{calibration.inputs.priors.name}: {identifiable} of {whole} parameters identifiable from the recordings, "
        f"residuals {calibration.rmse:.2f} of their uncertainty{verdict}"
    )


def known_bench(calibration: Calibration) -> dict[str, Parameter]:
    """Return the fitted numbers of the bench, then those on which all recordings of a drive or of cooling agree."""
    found = {key: item for key, item in calibration.bench.items() if key in calibration.problem.candidates.names}
    stated = [
        item.bench  # type: ignore[attr-defined]
        for item in calibration.problem.observations
        if not isinstance(item, IsobaricObservation)
    ]
    source = f"stated with {', '.join(calibration.inputs.sources)}, or fitted to force and displacement"
    for key in stated[0] if stated else ():
        alike = len({bench.get(key) for bench in stated}) == 1
        if alike and key in Bench.model_fields and key not in found and key not in NOT_KEPT:
            found[key] = Parameter(value=stated[0][key], unit=SETTABLE[key], kind="measured", source=source)
    return found
