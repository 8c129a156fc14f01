"""Commands are checked whole before they reach a rig's process."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import CallerError
from musclewire.extras.live._bench.recipes import reference_of
from musclewire.extras.live._messages import Control, DrawnPath, Pulse, SetTarget, Steer, SweepPretension, read_command

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


@pytest.mark.parametrize("pretensions_n", [[1.9], [1.3, 1.9]])
def test_a_sweep_may_have_one_pretension_or_more(pretensions_n: list[float]) -> None:
    swept = read_command({"do": "sweep_pretension", "pretensions_n": pretensions_n})
    assert isinstance(swept, SweepPretension)
    assert swept.pretensions_n == pretensions_n


@pytest.mark.parametrize("duration_s", [4.0, 3600.0, 3600.5])
def test_a_drawn_path_is_followed_for_an_hour_and_one_that_heats_for_longer_is_refused(duration_s: float) -> None:
    path = DrawnPath(kind="path", time_s=[10.0, 10.0 + duration_s], target=[0.0, 0.02])
    model: Any = None  # only steps and steering ask for it
    if duration_s > 3600.0:
        with pytest.raises(CallerError):
            reference_of(path, model, 0.5)
        return
    reference = reference_of(path, model, 0.5)
    assert reference.duration_s == pytest.approx(duration_s, abs=0.5)
    assert [reference.target_at(share * duration_s) for share in (0.0, 0.5)] == pytest.approx([0.0, 0.01], abs=1e-4)


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
