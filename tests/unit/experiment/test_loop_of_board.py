"""Which of a model's loops a board runs shows in its checksum; a board of none of them is refused."""

from __future__ import annotations

from dataclasses import dataclass, replace

import pytest

import musclewire as mw
from musclewire.controllers import FeedforwardSettings, FuzzyPidSettings
from musclewire.errors import CallerError
from musclewire.experiment._on_board import loop_of_board
from musclewire.identify import gains_of, settings_for
from musclewire.sensing import Correction, SensingModel

PERIOD_S = 0.05


@pytest.fixture(scope="module")
def model() -> SensingModel:
    with mw.open_rig("simulated", seed=3) as rig:
        return mw.fit(mw.characterize(rig, minor_loop=False))


@dataclass
class Firmware:
    """A board whose checksum stands for what it was built with."""

    built_with: tuple[str, FuzzyPidSettings | FeedforwardSettings] | None
    board_estimate: float | None = None
    board_resistance_ohm: float | None = None

    @property
    def model_checksum(self) -> int:
        return -1 if self.built_with is None else hash(repr(self.built_with))

    def correct(self, _correction: Correction | None) -> None:
        return None

    def checksum_of(self, model: SensingModel, settings: FuzzyPidSettings | FeedforwardSettings, estimator: str) -> int:
        if estimator == "filter" and not model.slow_loop:
            raise CallerError("the filter needs the slow loop")
        return hash(repr((estimator, settings)))


@pytest.mark.parametrize("estimator", ["filter", "polynomial"])
@pytest.mark.parametrize("controller", ["inverse-model", "fuzzy-pid"])
def test_a_board_runs_the_loop_whose_checksum_it_has(model: SensingModel, estimator: str, controller: str) -> None:
    gains = gains_of(model, PERIOD_S)
    assert gains is not None
    settings = settings_for(model) if controller == "fuzzy-pid" else gains.settings
    assert loop_of_board(Firmware((estimator, settings)), model, None, PERIOD_S) == (estimator, controller)


def test_a_model_without_slow_loop_or_gains_is_asked_for_the_paper_s_loop_alone(model: SensingModel) -> None:
    bare = replace(model, slow_loop=(), gains={})
    paper = Firmware(("polynomial", settings_for(bare)))
    assert loop_of_board(paper, bare, None, PERIOD_S) == ("polynomial", "fuzzy-pid")


def test_a_board_of_another_model_or_of_other_settings_is_refused(model: SensingModel) -> None:
    with pytest.raises(CallerError, match="which no loop of this model has"):
        loop_of_board(Firmware(None), model, None, PERIOD_S)
    usual, others = settings_for(model), settings_for(model, FuzzyPidSettings(rule_base="fixed"))
    with pytest.raises(CallerError, match="which no loop of this model has"):
        loop_of_board(Firmware(("polynomial", usual)), model, others, PERIOD_S)
