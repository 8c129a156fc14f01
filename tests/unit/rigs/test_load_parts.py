"""The parts of a rig file: what they take, what fits together, and a mistake answered in one line."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from musclewire.errors import CallerError
from musclewire.parameters import validated
from musclewire.rigs import RigConfiguration, open_rig

PRETENSIONER = {"part": "pretensioner", "stiffness": "386.2 N/m"}
FINGER = {"part": "finger", "finger": "lan-fan-2010"}
CONTACT = {"part": "contact", "stiffness": "200 N/m", "clearance": "2 mm"}


def configuration(*parts: Any, **keys: Any) -> RigConfiguration:
    return validated(RigConfiguration, {"load": list(parts), **keys}, "rig file my_rig.toml")


def opened(*parts: Any, **keys: Any) -> None:
    open_rig(configuration(*parts, **keys))


def refusal(*parts: Any, ask: Callable[..., Any] = configuration, **keys: Any) -> str:
    with pytest.raises(CallerError) as caught:
        ask(*parts, **keys)
    return str(caught.value)


def test_a_number_is_in_si_or_carries_its_unit() -> None:
    text = configuration({"part": "spring", "stiffness": "0.5886 N/mm", "slack": "300 um"}).load[0]
    numbers = configuration({"part": "spring", "stiffness": 588.6, "slack": 3e-4}).load[0]
    assert text.stiffness == pytest.approx(numbers.stiffness)  # type: ignore[attr-defined]
    assert text.slack == pytest.approx(numbers.slack)  # type: ignore[attr-defined]
    assert configuration({"part": "weight", "force": "50 gf"}).load[0].force == pytest.approx(0.4903325)  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("part", "hint"),
    [
        ({**FINGER, "slak": "1 mm"}, "unknown key 'load.1.finger.slak'; did you mean 'slack'?"),
        ({"part": "fingr"}, "load.1: there is no part 'fingr'; did you mean 'finger'?"),
        ({"stiffness": 3.0}, "the key 'load.1.part' is missing"),
        ({"part": "spring"}, "the key 'load.1.spring.stiffness' is missing"),
        ({"part": "spring", "stiffness": "3 mm"}, "'3 mm': mm is a length; a stiffness is needed"),
        ({"part": "spring", "stiffness": 0.0}, "load.1.spring.stiffness: must be above 0 N/m, not 0"),
        ({"part": "weight", "force": [1.0]}, "load.1.weight.force: must be a number, not a list"),
    ],
)
def test_a_mistake_in_a_part_is_one_line_that_names_place_key_and_nearest(part: dict[str, Any], hint: str) -> None:
    message = refusal(PRETENSIONER, part)
    assert message.startswith("rig file my_rig.toml: ")
    assert hint in message


@pytest.mark.parametrize(
    ("parts", "reason"),
    [
        ([CONTACT, CONTACT], "there are 2 parts 'contact', 1 fits"),
        ([FINGER, FINGER], "there are 2 parts 'finger', 1 fits"),
    ],
)
def test_parts_that_do_not_fit_together_are_refused_with_the_reason(parts: list[dict[str, Any]], reason: str) -> None:
    assert reason in refusal(*parts)


def test_several_springs_and_weights_add_up() -> None:
    parts = [{"part": "spring", "stiffness": 100.0}, PRETENSIONER, {"part": "weight", "force": 0.2}]
    settings = {"pretension_n": 0.9}
    facts = open_rig(configuration(*parts, {"part": "weight", "force": 0.3}, settings=settings)).metadata()
    assert facts["spring_stiffness_n_per_m"] == pytest.approx(486.2)
    assert facts["pretension_n"] == pytest.approx(0.9 + 0.5)
    assert facts["load"] == "spring, pretensioner, weight, weight"


@pytest.mark.parametrize(
    ("part", "setting", "reason"),
    [
        (PRETENSIONER, "spring_stiffness_n_per_m", "give a part 'spring' with a stiffness"),
        ({"part": "weight", "force": "1.5 N"}, "pretension_n", "the part 'weight' is the pretension"),
    ],
)
def test_a_setting_that_the_load_leaves_without_effect_is_refused(
    part: dict[str, Any], setting: str, reason: str
) -> None:
    assert reason in refusal(part, ask=opened, settings={setting: 1.0})


@pytest.mark.parametrize(
    ("parts", "reason"),
    [
        ([{**FINGER, "finger": "lan-fan-2011"}], "no finger called 'lan-fan-2011'; did you mean 'lan-fan-2010'?"),
        ([{**FINGER, "finger": "nowhere.toml"}], "there is no finger file nowhere.toml"),
        ([{"part": "weight", "force": "40 N"}], "35.4 N more than the 4.601 N it allows"),
    ],
)
def test_what_only_opening_the_rig_can_tell_is_refused_as_well(parts: list[dict[str, Any]], reason: str) -> None:
    assert reason in refusal(*parts, ask=opened)
