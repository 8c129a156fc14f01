"""A new wire settles, and a settled one is recognised."""

from __future__ import annotations

import pytest

from musclewire.errors import CallerError
from musclewire.experiment import train
from musclewire.rigs import RigConfiguration, open_rig


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


def test_a_training_that_runs_out_of_cycles_or_pulls_too_hard_says_so() -> None:
    with open_rig(RigConfiguration(new_wire=True)) as rig:
        assert not train(rig, max_cycles=3).settled
        with pytest.raises(CallerError, match="at least 2"):
            train(rig, max_cycles=1)
    with open_rig("simulated", spring_stiffness_n_per_m=2500.0, pretension_n=2.0) as rig:
        assert train(rig, max_cycles=2).warnings[0].startswith("cycle 1: the wire pulls with up to")
