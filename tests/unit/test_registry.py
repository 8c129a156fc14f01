"""Kinds by name: our own, registered ones, and what is refused."""

from __future__ import annotations

from typing import Any

import pytest

import musclewire as mw
from musclewire.errors import CallerError
from musclewire.registry import Registry
from musclewire.signals import check_columns


def registry() -> Registry[object]:
    """Return a registry with one kind of our own, which is any importable attribute."""
    return Registry("estimator", "test_kinds", {"pi": "math:pi"})


def test_a_kind_of_our_own_is_imported_when_it_is_asked_for() -> None:
    assert registry().find("pi") == pytest.approx(3.14159, abs=1e-5)


def test_a_registered_kind_is_known_by_name() -> None:
    kinds = registry()
    kinds.register("mine", test_a_registered_kind_is_known_by_name)
    assert kinds.find("mine") is test_a_registered_kind_is_known_by_name
    assert kinds.names() == ("pi", "mine")


def test_registering_the_same_kind_twice_changes_nothing_and_another_is_refused() -> None:
    kinds = registry()
    kinds.register("mine", 1)
    with pytest.raises(CallerError, match="already an estimator named 'mine'"):
        kinds.register("mine", 2)
    with pytest.raises(CallerError, match="'pi'"):
        kinds.register("pi", 2)


def test_an_unknown_name_is_told_the_nearest() -> None:
    kinds = registry()
    kinds.register("polynomial", 1)
    with pytest.raises(CallerError, match="polynomial"):
        kinds.find("polynomal")


class Complete:
    """What a kind makes, with all that is needed of it."""

    columns = ()

    def __init__(self, setup: str) -> None:
        self.setup = setup

    def step(self) -> None:
        """Do nothing."""


class WithoutColumns:
    """The same, one part forgotten."""

    def __init__(self, _setup: str) -> None:
        """Take a setup."""

    def step(self) -> None:
        """Do nothing."""


def test_what_a_kind_makes_is_checked_when_it_is_made() -> None:
    kinds: Registry[Any] = Registry("estimator", "nothing", {}, parts=("columns", "step"))
    kinds.register("complete", Complete)
    assert kinds.make("complete", "a setup").setup == kinds["complete"]("a setup").setup
    assert "complete" in kinds
    with pytest.raises(
        CallerError, match="WithoutColumns is no estimator: it has no columns; an estimator has columns"
    ):
        kinds.make(WithoutColumns, "a setup")


def test_what_makes_nothing_is_not_registered() -> None:
    kinds: Registry[Any] = Registry("controller", "nothing", {}, parts=("step",))
    with pytest.raises(CallerError, match="by its class or by a function that makes one, not by an int"):
        kinds.register("bad", 3)


def test_a_registry_shows_its_names() -> None:
    assert repr(mw.CONTROLLERS) == f"controllers: {', '.join(mw.CONTROLLERS.names())}"


class Misnamed:
    """An estimator whose column no recording can have."""

    columns = ("Play Place",)


def misnamed(_setup: object) -> Misnamed:
    return Misnamed()


def unsaid(_setup: object):  # type: ignore[no-untyped-def]
    return Misnamed()


def unresolved(_setup: object) -> "NotThere":  # type: ignore[name-defined]  # noqa: F821, UP037
    return Misnamed()


@pytest.mark.parametrize("kind", [Misnamed, misnamed])
def test_registering_an_estimator_looks_at_the_columns_of_its_class(kind: Any) -> None:
    with pytest.raises(CallerError, match="the estimator 'mine' records 'Play Place': a column is named by words in"):
        mw.ESTIMATORS.register("mine", kind)
    assert "mine" not in mw.ESTIMATORS


@pytest.mark.parametrize("kind", [unsaid, unresolved])
def test_columns_that_no_class_says_are_looked_at_when_the_estimator_is_made(kind: Any) -> None:
    kinds: Registry[Any] = Registry("estimator", "nothing", {}, check=check_columns)
    kinds.register("mine", kind)
    with pytest.raises(CallerError, match="the estimator Misnamed records 'Play Place'"):
        kinds.make("mine", None)
