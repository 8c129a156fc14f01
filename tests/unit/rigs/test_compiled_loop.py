"""What goes into a compiled loop is what a rig in Python has, and what cannot go in is named."""

from __future__ import annotations

import pytest

from musclewire.parameters.library import load_bench
from musclewire.rigs.compiled_loop.running import uncompiled
from musclewire.rigs.configuration import RigConfiguration, open_rig
from musclewire.rigs.simulated import Instruments, read_sample


@pytest.mark.parametrize("at_endpoint", [False, True])
def test_noise_is_drawn_beforehand_as_it_is_from_sample_to_sample(at_endpoint: bool) -> None:
    bench = load_bench("paper").values()
    python, ahead = (Instruments(bench, 3, at_endpoint) for _ in range(2))
    true = (1.2345, 0.0789, 1e-3, 2.0)
    for noise in ahead.noise_ahead(5)[0]:
        assert read_sample(noise, ahead.readings, true, ahead.scales) == python.sample(*true)
        if at_endpoint:
            wide = zip((1e-3, 2.0), ahead.endpoint_noise, noise[-2:], strict=True)
            assert python.endpoint(1e-3, 2.0) == tuple(true + scale * one for true, scale, one in wide)


def test_what_has_no_compiled_form_says_why() -> None:
    lost = RigConfiguration.model_validate({"fault": [{"kind": "wire_open", "at": "3 s"}]})
    with open_rig() as fresh, open_rig(lost) as faulty, open_rig("gripper") as two, open_rig(real_time=True) as paced:
        assert uncompiled(fresh) == ""
        assert "faults" in uncompiled(faulty)
        assert "two wires" in uncompiled(two)
        assert "clock" in uncompiled(paced)
        fresh.exchange(0.3)
        assert "being driven" in uncompiled(fresh)
        fresh.make_safe()
        assert uncompiled(fresh) == ""
