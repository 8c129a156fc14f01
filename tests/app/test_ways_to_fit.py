"""A way to fit that a part offers by its manifest: its options are those of ``fit``, what it says is in the answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any

import pytest
import typer

import musclewire as mw
from musclewire.manifest import Manifest, manifests
from musclewire.signals import Recording


@dataclass(frozen=True)
class ByGuess:
    """Takes the motion of the recording, and says that its stroke may be off by a tenth."""

    guess: Annotated[str | None, typer.Option("--guess")] = None

    def asked_for(self, *, relative_resistance: bool) -> bool:
        return self.guess is not None and not relative_resistance

    def fit(self, recording: Recording, order: int | str, quantity: str) -> Any:
        model = mw.fit(recording, order=order, quantity=quantity)
        return SimpleNamespace(model=model, stroke=0.04, stroke_std=0.004, misfit=float(self.guess or 0.0))


@pytest.fixture
def loop(tmp_path: Path) -> Path:
    with mw.open_rig("simulated") as rig:
        mw.characterize(rig, cycles=1, period_s=20.0, path=tmp_path / "loop.h5")
    return tmp_path / "loop.h5"


def test_a_part_adds_a_way_to_fit_with_options_of_its_own(
    loop: Path, musclewire: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    parts = (*manifests(), Manifest("own", fits={"by guess": f"{__name__}:ByGuess"}))
    monkeypatch.setattr("musclewire.manifest.manifests", lambda: parts)
    guessed = musclewire("fit", loop, "--guess", "3", "--json").json
    assert guessed["misfit"] == 3.0
    assert guessed["stroke_std_pct"] == pytest.approx(10.0)
    assert "misfit" not in musclewire("fit", loop, "--json").json


def test_an_option_of_a_part_that_is_not_there_is_answered_by_the_part(
    musclewire: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    others = tuple(one for one in manifests() if one.name != "calibration")
    monkeypatch.setattr("musclewire.manifest.manifests", lambda: others)
    answer = musclewire("fit", "loop.h5", "--wire", "flexinol-0.10-lt")
    assert answer.code == 2
    assert "'fit --wire' belongs to the part 'calibration'" in answer.err
