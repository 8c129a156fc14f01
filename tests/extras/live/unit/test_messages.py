"""Commands are checked whole before they reach a rig's process."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import CallerError
from musclewire.extras.live._messages import Control, Pulse, SetTarget, Steer, read_command

ANY_JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=10), inner, max_size=4),
    max_leaves=12,
)


def test_a_command_keeps_its_numbers() -> None:
    assert read_command({"do": "target", "value": 0.021}) == SetTarget(do="target", value=0.021)
    assert read_command({"do": "pulse"}) == Pulse(do="pulse")
    steered = read_command({"do": "control", "reference": {"kind": "steer"}})
    assert isinstance(steered, Control)
    assert steered.reference == Steer(kind="steer")


@pytest.mark.parametrize(
    ("data", "said"),
    [
        ({"do": "explode"}, "explode"),
        ({"value": 1.0}, "do"),
        ({"do": "target", "value": "0.02"}, "value"),
        ({"do": "target", "value": float("nan")}, "value"),
        ({"do": "target", "value": 0.02, "rig": "bench.toml"}, "rig"),
        ({"do": "switch_on", "kind": "serial"}, "kind"),
        ({"do": "pulse", "duration_s": 1e6}, "duration_s"),
        ({"do": "characterize", "cycles": 0}, "cycles"),
        ({"do": "characterize", "period_s": 1e300}, "period_s"),
        ({"do": "control", "reference": {"kind": "path", "time_s": [], "target": []}}, "time_s"),
        (["do", "stop"], "command"),
        (None, "command"),
    ],
)
def test_a_wrong_command_is_refused_in_one_line(data: Any, said: str) -> None:
    with pytest.raises(CallerError, match=said) as refused:
        read_command(data)
    assert "\n" not in str(refused.value)


@given(ANY_JSON)
def test_whatever_arrives_is_a_command_or_refused(data: Any) -> None:
    try:
        command = read_command(data)
    except CallerError:
        return
    json.dumps(command.model_dump())
