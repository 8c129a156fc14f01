"""A new wire settles; a settled wire is anchored again from its resistance alone."""

from __future__ import annotations

from dataclasses import replace

import pytest

from musclewire.errors import CallerError
from musclewire.experiment.closed_loop import control
from musclewire.experiment.open_loop import characterize
from musclewire.experiment.training import recalibrate, train
from musclewire.identify import fit
from musclewire.rigs.configuration import RigConfiguration, open_rig


def test_a_new_wire_changes_from_cycle_to_cycle_until_it_has_settled() -> None:
    with open_rig(RigConfiguration(new_wire=True)) as rig:
        training = train(rig)
    assert training.settled
    changes = [cycle.change for cycle in training.cycles if cycle.change is not None]
    assert len(training.cycles) > 8
    assert changes[0] > 5 * changes[-1]
    assert training.cycles[-1].strain_cold < training.cycles[0].strain_cold  # it has grown longer


def test_a_settled_wire_is_recognised_in_the_fewest_cycles() -> None:
    with open_rig("simulated") as rig:
        training = train(rig)
    assert training.settled
    assert len(training.cycles) <= 8


def test_a_training_that_runs_out_of_cycles_says_so() -> None:
    with open_rig(RigConfiguration(new_wire=True)) as rig:
        assert not train(rig, max_cycles=3).settled
        with pytest.raises(CallerError, match="at least 2"):
            train(rig, max_cycles=1)


def test_a_training_against_a_load_that_is_too_stiff_says_in_which_cycle() -> None:
    with open_rig("simulated", spring_stiffness_n_per_m=2500.0, pretension_n=2.0) as rig:
        training = train(rig, max_cycles=2)
    assert training.warnings[0].startswith("cycle 1: the wire pulls with up to")


def test_recalibration_finds_the_anchors_of_today_without_a_sensor() -> None:
    """A model whose resistances are off by 0.3 ohm (longer leads, another day) steers wrong until it is anchored."""
    with open_rig("simulated") as rig:
        model = fit(characterize(rig))
        stale = replace(
            model,
            resistance_min_ohm=model.resistance_min_ohm + 0.3,
            resistance_max_ohm=model.resistance_max_ohm + 0.3,
        )
        anchored = recalibrate(rig, stale)
        assert anchored.model.resistance_min_ohm == pytest.approx(model.resistance_min_ohm, abs=0.02)
        assert anchored.model.resistance_max_ohm == pytest.approx(model.resistance_max_ohm, abs=0.02)
        assert anchored.resistance_min_moved_ohm == pytest.approx(-0.3, abs=0.02)
        good, bad = control(rig, anchored.model).metrics, control(rig, stale).metrics
    assert good.mae_mean_approached_pct is not None
    assert bad.mae_mean_approached_pct is not None
    assert good.mae_mean_approached_pct < 1.7 < bad.mae_mean_approached_pct
