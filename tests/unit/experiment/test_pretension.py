from __future__ import annotations

from math import pi

import pytest
from fake_rig import FakeRig

from musclewire.errors import CallerError
from musclewire.experiment._pretension import default_pretensions_n, pretension_sweep
from musclewire.rigs import open_rig


def test_pretension_first_closes_the_loop() -> None:
    """Fig. 4: from slack to tight the strain gap falls."""
    with open_rig("simulated", wire="paper-125um") as rig:
        sweep = pretension_sweep(rig, [1.70, 2.4, 3.22], cycles=1)
    gaps = [row.strain_gap_pct for row in sweep.rows]
    assert gaps == sorted(gaps, reverse=True)
    assert sweep.best.pretension_n == 3.22
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
