from __future__ import annotations

from math import pi

import numpy as np
import pytest
from fake_rig import FakeRig

from musclewire.errors import CallerError
from musclewire.experiment import PretensionRow, PretensionSweep, pretension_sweep
from musclewire.experiment._pretension import default_pretensions_n, largest_in_motion_n
from musclewire.rigs import RigConfiguration, open_rig
from musclewire.signals import Recording


def test_pretension_first_closes_the_loop() -> None:
    """Fig. 4: from slack to tight the strain gap falls."""
    with open_rig("simulated", wire="paper-125um") as rig:
        sweep = pretension_sweep(rig, [1.70, 2.4, 3.22], cycles=1)
    gaps = [row.strain_gap_pct for row in sweep.rows]
    assert gaps == sorted(gaps, reverse=True)
    assert sweep.best is sweep.rows[1]  # at 3.22 N the wire in motion pulls harder than its vendor names
    assert sweep.failures == ()


def test_the_default_settings_span_the_papers_force_ratios_up_to_the_vendors_stress() -> None:
    with open_rig("simulated") as rig:
        forces = default_pretensions_n(rig)
    assert forces[0] == pytest.approx(0.20 * 4.601, abs=0.01)
    assert forces[-1] == pytest.approx(172.0 * 2.0 * pi / 4.0 * 0.01, abs=0.01)  # MPa, two legs, mm^2
    assert len(forces) == 8


def test_a_rig_whose_stage_is_moved_by_hand_says_what_to_do() -> None:
    with pytest.raises(CallerError, match="moved by hand"):
        pretension_sweep(FakeRig(), [1.0])


def row_at(pretension_n: float, gap_pct: float, force_n: float, limit_n: float) -> PretensionRow:
    """Return a setting whose wire pulls with up to a force [N]."""
    return PretensionRow(
        pretension_n,
        gap_pct,
        None,
        None,
        3.7,
        Recording({"time_s": np.zeros(1)}, {}),
        "",
        force_n,
        within_limit=force_n <= limit_n,
    )


def test_what_is_best_keeps_the_wire_within_its_vendors_stress_while_it_contracts() -> None:
    rows = (row_at(1.0, 7.0, 2.5, 2.8), row_at(1.2, 6.0, 2.7, 2.8), row_at(2.5, 1.2, 4.1, 2.8))
    sweep = PretensionSweep(rows, (), limit_n=2.805, largest_n=largest_in_motion_n(rows, 2.805))
    assert sweep.best is rows[1]
    assert sweep.largest_n == pytest.approx(1.3)
    assert sweep.advice.startswith("a smaller gap, 1.20 %, is at 2.50 N, but there the wire pulls with up to 4.10 N")
    assert "softer spring" in sweep.advice
    assert "'filter'" in sweep.advice


def test_where_the_smallest_gap_is_within_the_limit_or_none_is_known_there_is_no_advice() -> None:
    rows = (row_at(1.0, 2.0, 2.5, 2.8), row_at(1.2, 3.0, 2.9, 2.8))
    assert PretensionSweep(rows, (), limit_n=2.8).advice == ""
    unknown = (row_at(1.0, 3.0, 2.5, 99.0), row_at(1.2, 2.0, 2.9, 99.0))
    sweep = PretensionSweep(unknown, ())
    assert (sweep.best, sweep.advice, largest_in_motion_n(unknown, None)) == (unknown[1], "", None)


def test_a_default_sweep_adds_the_setting_at_which_the_wire_in_motion_reaches_its_limit() -> None:
    """A stiff spring on a thin wire: the settings by the cold pull are nearly all too tight."""
    with open_rig("simulated", wire="flexinol-0.10-lt", spring_stiffness_n_per_m=900.0) as rig:
        sweep = pretension_sweep(rig, cycles=1)
    assert len(sweep.rows) == 9
    assert sweep.best is sweep.rows[0]
    assert sweep.best.pretension_n == sweep.largest_n
    assert sweep.best.largest_force_n == pytest.approx(sweep.limit_n, rel=0.03)


def test_no_pretension_above_the_vendors_limit_in_motion_is_recommended() -> None:
    straight = RigConfiguration(wire="flexinol-0.10-lt", legs=1.0, wire_length=0.14, bench="paper")
    with open_rig(straight) as rig:
        forces = default_pretensions_n(rig)
        largest_n = 172e6 * pi / 4.0 * rig.metadata()["wire_diameter_m"] ** 2
        assert 1.38 < max(forces) <= largest_n < 1.40
        sweep = pretension_sweep(rig, [0.9, 3.09], cycles=1, period_s=30.0)
    assert sweep.limit_n == pytest.approx(largest_n)
    assert sweep.best is None
    assert sweep.advice.startswith("no pretension of these is within the wire's limit: at 0.90 N it pulls with up to")
    assert "take a softer spring, a dead weight of up to 1.39 N, or a thicker wire" in sweep.advice
