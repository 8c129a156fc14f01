"""Sensing models as small JSON files, checked when they are read."""

from __future__ import annotations

import hashlib
import json
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from musclewire.errors import CallerError, MusclewireError, nearest_hint
from musclewire.sensing._fit_report import FittedCurve
from musclewire.sensing._home_move import HomeMove
from musclewire.sensing._wire_model import with_wire_model
from musclewire.sensing._wire_tables import WireModel, WireNumber
from musclewire.signals import write_text_whole
from musclewire.small_files import MAX_BYTES, json_of, read_small

if TYPE_CHECKING:
    from os import PathLike

MODEL_FORMAT = "musclewire-sensing-model"
MODEL_VERSION = 2
# A file of the first version has no wire model; a model with a slow loop gets that which its loop shows.
FIRST_VERSION = 1
ITS_WIRE = "its wire model was made from its slow loop"
NO_WIRE = "it keeps no whole slow loop, so that there is no wire model and the estimator filter cannot run by it"

# The range of the quantity is written for the file's reader; on loading it must agree with the polynomials.
RANGE_AGREEMENT = 1e-6

Finite = Annotated[float, Field(allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Coefficients = Annotated[list[Finite], Field(min_length=2, max_length=16)]
Errors = Annotated[list[NotNegative], Field(max_length=16)]
Samples = Annotated[list[tuple[Finite, Finite]], Field(max_length=2000)]
Rows = Annotated[list[tuple[Finite, Finite, Finite]], Field(max_length=2000)]
Levels = Annotated[list[Finite], Field(max_length=1000)]


NOT_OF_MODEL = {"format", "version", "checksum"}
# Texts that a reader may add to.
FOR_READERS = {"checksum", "created_by", "no_gains", "source", "warnings"}


class ModelFile(BaseModel):
    """The keys of a model file; anything else is an error.

    Parameters
    ----------
    format
        "musclewire-sensing-model".
    version
        Version of the format, 2; of the first one files have no ``wire_model``.
    quantity
        Strain, displacement or force.
    unit
        Strain "1", displacement "m" or force "N".
    resistance_min_ohm, resistance_max_ohm
        The resistance at C (R_min) and at B (R_max), on heating [ohm].
    order
        Of both polynomials.
    heating_coefficients, cooling_coefficients
        The polynomials g_h and g_c, ascending powers of the normalised resistance.
    normalised_min, normalised_max
        Where the average falls and can be inverted.
    quantity_min, quantity_max
        The range it senses; must agree with the polynomials.
    hysteresis_gap
        The gap between the branches (Eq. 2), a fraction.
    rmse_heating, rmse_cooling, rmse_average
        Root mean square errors over resistance.
    samples
        Number of samples in the fit.
    resistance_noise_ohm
        Noise of the recording, for the standard deviation of an estimate [ohm].
    scale_std, offset_std
        Standard deviations of a common factor and of a common offset of a curve that was not measured with an
        instrument; 0 for one that was.
    heating_standard_errors, cooling_standard_errors
        Of the coefficients.
    warnings
        Reservations about the fit.
    wire
        Notes on the wire it was fitted to, and the guide's friction if the recording identifies it.
    created_by, source
        Program and recording it was fitted with.
    heating_samples, cooling_samples
        At most 200 points of each branch, for plots.
    slow_loop
        At most 2000 rows of time [s], electrical power [W] and resistance [ohm] through the loop, cold to hot and
        back, with which a home move compares; without them there can be none.
    home
        The last home move, null before the first: ``time``, ``moves`` and ``cycles`` since the characterization,
        ``load_n`` and ``ambient_k`` that were assumed, ``corrected``, scale and offset of the resistance, shift of the
        transformation and convection with their standard deviations (``..._std``), and ``drift_resistance_ohm``, the
        drift allowed for since, with ``drift_source``.
    gains
        The gains that ``fit`` found in the loop, or ``tune -o MODEL`` put there: ``controller`` and its settings by
        name, as in a gains file; empty if there are none.
    no_gains
        Why the fit found none, as that the recording does not state the wire's heat balance.
    measured_stroke
        Largest less cold quantity of the loop, of which errors are a percentage; 0 if no motion was measured.
    holds, does_not_hold
        Whether a closed loop by this model is right as far as the fit's own recording shows, and why not.
    wire_model
        What the loop shows of the wire besides the curve, null without a loop: tables of power [W] and normalised
        resistance on both branches over the place (the quantity over its largest), ``first_place`` and
        ``place_spacing`` of their rows; and numbers, each with ``value``, ``std`` and ``origin``: ``time_constant_s``,
        ``heat_j_per_unit``, ``resistance_noise_ohm``, ``sensed_from`` (the place of B), ``phase_resistance``,
        ``minor_loops`` (0 a play, 1 scaled copies), ``lowest_power_w``, ``highest_power_w``.
    checksum
        Of all that is computed with: a file whose numbers were altered is refused; ``warnings``, ``source`` and the
        like may be added to.
    """

    model_config = ConfigDict(extra="forbid", strict=True)

    format: Literal["musclewire-sensing-model"]
    version: int
    quantity: Literal["strain", "displacement", "force"]
    unit: str
    resistance_min_ohm: Finite
    resistance_max_ohm: Finite
    order: int
    heating_coefficients: Coefficients
    cooling_coefficients: Coefficients
    normalised_min: Finite
    normalised_max: Finite
    quantity_min: Finite
    quantity_max: Finite
    hysteresis_gap: NotNegative
    rmse_heating: NotNegative
    rmse_cooling: NotNegative
    rmse_average: NotNegative
    samples: Annotated[int, Field(ge=0)]
    resistance_noise_ohm: NotNegative = 0.0
    scale_std: NotNegative = 0.0
    offset_std: NotNegative = 0.0
    heating_standard_errors: Errors = []
    cooling_standard_errors: Errors = []
    warnings: list[str] = []
    wire: dict[str, str | Finite] = {}
    created_by: str = ""
    source: str = ""
    heating_samples: Samples = []
    cooling_samples: Samples = []
    slow_loop: Rows = []
    home: HomeMove | None = None
    gains: dict[str, str | Finite | Levels] = {}
    no_gains: str = ""
    measured_stroke: NotNegative = 0.0
    holds: bool = True
    does_not_hold: str = ""
    wire_model: WireModel | None = None
    checksum: str = ""

    def checksum_of_numbers(self) -> str:
        """Return the checksum of all that is computed with: every key but texts for the file's reader."""
        # Keys that an older file does not have are not in its checksum, either.
        numbers = self.model_dump(mode="json", exclude=FOR_READERS, exclude_unset=True)
        return hashlib.sha256(json.dumps(numbers, sort_keys=True).encode()).hexdigest()[:16]


# Written for the file's reader; computed, not passed in, when a model is made.
DERIVED = {"format", "version", "order", "unit", "quantity_min", "quantity_max", "holds", "checksum"}


def save_model(model: FittedCurve, path: str | PathLike[str]) -> None:
    """Write the model as JSON, whole or not at all; CallerError if the folder cannot be written."""
    target = Path(path)
    keys = {
        "format": MODEL_FORMAT,
        "version": MODEL_VERSION,
        **{name: _plain(getattr(model, name)) for name in ModelFile.model_fields if name not in NOT_OF_MODEL},
    }
    checked = ModelFile.model_validate_json(json.dumps(keys, allow_nan=False))
    text = json.dumps(keys | {"checksum": checked.checksum_of_numbers()}, indent=1, allow_nan=False) + "\n"
    if len(text) > MAX_BYTES:
        raise CallerError(f"model file {target} would take {len(text)} bytes: shorten the wire notes")
    write_text_whole(target, text)


def read_fields(path: str | PathLike[str]) -> dict[str, Any]:
    """Return the fields of the model in a file; CallerError in one line if it is missing, damaged or inconsistent."""
    source = Path(path)
    document = _document(source)
    unknown = sorted(set(document) - set(ModelFile.model_fields))
    if unknown:
        hint = nearest_hint(unknown[0], ModelFile.model_fields)
        raise CallerError(f"model file {source}: unknown key {unknown[0]!r}{hint}")
    try:
        # Through JSON again: strict validation accepts a JSON list as a pair, but no Python list.
        contents = ModelFile.model_validate_json(json.dumps(document))
    except ValidationError as error:
        raise CallerError(f"model file {source}: {_first(error)}") from error
    try:
        fields = _fields(contents)
        _check_derived(FittedCurve(**fields), contents)
        if contents.version == FIRST_VERSION:
            fields["wire_model"] = found = with_wire_model(FittedCurve(**fields)).wire_model
            fields["converted"] = f"{source} is of version {FIRST_VERSION}: {NO_WIRE if found is None else ITS_WIRE}"
    except CallerError as error:
        raise CallerError(f"model file {source}: {error}") from error
    return fields


def _document(source: Path) -> dict[str, Any]:
    """Return the JSON object in the file, after checks of size, format and version."""
    try:
        document = json_of(read_small(source, "model file"), f"{source} is not a model file")
    except CallerError as error:
        if source.suffix.lower() == ".json":
            raise
        made = f"'musclewire fit {source} -o model.json' makes one"
        is_one = f"{source} is a recording, where a model file (.json) belongs: {made}"
        raise CallerError(is_one if _is_recording(source) else f"{error}; a model file ends in .json") from None
    if not isinstance(document, dict) or document.get("format") != MODEL_FORMAT:
        raise CallerError(f'{source} is not a model file: it lacks "format": "{MODEL_FORMAT}"')
    version = document.get("version")
    if not isinstance(version, int) or isinstance(version, bool) or not FIRST_VERSION <= version <= MODEL_VERSION:
        raise CallerError(
            f"model file {source} has version {version!r} and this musclewire reads up to {MODEL_VERSION}: "
            "update musclewire or fit again"
        )
    return document


def _is_recording(source: Path) -> bool:
    """Return whether a file has columns of a recording, whatever it lacks."""
    # Here, because what reads files of others takes long to load, and most loops have a model.
    from musclewire.files import ImportMapping, import_plan

    try:
        return bool(import_plan(source, ImportMapping()).match.taken)
    except MusclewireError:
        return False


def _plain(value: Any) -> Any:
    """Return tuples and mappings as JSON writes them, and numbers of any library as Python's own."""
    if isinstance(value, HomeMove | WireModel | WireNumber):
        return {name: _plain(one) for name, one in vars(value).items()}
    if isinstance(value, tuple | list):
        return [_plain(item) for item in value]
    if hasattr(value, "items"):
        return {str(key): _note(_plain(item)) for key, item in value.items()}
    return value.item() if hasattr(value, "item") else value


def _note(value: Any) -> str | float | list[Any]:
    """Return a note on the wire, or one of the gains, as text, finite number or list; anything else as its text."""
    if isinstance(value, list) or (isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)):
        return value
    return str(value)


def _fields(contents: ModelFile) -> dict[str, Any]:
    """Return the fields of a model from the keys of its file."""
    fields = {name: value for name, value in contents.model_dump().items() if name not in DERIVED}
    fields["wire_model"] = contents.wire_model
    found = {name: tuple(value) if isinstance(value, list) else value for name, value in fields.items()}
    gains = {name: tuple(value) if isinstance(value, list) else value for name, value in contents.gains.items()}
    return found | {"home": contents.home, "gains": gains}


def _check_derived(model: FittedCurve, contents: ModelFile) -> None:
    """Raise CallerError unless order, unit, ranges and errors in the file agree with its polynomials."""
    if (contents.order, contents.unit) != (model.order, model.unit):
        raise CallerError(
            f"order {contents.order} and unit {contents.unit!r} disagree with {model.order + 1} coefficients "
            f"of {model.quantity} in {model.unit!r}: the file was altered, use another copy"
        )
    if contents.holds != model.holds:
        raise CallerError("holds contradicts does_not_hold: the file was altered, use another copy or fit again")
    allowed = RANGE_AGREEMENT * (model.quantity_max - model.quantity_min)
    for name in ("quantity_min", "quantity_max"):
        written, computed = getattr(contents, name), getattr(model, name)
        if abs(written - computed) > allowed:
            raise CallerError(
                f"{name} is {written:.6g} and its polynomials give {computed:.6g}: the file was altered, use another "
                "copy"
            )
    for errors in (contents.heating_standard_errors, contents.cooling_standard_errors):
        if errors and len(errors) != model.order + 1:
            raise CallerError(
                f"{len(errors)} standard errors for {model.order + 1} coefficients: the file was altered, use another "
                "copy"
            )
    if contents.checksum and contents.checksum != contents.checksum_of_numbers():
        raise CallerError(
            "its numbers are not those that were written: the file was altered, use another copy or fit again"
        )


def _first(error: ValidationError) -> str:
    """Return the first error of pydantic, in one line."""
    fault = error.errors(include_url=False, include_input=False)[0]
    where = ".".join(str(part) for part in fault["loc"])
    if fault["type"] == "missing":
        return f"key {where!r} is missing"
    message = " ".join(fault["msg"].removeprefix("Value error, ").split())
    return f"{where}: {message[:160]}"
