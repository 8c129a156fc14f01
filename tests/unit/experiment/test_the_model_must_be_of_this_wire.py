"""A model is refused on another wire, on the same wire of another length, and on another finger."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from musclewire.errors import CallerError
from musclewire.experiment._closed_loop import control
from musclewire.experiment._open_loop import characterize
from musclewire.identify import fit
from musclewire.rigs import open_rig
from musclewire.sensing import SensingModel


@cache
def finger_model(quantity: str) -> SensingModel:
    with open_rig("finger") as rig:
        return fit(characterize(rig, cycles=1), quantity=quantity)


def test_another_wire_is_refused() -> None:
    with open_rig("finger", wire="paper-100um") as rig, pytest.raises(CallerError, match=r"finger-100um.*paper-100um"):
        control(rig, finger_model("displacement"))


@pytest.mark.parametrize("quantity", ["strain", "displacement"])
def test_another_length_of_the_same_wire_is_refused_before_anything_is_heated(quantity: str) -> None:
    with open_rig("finger", wire_length_m=0.08) as rig:
        with pytest.raises(CallerError, match="fitted to a wire of 70 mm, the rig has one of 80 mm"):
            control(rig, finger_model(quantity))
        assert rig.drive_voltage_v == 0.0


def test_another_finger_is_refused_for_its_displacement() -> None:
    model = finger_model("displacement")
    other = replace(model, wire={**model.wire, "finger": "another"})
    with open_rig("finger") as rig, pytest.raises(CallerError, match=r"finger another, the rig has lan-fan-2010"):
        control(rig, other)
