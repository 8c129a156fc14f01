"""Turn pydantic's report on a file into one line that a person can act on."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import UnionType
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError

from musclewire.errors import CallerError, nearest_hint

__all__ = ["first_problem", "validated"]

Model = TypeVar("Model", bound=BaseModel)


def validated(model: type[Model], data: Any, where: str) -> Model:
    """Return ``data`` as ``model``; CallerError naming the first wrong key, and the nearest right one."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise CallerError(f"{where}: {first_problem(error, model)}") from None


def first_problem(error: ValidationError, model: type[BaseModel]) -> str:
    """Return the first problem of a validation as one line."""
    problems = error.errors(include_url=False)
    # A misspelt key is both unknown and missing; only the first way to say it names the spelling.
    problem = next((found for found in problems if found["type"] == "extra_forbidden"), problems[0])
    place = ".".join(str(part) for part in problem["loc"])
    if problem["type"] == "extra_forbidden":
        return f"unknown key '{place}'{nearest_hint(str(problem['loc'][-1]), known_keys(model, problem['loc']))}"
    if problem["type"] in ("union_tag_invalid", "union_tag_not_found"):
        return tag_problem(place, {name: str(text) for name, text in problem["ctx"].items()})
    message = str(problem["msg"]).removeprefix("Value error, ").replace("\n", " ")
    if problem["type"] == "missing":
        return f"the key '{place}' is missing"
    return f"{place}: {message}" if place else message


def tag_problem(place: str, context: Mapping[str, str]) -> str:
    """Return what is wrong with the key that tells which model of a union is meant."""
    key = context["discriminator"].strip("'")
    if "tag" not in context:
        return f"the key '{place}.{key}' is missing"
    known = [name.strip(" '") for name in context["expected_tags"].split(",")]
    return f"{place}: there is no {key} '{context['tag']}'{nearest_hint(context['tag'], known)}"


def known_keys(model: type[BaseModel], place: Iterable[Any]) -> list[str]:
    """Return the keys allowed where the wrong one stands, following nested models as far as they go."""
    current: type[BaseModel] = model
    parts = iter(list(place)[:-1])
    for part in parts:
        field = current.model_fields.get(str(part))
        annotation = field.annotation if field else None
        if get_origin(annotation) in (dict, list):
            annotation = get_args(annotation)[-1]
            next(parts, None)  # the key of the dictionary, which may be any, or the place in the list
        if get_origin(annotation) is Annotated:
            annotation = get_args(annotation)[0]
        if get_origin(annotation) in (Union, UnionType):
            annotation = tagged(get_args(annotation), str(next(parts, "")))
        if not (isinstance(annotation, type) and issubclass(annotation, BaseModel)):
            break
        current = annotation
    return list(current.model_fields)


def tagged(models: Iterable[Any], tag: str) -> Any:
    """Return the model of a tagged union that has this tag as one of its literal texts."""
    for model in models:
        literals = (get_args(field.annotation) for field in model.model_fields.values())
        if any(tag in values for values in literals):
            return model
    return None
