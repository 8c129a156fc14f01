"""A damaged model file is refused in one line or gives a model that can be used, and nothing else happens."""

from __future__ import annotations

import json
import math
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from musclewire.errors import CallerError
from musclewire.sensing import SensingModel, load_model, save_model

ODD_VALUES = st.one_of(
    st.none(), st.booleans(), st.floats(), st.integers(-(10**400), 10**400), st.text(max_size=5),
    st.sampled_from(["nan", "1e3", "strain", "force", "displacement", "x" * 500, "\ud800", [], {}, [[]], {"a": 1}]),
)  # fmt: skip
FACTORS = st.sampled_from([-1, 0.5, 1 + 1e-7, 1.001, 1.1, 2, 1e3, 1e-3, 1e150])
STRAIN = SensingModel(
    *(12.3, 15.1, (0.031, -0.012, -0.021, 0.003), (0.029, -0.016, -0.016, 0.001), 0.02, 0.98),
    hysteresis_gap=0.021,
    rmse_heating=1e-4,
    rmse_cooling=1e-4,
    rmse_average=5e-4,
    samples=812,
    heating_standard_errors=(1e-5,) * 4,
    cooling_standard_errors=(1e-5,) * 4,
    resistance_noise_ohm=1e-3,
    wire={"wire": "paper-100um", "wire_length_m": 0.28},
    heating_samples=((12.3, 0.031), (15.1, 0.001)),
)
FORCE = SensingModel(8.0, 9.5, (4.0, -3.0), (3.8, -2.9), 0.0, 1.0, quantity="force")


def places(value: Any) -> list[tuple[Any, Any]]:
    """Return every (container, key) of a document."""
    pairs = list(value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ())
    return [place for key, item in pairs for place in [(value, key), *places(item)]]


def damage_structure(document: Any, draw: st.DataObject) -> None:
    """Change a value, lose or double a key, or swap two values of a document."""
    container, key = draw.draw(st.sampled_from(places(document)))
    kind = draw.draw(st.sampled_from(["scaled", "odd", "lost", "doubled", "swapped"]))
    value = container[key]
    if kind == "scaled" and type(value) in (int, float) and abs(value) < 1e15:
        container[key] = value * draw.draw(FACTORS)
    elif kind == "lost":
        del container[key]
    elif kind == "doubled" and isinstance(container, dict):
        container[draw.draw(st.sampled_from([key[:-1], key + "s", key.upper(), "format", "version"]))] = deepcopy(value)
    elif kind == "swapped":
        other, place = draw.draw(st.sampled_from(places(document)))
        container[key], other[place] = deepcopy(other[place]), deepcopy(value)
    else:
        container[key] = deepcopy(draw.draw(ODD_VALUES))


def damage_bytes(data: bytes, draw: st.DataObject) -> bytes:
    """Return bytes with a part replaced by others, none or its double."""
    start = draw.draw(st.integers(0, len(data)))
    part = data[start : start + draw.draw(st.sampled_from([0, 1, 2, 10, 200]))]
    others = draw.draw(st.one_of(st.binary(max_size=20), st.just(part * 2), st.just(b"[" * 200_000)))
    return data[:start] + others + data[start + len(part) :]


def is_refused_or_usable(path: Path, again: Path) -> None:
    """Assert that a file is refused, or that its model estimates, inverts and survives saving."""
    try:
        model = load_model(path)
    except CallerError:
        return
    is_usable(model, again)


def is_usable(model: SensingModel, again: Path) -> None:
    """Assert that a model estimates finite numbers over its range, inverts them, and survives saving."""
    low, high = model.resistance_min_ohm, model.resistance_max_ohm
    for fraction in (-0.5, 0.0, 0.3, 0.7, 1.0, 1.5):
        estimate = model.estimate(low + fraction * (high - low))
        assert math.isfinite(estimate.value)
        assert math.isfinite(estimate.std)
    assert math.isfinite(model.resistance_ohm(0.5 * (model.quantity_min + model.quantity_max)))
    again.unlink(missing_ok=True)
    save_model(model, again)
    assert load_model(again) == model


both_models = pytest.mark.parametrize("model", [STRAIN, FORCE], ids=["strain", "force"])
IN_ONE_FOLDER = [HealthCheck.function_scoped_fixture]


@pytest.mark.slow
@both_models
@settings(max_examples=200, deadline=None, suppress_health_check=IN_ONE_FOLDER)
@given(draw=st.data())
def test_a_damaged_model_file_is_refused_in_one_line_or_usable(
    model: SensingModel, draw: st.DataObject, tmp_path: Path
) -> None:
    damage_a_file(model, draw, tmp_path)


@pytest.mark.full
@both_models
@settings(max_examples=1500, deadline=None, suppress_health_check=IN_ONE_FOLDER)
@given(draw=st.data())
def test_1500_damaged_model_files_are_refused_in_one_line_or_usable(
    model: SensingModel, draw: st.DataObject, tmp_path: Path
) -> None:
    damage_a_file(model, draw, tmp_path)


def damage_a_file(model: SensingModel, draw: st.DataObject, tmp_path: Path) -> None:
    valid, damaged = tmp_path / "model.json", tmp_path / "damaged.json"
    if not valid.exists():
        save_model(model, valid)
    document = json.loads(valid.read_text("utf-8"))
    for _ in range(draw.draw(st.integers(0, 3))):
        if places(document):
            damage_structure(document, draw)
    data = json.dumps(document).encode("utf-8", "surrogatepass")
    damaged.write_bytes(damage_bytes(data, draw) if draw.draw(st.booleans()) else data)
    is_refused_or_usable(damaged, tmp_path / "again.json")
