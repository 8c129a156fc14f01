"""A user's TOML file is read and checked, with errors in one line; a table's key may name its registered kind."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from math import inf, isfinite
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, NamedTuple, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, InitErrorDetails, PydanticCustomError, PydanticKnownError, core_schema

from musclewire.errors import CallerError, Message, nearest_hint
from musclewire.manifest import absent_part
from musclewire.registry import Registry
from musclewire.small_files import read_toml


@dataclass(frozen=True)
class TaggedTable:
    """Annotation of a field that holds a table: one key names its kind, whose schema checks it.

    Unlike a union of schemas it accepts kinds that were registered later, by a call or by another package.
    """

    registry: Registry[Any]  # schemas by name; each has the key as a literal of that name
    key: str

    def __get_pydantic_core_schema__(self, _source: Any, _handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return a schema by which pydantic calls :meth:`checked`."""
        return core_schema.no_info_plain_validator_function(self.checked)

    def model_of(self, tag: str) -> type[BaseModel] | None:
        """Return the schema of a kind, or None if there is none of that name."""
        try:
            found: type[BaseModel] = self.registry.find(tag)
        except CallerError:
            return None
        return found

    def checked(self, given: Any) -> BaseModel:
        """Return a table as its kind; the location of an error includes the kind's name, as with a union."""
        if isinstance(given, BaseModel):
            return given
        if not isinstance(given, dict):
            raise PydanticKnownError("model_attributes_type")
        if self.key not in given:
            raise PydanticKnownError("union_tag_not_found", {"discriminator": f"'{self.key}'"})
        tag = given[self.key]
        model = self.model_of(tag) if isinstance(tag, str) else None
        if model is None:
            if (absent := absent_part(self.registry.field, str(tag))) is not None:
                raise PydanticCustomError("absent_part", "{error}", {"error": str(absent)})
            names = ", ".join(f"'{name}'" for name in self.registry.names())
            raise PydanticKnownError(
                "union_tag_invalid", {"discriminator": f"'{self.key}'", "tag": str(tag), "expected_tags": names}
            )
        try:
            return model.model_validate(given)
        except ValidationError as error:
            raise ValidationError.from_exception_data(
                error.title, [with_kind_in_location(tag, item) for item in error.errors(include_url=False)]
            ) from None


def with_kind_in_location(tag: str, problem: Any) -> InitErrorDetails:
    """Return an error with the kind's name at the head of its location."""
    kind: Any = problem["type"]
    return InitErrorDetails(
        type=kind, loc=(tag, *problem["loc"]), input=problem["input"], ctx=dict(problem.get("ctx", {}))
    )


Model = TypeVar("Model", bound=BaseModel)
DATA = Path(str(files("musclewire.parameters"))) / "data"

# Messages by pydantic's name of the error; braces are filled from the violated rule, u is the unit.
IN_WORDS = {
    "greater_than": "must be above {gt:g}{u}",
    "greater_than_equal": "must be {ge:g}{u} or more",
    "less_than": "must be below {lt:g}{u}",
    "less_than_equal": "must be {le:g}{u} or less",
    "finite_number": "must be a finite number",
    "float_type": "must be a number",
    "float_parsing": "must be a number",
    "int_type": "must be a whole number",
    "int_parsing": "must be a whole number",
    "int_from_float": "must be a whole number, as {near}",
    "bool_type": "must be true or false",
    "bool_parsing": "must be true or false",
    "string_type": "must be text in quotes",
    "string_too_short": "must be text of at least {min_length} characters",
    "literal_error": "must be {expected}",
    "too_short": "must have at least {min_length} entries",
    "too_long": "must have at most {max_length} entries",
    "tuple_type": "must be a list of numbers",
    "dict_type": "must be a table, [{key}] in TOML",
}
# Names of the tables in a list, by the key that names their kind; other tables have the name of the list.
NAMES_OF_TABLES = {"part": "part"}
TABLE_EXPECTED = ("model_type", "model_attributes_type")


class KeyPlace(NamedTuple):
    """Location of a problem: the model that has the key, and the key's field if the model declares it."""

    model: type[BaseModel]
    field: FieldInfo | None


def shipped_names(folder: str) -> list[str]:
    """Return the names of the files in a folder of the data that ship with musclewire."""
    return sorted(item.stem for item in (DATA / folder).glob("*.toml"))


def load_named(model: type[Model], folder: str, what: str, name: str) -> Model:
    """Return a file that ships with musclewire, by name, or a user's (.toml), which is read at every call."""
    if name.endswith(".toml"):
        return validated(model, read_toml(Path(name), f"{what} file"), f"{what} file {name}")
    if name not in shipped_names(folder):
        raise CallerError(f"there is no {what} called '{name}'{nearest_hint(name, shipped_names(folder))}")
    found: Model = shipped(model, folder, what, name)
    return found


@cache
def shipped(model: type[Model], folder: str, what: str, name: str) -> Model:
    """Return a file that ships with musclewire, checked."""
    return validated(model, read_toml(DATA / folder / f"{name}.toml", f"{what} file"), f"{what} {name}")


class CheckedFile(BaseModel):
    """Refuses unknown keys and wrong values by a CallerError in one line, whether a file has them or a program."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    def __init__(self, **values: Any) -> None:
        """Check and keep the values. Raises CallerError that names the first wrong key in one line."""
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise CallerError(first_problem(error, type(self))) from None


def validated(model: type[Model], data: Any, where: str) -> Model:
    """Return ``data`` as ``model``. Raises CallerError that names the first wrong key and the nearest valid one."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise CallerError(f"{where}: " + first_problem(error, model)) from None


def first_problem(error: ValidationError, model: type[BaseModel]) -> str:
    """Return the first problem of a validation as one line, whatever line breaks its keys and values have."""
    problem = problem_of(error, model)
    return problem if isinstance(problem, Message) else " ".join(problem.splitlines())


def problem_of(error: ValidationError, model: type[BaseModel]) -> str:
    """Return the first problem of a validation."""
    problems = error.errors(include_url=False)
    # A misspelt key is both unknown and missing; only the first of the two errors shows the spelling.
    problem = next((found for found in problems if found["type"] == "extra_forbidden"), problems[0])
    place = ".".join(str(part) for part in problem["loc"])
    if problem["type"] == "extra_forbidden":
        known = place_of(model, problem["loc"]).model.model_fields
        return f"unknown key '{place}'{nearest_hint(str(problem['loc'][-1]), known)}"
    if problem["type"] in ("union_tag_invalid", "union_tag_not_found"):
        return tag_problem(place, {name: str(text) for name, text in problem["ctx"].items()})
    if problem["type"] == "missing":
        return f"the key '{place}' is missing"
    siblings = {other["type"] for other in problems if other["loc"][:-1] == problem["loc"][:-1]}
    if {"float_type", "string_type"} <= siblings:  # one key that takes either, refused as both
        key = place.rpartition(".")[0]
        return f"{key}: must be a number in SI or text with a unit, not {value_in_words(problem['input'])}"
    # The error that a check of ours raised, or what pydantic says.
    said = str(problem.get("ctx", {}).get("error", "")) or str(problem["msg"])
    message = in_words(dict(problem), model) or said
    return f"{place}: " + message if place else message


def in_words(problem: Mapping[str, Any], model: type[BaseModel]) -> str | None:
    """Return a message for one of pydantic's errors, a wrong value, with its key's unit; None for others."""
    key = str(problem["loc"][-1]) if problem["loc"] else ""
    field = place_of(model, problem["loc"]).field
    if problem["type"] in TABLE_EXPECTED:
        return f"must be a table{keys_hint(field)}, not {value_in_words(problem['input'])}"
    if problem["type"] == "list_type":
        return f"must be a list{brackets_hint(key, field)}"
    words = IN_WORDS.get(problem["type"])
    if words is None:
        return None
    unit = unit_of(field)
    near = nearest_whole(problem["input"], field)
    said = words.format(key=key, u=f" {unit}" if unit else "", near=near, **problem.get("ctx", {}))
    return f"{said}, not {value_in_words(problem['input'])}"


def nearest_whole(value: Any, field: FieldInfo | None) -> int | None:
    """Return the whole number nearest to a number that is none, as far as the key allows it; None for other values."""
    if not isinstance(value, float) or not isfinite(value):
        return None
    annotated = (item for kind in get_args(field.annotation) for item in get_args(kind)[1:]) if field else ()
    rules = [rule for item in (field, *annotated) if isinstance(item, FieldInfo) for rule in item.metadata]
    low = max((rule.ge for rule in rules if hasattr(rule, "ge")), default=-inf)
    high = min((rule.le for rule in rules if hasattr(rule, "le")), default=inf)
    return int(min(max(round(value), low), high))


def brackets_hint(key: str, field: FieldInfo | None) -> str:
    """Return how a list of tables is written in TOML, "" for a list of anything else."""
    names = key_names(field) if field else []
    each = next((each for name, each in NAMES_OF_TABLES.items() if name in names), "")
    return f": write [[{key}]], with two brackets, before each {each or key}" if names else ""


def value_in_words(value: Any) -> str:
    """Return a value as a message shows it: text in quotes, a table or list by its kind."""
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, (list, tuple)):
        return "a list"
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, str) else f"{value:g}" if isinstance(value, float) else str(value)


def unit_of(field: FieldInfo | None) -> str:
    """Return the unit in which a key is given, "" for a key without unit."""
    said = (getattr(getattr(item, "func", None), "unit", "") for item in (field.metadata if field else ()))
    return next((str(unit) for unit in said if unit), "")


def keys_hint(field: FieldInfo | None) -> str:
    """Return ``" with the keys a, b"`` for a key that holds a table."""
    names = key_names(field) if field else []
    return f" with the keys {', '.join(names)}" if names else ""


def key_names(field: FieldInfo) -> list[str]:
    """Return the keys of the table, or of the first kind of table in a list, that a key holds."""
    annotation = field.annotation
    while get_origin(annotation) is not None:
        annotation = get_args(annotation)[0]
    return list(annotation.model_fields) if isinstance(annotation, type) and issubclass(annotation, BaseModel) else []


def tag_problem(place: str, context: Mapping[str, str]) -> str:
    """Return a message for a wrong key that names the kind of a table."""
    key = context["discriminator"].strip("'")
    if "tag" not in context:
        return f"the key '{place}.{key}' is missing"
    known = [name.strip(" '") for name in context["expected_tags"].split(",")]
    return f"{place}: there is no {key} '{context['tag']}'{nearest_hint(context['tag'], known)}"


def place_of(model: type[BaseModel], place: Iterable[Any]) -> KeyPlace:
    """Return the model that has the last key of a location, following nested models, and the key's field."""
    current: type[BaseModel] = model
    keys = list(place)
    parts = iter(keys[:-1])
    for part in parts:
        field = current.model_fields.get(str(part))
        annotation = field.annotation if field else None
        if get_origin(annotation) in (dict, list):
            annotation = get_args(annotation)[-1]
            next(parts, None)  # the key of the dictionary, which may be any, or the place in the list
        kinds = next((item for item in get_args(annotation)[1:] if isinstance(item, TaggedTable)), None)
        if get_origin(annotation) is Annotated:
            annotation = get_args(annotation)[0]
        if kinds is not None:
            annotation = kinds.model_of(str(next(parts, "")))
        if get_origin(annotation) in (Union, UnionType):
            tables = [item for item in get_args(annotation) if item is not type(None)]
            annotation = tables[0] if len(tables) == 1 else model_with_tag(tables, str(next(parts, "")))
        if not (isinstance(annotation, type) and issubclass(annotation, BaseModel)):
            return KeyPlace(current, None)
        current = annotation
    return KeyPlace(current, current.model_fields.get(str(keys[-1])) if keys else None)


def model_with_tag(models: Iterable[Any], tag: str) -> Any:
    """Return the model of a tagged union that has this tag as one of its literal texts."""
    for model in models:
        if not (isinstance(model, type) and issubclass(model, BaseModel)):
            continue
        literals = (get_args(field.annotation) for field in model.model_fields.values())
        if any(tag in values for values in literals):
            return model
    return None
