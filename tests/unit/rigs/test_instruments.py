"""The simulated instruments: what NumPy makes of the same random numbers, to the bit."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.parameters import load_bench
from musclewire.rigs._simulated import BenchInstruments

BENCH = load_bench("paper").values()
SAMPLES = 3


def by_numpy(bench: dict[str, float], seed: int, wire_v: float, shunt_v: float) -> list[tuple[float, ...]]:
    """Return samples of both voltages, of a displacement of 1 mm and of 2 N, in NumPy's own operations."""
    random = np.random.default_rng(seed)
    range_v = bench["acquisition_range_v"]
    step_v = 2.0 * range_v / 2.0 ** bench["acquisition_bits"]
    samples = []
    for _ in range(SAMPLES):
        noise = random.standard_normal((2, int(bench["acquisition_readings"])))
        noisy = np.array([[wire_v], [shunt_v]]) + bench["acquisition_noise_v"] * noise
        voltages_v = np.clip(np.round(noisy / step_v) * step_v, -range_v, range_v).mean(axis=1)
        moved, pulled = random.standard_normal(2)
        displacement_m = 1e-3 + bench["displacement_noise_m"] * moved
        samples.append((*voltages_v.tolist(), float(displacement_m), float(2.0 + bench["force_noise_n"] * pulled)))
    return samples


@settings(deadline=None)
@given(
    readings=st.integers(1, 300),
    seed=st.integers(0, 2**32),
    wire_v=st.floats(-12.0, 12.0),
    shunt_v=st.floats(-1.0, 1.0),
    noise_v=st.floats(0.0, 0.1),
)
def test_readings_are_what_numpy_makes_of_the_same_random_numbers(
    readings: int, seed: int, wire_v: float, shunt_v: float, noise_v: float
) -> None:
    bench = {**BENCH, "acquisition_readings": float(readings), "acquisition_noise_v": noise_v}
    instruments = BenchInstruments(bench, seed)
    read = [instruments.sample(wire_v, shunt_v, 1e-3, 2.0) for _ in range(SAMPLES)]
    assert read == by_numpy(bench, seed, wire_v, shunt_v)


def test_instruments_at_an_endpoint_take_their_random_numbers_after_those_of_the_connector() -> None:
    instruments = BenchInstruments(BENCH, 5, at_endpoint=True)
    random = np.random.default_rng(5)
    for _ in range(SAMPLES):
        drawn = random.standard_normal(2 * int(BENCH["acquisition_readings"]) + 4)
        instruments.sample(1.0, 0.1, 0.0, 0.0)
        moved_m, pressed_n = instruments.endpoint(3e-3, 0.5)
        assert moved_m == 3e-3 + BENCH["endpoint_noise_m"] * drawn[-2]
        assert pressed_n == 0.5 + BENCH["endpoint_force_noise_n"] * drawn[-1]
