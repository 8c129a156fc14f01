"""Model files; the only tests of this room that touch a folder, and only a temporary one."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from loops import LoopMaker, noisy

from musclewire.errors import CallerError
from musclewire.sensing import SensingModel, fit_loop, load_model

Damage = Callable[[dict[str, Any]], object]


@pytest.fixture(scope="module")
def model() -> SensingModel:
    loop = noisy(LoopMaker().record(), 2e-4, 1e-3)
    return fit_loop(loop.resistance_ohm, loop.strain, wire={"name": "d100", "diameter_m": 1e-4}, source="a test")


def test_a_model_comes_back_from_its_file_to_the_bit(model: SensingModel, tmp_path: Path) -> None:
    model.save(tmp_path / "model.json")
    assert load_model(str(tmp_path / "model.json")) == model
    assert (tmp_path / "model.json").stat().st_size < 50_000


def test_saving_replaces_what_was_there_or_leaves_it_and_nothing_else(
    model: SensingModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full_disk(_: int) -> None:
        raise OSError(28, "No space left on device")

    (tmp_path / "model.json").write_text("old", encoding="utf-8")
    with monkeypatch.context() as patched:
        patched.setattr("os.fsync", full_disk)
        with pytest.raises(CallerError, match="No space left"):
            model.save(tmp_path / "model.json")
    assert [path.read_text(encoding="utf-8") for path in tmp_path.iterdir()] == ["old"]
    model.save(tmp_path / "model.json")
    assert [path.name for path in tmp_path.iterdir()] == ["model.json"]
    assert load_model(tmp_path / "model.json") == model
    with pytest.raises(CallerError, match="cannot be written"):
        model.save(tmp_path / "nowhere" / "model.json")
    with pytest.raises(CallerError, match="there is no model file"):
        load_model(tmp_path / "none.json")


@pytest.mark.parametrize(
    "content",
    [b"", b"not json", b"\xff\xfe\x00", b"[1, 2]", b'{"format": "other"}', b"[" * 100_000, b" " * 1_000_001],
)
def test_a_file_that_is_no_model_is_told_in_one_line(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(content)
    with pytest.raises(CallerError, match=r"is not a model file|larger than 1000000 bytes|is no UTF-8 text"):
        load_model(tmp_path / "file")


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda d: d.update(version=3), "has version 3"),
        (lambda d: d.update(resistance_min_ohms=1), "did you mean 'resistance_min_ohm'"),
        (lambda d: d.pop("resistance_min_ohm"), "key 'resistance_min_ohm' is missing"),
        (lambda d: d.update(resistance_min_ohm=float("nan")), "finite"),
        (lambda d: d["heating_coefficients"].append(0.0), "fit both alike"),
        (lambda d: d.update(quantity_max=0.04), "the file was altered"),
        (lambda d: d.update(heating_standard_errors=[0.1]), "1 standard errors"),
        (lambda d: d.update(rmse_average=1e-9), "its numbers are not those that were written"),
    ],
)
def test_a_damaged_model_is_reported_in_one_line(
    damage: Damage, message: str, model: SensingModel, tmp_path: Path
) -> None:
    path = tmp_path / "model.json"
    model.save(path)
    document = json.loads(path.read_text(encoding="utf-8"))
    damage(document)
    path.write_text(json.dumps(document), encoding="utf-8")
    with pytest.raises(CallerError, match=message) as told:
        load_model(path)
    assert str(path) in str(told.value)


def test_numbers_of_numpy_are_written_as_plain_ones(model: SensingModel, tmp_path: Path) -> None:
    import numpy as np

    wire = {"length_m": np.float64(0.14), "new": True, "load_n": float("nan")}
    odd = replace(model, resistance_min_ohm=np.float64(model.resistance_min_ohm), wire=wire)
    odd.save(tmp_path / "model.json")
    assert load_model(tmp_path / "model.json").wire == {"length_m": 0.14, "new": "True", "load_n": "nan"}


def test_texts_for_a_reader_may_be_added_to_and_a_model_from_before_has_no_checksum(
    model: SensingModel, tmp_path: Path
) -> None:
    path = tmp_path / "model.json"
    model.save(path)
    document = json.loads(path.read_text(encoding="utf-8"))
    document["source"] = "the second spool"
    path.write_text(json.dumps(document), encoding="utf-8")
    assert load_model(path).source == "the second spool"
    del document["checksum"]
    path.write_text(json.dumps(document), encoding="utf-8")
    assert load_model(path).rmse_average == model.rmse_average


def numbers_in(value: Any) -> list[tuple[Any, Any]]:
    """Return every (container, key) of a document that holds a number."""
    pairs = list(value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ())
    own = [(value, key) for key, item in pairs if type(item) in (int, float)]
    return own + [place for _, item in pairs for place in numbers_in(item)]


def test_no_number_of_a_model_can_be_altered_unnoticed(model: SensingModel, tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    model.save(path)
    document = json.loads(path.read_text(encoding="utf-8"))
    places = numbers_in(document)
    assert len(places) > 50
    for container, key in places:
        kept = container[key]
        container[key] = type(kept)(1.5 * kept + 1)
        path.write_text(json.dumps(document), encoding="utf-8")
        with pytest.raises(CallerError):
            load_model(path)
        container[key] = kept
