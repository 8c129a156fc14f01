"""Kinds of estimators, controllers, devices and load parts by name: our own, and those that others add.

Each registry lists the names of its kinds and where they are defined, and imports a kind only when it is looked up. The
extras add theirs by their manifests, and so does a package from outside; a script adds a kind by one call,
``ESTIMATORS.register("name", factory)``.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from typing import Any, Generic, TypeVar, cast, get_type_hints

from musclewire.errors import CallerError, an_object, nearest_hint
from musclewire.manifest import absent_part, loaded, offered

__all__ = ["REPLACED", "Registry"]

# Names of our own that went, each with what took its place.
REPLACED = {"feedforward": "inverse-model", "gated": "filter"}

Kind = TypeVar("Kind")


class Registry(Generic[Kind]):
    """Kinds of one thing by name: our own, those of manifests, and those registered by a call.

    What a kind makes must have ``parts``; none for kinds that are used as they are. ``check`` gets what a kind has
    made, or its class when it is registered, and whose it is in words; it raises CallerError.
    """

    def __init__(
        self,
        what: str,
        field: str,
        built_in: Mapping[str, str],
        parts: tuple[str, ...] = (),
        check: Callable[[Any, str], None] | None = None,
    ) -> None:
        """Take our own kinds; those of manifests are looked up when a name is needed."""
        self.what, self.field, self._check = what, field, check
        self._built_in, self._parts = dict(built_in), parts
        self._registered: dict[str, Kind] = {}

    def register(self, name: str, kind: Kind) -> None:
        """Add a kind under a name.

        Raises CallerError if another kind has the name, what is registered cannot be called, or the class that it is or
        says it returns names a column that it cannot record.
        """
        if self._parts and not callable(kind):
            raise CallerError(
                f"{self.article()} {self.what} is registered by its class or by a function that makes one, not by "
                f"{an_object(kind)}"
            )
        known = self._registered.get(name)
        if (known is not None and known is not kind) or name in self._places:
            raise CallerError(f"there is already {self.article()} {self.what} named '{name}': give yours another name")
        if self._check is not None:
            self._check(class_made_by(kind), f"the {self.what} '{name}'")
        self._registered[name] = kind

    @property
    def _places(self) -> dict[str, str]:
        """The kinds of the core, then those of the parts that are there: name to place."""
        return {**offered(self.field), **self._built_in}

    def own_names(self) -> tuple[str, ...]:
        """Return the names of musclewire's own kinds, and of those that manifests offer."""
        return tuple(dict.fromkeys([*self._built_in, *self._places]))

    def names(self) -> tuple[str, ...]:
        """Return all known names: our own first, then those of manifests, then registered ones."""
        return tuple(dict.fromkeys([*self.own_names(), *self._registered]))

    def find(self, name: str) -> Kind:
        """Return the kind of a name, imported now if it was not; CallerError names the nearest for an unknown one."""
        if name in self._registered:
            return self._registered[name]
        place = self._places.get(name)
        if place is not None:
            return cast(Kind, loaded(place))
        if (now := REPLACED.get(name)) in self._places:
            raise CallerError(f"the {self.what} '{name}' was replaced by {now}: name that one, or none")
        absent = absent_part(self.field, name)
        raise absent or CallerError(f"there is no {self.what} '{name}'{nearest_hint(name, self.names())}")

    def make(self, kind: str | Kind, setup: Any) -> Any:
        """Return what a kind, or the one of a name, makes of a setup; CallerError if that lacks a part of its kind."""
        made = cast(Any, self.find(kind) if isinstance(kind, str) else kind)(setup)
        missing = [name for name in self._parts if not hasattr(made, name)]
        if missing:
            raise CallerError(
                f"{type(made).__name__} is no {self.what}: it has no {' and no '.join(missing)}; "
                f"{self.article()} {self.what} has {', '.join(self._parts)}"
            )
        if self._check is not None:
            self._check(made, f"the {self.what} {type(made).__name__}")
        return made

    def __repr__(self) -> str:
        """Return the names of the kinds."""
        return f"{self.what}s: {', '.join(self.names())}"

    def __getitem__(self, name: str) -> Kind:
        """Return ``find(name)``."""
        return self.find(name)

    def __contains__(self, name: object) -> bool:
        """Return whether a kind has this name."""
        return name in self.names()

    def article(self) -> str:
        """Return "a" or "an", whichever the word needs."""
        return "an" if self.what[0] in "aeiou" else "a"


def class_made_by(kind: Any) -> Any:
    """Return the class of what a kind makes: itself, or what a function says that it returns; None if it does not."""
    if isinstance(kind, type):
        return kind
    with contextlib.suppress(Exception):  # an annotation may be any expression, of names that are not there
        return get_type_hints(kind).get("return")
    return None
