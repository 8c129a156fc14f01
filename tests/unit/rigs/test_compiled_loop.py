"""What goes into a compiled loop is what a rig in Python has, and what cannot go in is named."""

from __future__ import annotations

import numpy as np
import pytest

from musclewire.rigs import open_rig, run_known_drive, uncompiled


def test_what_has_no_compiled_form_says_why() -> None:
    with open_rig() as fresh, open_rig(real_time=True) as paced:
        assert uncompiled(fresh) == ""
        assert "clock" in uncompiled(paced)
        fresh.exchange(0.3)
        assert "being driven" in uncompiled(fresh)
        fresh.make_safe()
        assert uncompiled(fresh) == ""


def test_after_compiled_samples_the_last_drive_is_out() -> None:
    with open_rig("simulated") as rig:
        run_known_drive(rig, np.linspace(0.5, 2.0, 20))
        assert rig.drive_voltage_v == pytest.approx(2.0, abs=0.002)  # the step of the output's converter
        assert rig.protection.drive_voltage_v == pytest.approx(2.0, abs=0.002)
