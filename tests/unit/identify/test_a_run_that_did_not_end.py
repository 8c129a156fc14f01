"""A model of a recording that was cut short says so, and so does the refusal where nothing can be fitted."""

from __future__ import annotations

import pytest

import musclewire as mw
from musclewire.errors import RecordingError
from musclewire.signals import Recording


@pytest.fixture(scope="module")
def loop() -> Recording:
    with mw.open_rig("simulated", seed=4) as rig:
        return mw.characterize(rig, period_s=30.0)


def cut_short(loop: Recording, rows: int) -> Recording:
    columns = {name: loop[name][:rows] for name in loop.names}
    return Recording(columns, {**loop.metadata, "ended": "RigError: command_missing"})


def test_a_model_of_it_and_a_refusal_of_it_say_so_and_a_finished_one_does_not(loop: Recording) -> None:
    said = "this recording is cut off: its run ended with 'RigError: command_missing'"
    assert any(said in text for text in mw.fit(cut_short(loop, len(loop))).warnings)
    assert said in mw.estimate(mw.fit(loop), cut_short(loop, len(loop))).warnings
    assert not [text for text in mw.fit(loop).warnings if "cut off" in text]
    with pytest.raises(RecordingError, match=said):
        mw.fit(cut_short(loop, 60))
