"""The parts of a rig file: what they take, what fits together, and a mistake answered in one line."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from musclewire.errors import CallerError
from musclewire.parameters import validated
from musclewire.rigs._configuration import RigConfiguration, open_rig

PRETENSIONER = {"part": "pretensioner", "stiffness": "386.2 N/m"}
FINGER = {"part": "finger", "finger": "lan-fan-2010"}
CONTACT = {"part": "contact", "stiffness": "200 N/m", "clearance": "2 mm"}


def configuration(*parts: Any, **keys: Any) -> RigConfiguration:
    return validated(RigConfiguration, {"load": list(parts), **keys}, "rig file my_rig.toml")


def opened(*parts: Any) -> None:
    open_rig(configuration(*parts))


def refusal(*parts: Any, ask: Callable[..., Any] = configuration, **keys: Any) -> str:
    with pytest.raises(CallerError) as caught:
        ask(*parts, **keys)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_number_is_in_si_or_carries_its_unit() -> None:
    text = configuration({"part": "spring", "stiffness": "0.5886 N/mm", "slack": "300 um"}).load[0]
    numbers = configuration({"part": "spring", "stiffness": 588.6, "slack": 3e-4}).load[0]
    assert text.stiffness == pytest.approx(numbers.stiffness)  # type: ignore[attr-defined]
    assert text.slack == pytest.approx(numbers.slack)  # type: ignore[attr-defined]
    assert configuration({"part": "weight", "force": "50 gf"}).load[0].force == pytest.approx(0.4903325)  # type: ignore[attr-defined]
    assert configuration({"part": "antagonist", "voltage": "900 mV"}).load[0].voltage == pytest.approx(0.9)  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("part", "hint"),
    [
        ({**FINGER, "slak": "1 mm"}, "unknown key 'load.0.finger.slak'; did you mean 'slack'?"),
        ({**PRETENSIONER, "stifness": 3.0}, "unknown key 'load.0.pretensioner.stifness'; did you mean 'stiffness'?"),
        ({**CONTACT, "clearence": 0.0}, "unknown key 'load.0.contact.clearence'; did you mean 'clearance'?"),
        ({"part": "parallel wire", "wyre": "x"}, "unknown key 'load.0.parallel wire.wyre'; did you mean 'wire'?"),
        ({**PRETENSIONER, "slack": 0.001}, "unknown key 'load.0.pretensioner.slack'"),
        ({"part": "fingr"}, "load.0: there is no part 'fingr'; did you mean 'finger'?"),
        ({"stiffness": 3.0}, "the key 'load.0.part' is missing"),
        ({"part": "spring"}, "the key 'load.0.spring.stiffness' is missing"),
        ({"part": "spring", "stiffness": "3 mm"}, "'3 mm': mm is a length; a stiffness is needed"),
        ({"part": "spring", "stiffness": 0.0}, "load.0.spring.stiffness: must be above 0 N/m, not 0"),
        ({"part": "spring", "stiffness": float("inf")}, "load.0.spring.stiffness"),
        ({**CONTACT, "clearance": -1e-3}, "load.0.contact.clearance: must be 0 m or more, not -0.001"),
        ({"part": "weight", "force": float("nan")}, "load.0.weight.force: must be above 0 N, not nan"),
        ({"part": "weight", "force": [1.0]}, "load.0.weight.force: must be a number, not a list"),
        ({"part": "finger", "finger": 3}, "load.0.finger.finger: must be text in quotes, not 3"),
    ],
)
def test_a_mistake_in_a_part_is_one_line_that_names_key_and_nearest(part: dict[str, Any], hint: str) -> None:
    message = refusal(part)
    assert message.startswith("rig file my_rig.toml: ")
    assert hint in message


def test_the_place_of_a_mistake_counts_the_parts_from_the_first() -> None:
    assert "'load.1.finger.slak'" in refusal(PRETENSIONER, {**FINGER, "slak": 0.0})


@pytest.mark.parametrize(
    ("parts", "reason"),
    [
        ([PRETENSIONER, FINGER, FINGER], "there are 2 parts 'finger', 1 fits"),
        ([CONTACT, CONTACT], "there are 2 parts 'contact', 1 fits"),
        ([{"part": "antagonist"}, {"part": "parallel wire"}], "room for one second wire"),
        ([{"part": "second finger"}], "a second finger needs a part 'finger'"),
        ([PRETENSIONER, FINGER, {"part": "second finger"}], "a 'contact' between them"),
        ([CONTACT, {"part": "antagonist"}], "not simulated: leave one out"),
        ([PRETENSIONER, CONTACT, {"part": "parallel wire"}], "not simulated: leave one out"),
    ],
)
def test_parts_that_do_not_fit_together_are_refused_with_the_reason(parts: list[dict[str, Any]], reason: str) -> None:
    assert reason in refusal(*parts)


def test_several_springs_and_weights_add_up() -> None:
    parts = [{"part": "spring", "stiffness": 100.0}, PRETENSIONER, {"part": "weight", "force": 0.2}]
    facts = open_rig(configuration(*parts, {"part": "weight", "force": 0.3}, bench="finger")).metadata()
    assert facts["spring_stiffness_n_per_m"] == pytest.approx(486.2)
    assert facts["pretension_n"] == pytest.approx(0.71 + 0.5)
    assert facts["load"] == "spring, pretensioner, weight, weight"


@pytest.mark.parametrize(
    ("parts", "reason"),
    [
        ([{**FINGER, "finger": "lan-fan-2011"}], "no finger called 'lan-fan-2011'; did you mean 'lan-fan-2010'?"),
        ([{**FINGER, "finger": "nowhere.toml"}], "there is no finger file nowhere.toml"),
        ([{"part": "antagonist", "wire": "paper-100"}], "no wire called 'paper-100'; did you mean 'paper-100um'?"),
        ([{"part": "antagonist", "voltage": "40 V"}], "40 V is above the 3.6 V that wire paper-100um allows"),
        ([{"part": "weight", "force": "40 N"}], "35.4 N more than the 4.601 N it allows"),
    ],
)
def test_what_only_opening_the_rig_can_tell_is_refused_as_well(parts: list[dict[str, Any]], reason: str) -> None:
    assert reason in refusal(*parts, ask=opened)


@pytest.mark.parametrize(
    ("air", "hint"),
    [
        ({"ambient_swng": "2 K"}, "unknown key 'surroundings.ambient_swng'; did you mean 'ambient_swing'?"),
        ({"ambient_swing": "3 degC"}, "a difference of temperatures is needed, like '3 K'"),
        ({"ambient_swing": "30 K"}, "surroundings.ambient_swing: must be 20 K or less"),
        ({"ambient_period": "2 m"}, "m is a length; a time is needed"),
        ({"ambient_period": 0.0}, "surroundings.ambient_period: must be above 0 s, not 0"),
        ({"draught": 0.5}, "surroundings.draught: must be 0.25 or less, not 0.5"),
    ],
)
def test_a_mistake_about_the_air_is_one_line_too(air: dict[str, Any], hint: str) -> None:
    assert hint in refusal(surroundings=air)
