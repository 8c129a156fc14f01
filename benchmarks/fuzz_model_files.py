"""Mutated model files: each is refused in one line or gives a model that can be used, and nothing else happens.

A model file comes by mail, from an old version, or half written. A fitted model's JSON is damaged in four ways: bytes
(flipped, cut, doubled, mixed in), values (of another type, huge, tiny, negative, not finite), keys (lost, misspelt,
unknown, twice) and structure (nested, emptied, swapped). What is accepted must estimate finite numbers over its range,
invert them, and come back the same after saving. Warnings count as failures. Exit 1 if any document does worse.

    python benchmarks/fuzz_model_files.py [--quick] [--seed N]     100,000 documents, or 5,000
"""

from __future__ import annotations

import json
import math
import random
import sys
import tempfile
import time
import warnings
from collections import Counter
from copy import deepcopy
from pathlib import Path
from typing import Any

from musclewire.errors import CallerError
from musclewire.sensing import SensingModel, load_model, save_model

DOCUMENTS, QUICK_DOCUMENTS = 100_000, 5_000
ODD_VALUES: list[Any] = [
    *(None, True, False, "", "nan", "1e3", [], {}, [[]], {"a": 1}, 0, -1, 1, 2, 10**30, 10**400, -(10**400)),
    *(0.0, -0.0, 1e-320, 5e-324, 1e308, -1e308, 1e200, math.nan, math.inf, -math.inf, 0.1, 1e-9, "x" * 500, "\ud800"),
    *("strain", "force", "displacement", "Strain", "1", "m", "N"),
]


def valid_models() -> list[SensingModel]:
    """Return models as fits give them: one of strain of order 3, one of force of order 1."""
    strain = SensingModel(
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
    return [strain, SensingModel(8.0, 9.5, (4.0, -3.0), (3.8, -2.9), 0.0, 1.0, quantity="force")]


def documents() -> list[str]:
    """Return the valid documents that are mutated."""
    with tempfile.TemporaryDirectory() as folder:
        texts = []
        for model in valid_models():
            save_model(model, Path(folder) / "model.json")
            texts.append((Path(folder) / "model.json").read_text())
            (Path(folder) / "model.json").unlink()
        return texts


def places(value: Any) -> list[tuple[Any, Any]]:
    """Return every (container, key) of a document."""
    pairs = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    found = []
    for key, item in pairs:
        found.append((value, key))
        found.extend(places(item))
    return found


def near(value: Any, chance: random.Random) -> Any:
    """Return another number near a number or far from it, anything else as an odd value."""
    plain = isinstance(value, float) or (isinstance(value, int) and not isinstance(value, bool) and abs(value) < 1e15)
    if plain and chance.random() < 0.7:
        factor = chance.choice([-1, 0.5, 1 + 1e-7, 1.001, 1.1, 2, 1e3, 1e-3, 1e150])
        return value * factor + chance.choice([0, 0, 1, -1])
    return deepcopy(chance.choice(ODD_VALUES))


def mutate_structure(text: str, chance: random.Random) -> bytes:
    """Return a document with values, keys or structure changed."""
    document = json.loads(text)
    for _ in range(chance.choice([1, 1, 1, 2, 5])):
        spots = places(document)
        if not spots:
            break
        container, key = chance.choice(spots)
        what = chance.random()
        if what < 0.6:
            container[key] = near(container[key], chance)
        elif what < 0.7:
            del container[key]
        elif what < 0.8 and isinstance(container, dict):
            name = str(key)
            alias = chance.choice([name[:-1], name + "s", name.upper(), "format", "version", "wire"])
            container[alias] = deepcopy(container[key])
        elif what < 0.9:
            other, place = chance.choice(spots)
            container[key], other[place] = deepcopy(other[place]), deepcopy(container[key])
        else:
            container[key] = [container[key]] * chance.choice([1, 2, 40])
    return write_anything(document)


def write_anything(document: Any) -> bytes:
    """Return a document as JSON as liberal writers give it, NaN and lone surrogates included."""
    return json.dumps(document).encode("utf-8", "surrogatepass")


def mutate_bytes(data: bytes, chance: random.Random) -> bytes:
    """Return bytes flipped, cut, doubled or mixed in."""
    found = bytearray(data)
    for _ in range(chance.choice([1, 1, 2, 4, 16])):
        at = chance.randrange(len(found) + 1)
        what = chance.random()
        if what < 0.3 and at < len(found):
            found[at] = chance.randrange(256)
        elif what < 0.5 and at < len(found):
            found[at] = chance.choice(b'0123456789.-+eE"[]{},:\\ntruefalsnI')
        elif what < 0.7:
            del found[at : at + chance.choice([1, 2, 10, 200])]
        elif what < 0.85:
            found[at:at] = bytes(chance.randrange(256) for _ in range(chance.choice([1, 3, 20])))
        else:
            found[at:at] = found[at : at + chance.choice([1, 10, 300])] * chance.choice([1, 5])
    return bytes(found) if chance.random() < 0.97 else b"[" * chance.choice([10, 2_000, 200_000])


def judge(path: Path, scratch: Path) -> str:
    """Return "refused" or "valid"; raises whatever else a document does."""
    try:
        model = load_model(path)
    except CallerError as error:
        if "\n" in str(error):
            raise AssertionError("a refusal of more than one line") from error
        return "refused"
    low, high = model.resistance_min_ohm, model.resistance_max_ohm
    for fraction in (-0.5, 0.0, 0.3, 0.7, 1.0, 1.5):
        estimate = model.estimate(low + fraction * (high - low))
        assert math.isfinite(estimate.value), "an estimate that is not finite"
        assert math.isfinite(estimate.std), "an uncertainty that is not finite"
    middle = 0.5 * (model.quantity_min + model.quantity_max)
    assert math.isfinite(model.resistance_ohm(middle)), "a resistance that is not finite"
    scratch.unlink(missing_ok=True)
    save_model(model, scratch)
    assert load_model(scratch) == model, "another model after saving and loading"
    return "valid"


def main() -> int:
    warnings.simplefilter("error")
    quick = "--quick" in sys.argv
    seed = int(sys.argv[sys.argv.index("--seed") + 1]) if "--seed" in sys.argv else 1
    chance = random.Random(seed)
    texts = documents()
    counts: Counter[str] = Counter()
    started = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        path, scratch = Path(folder) / "mutated.json", Path(folder) / "again.json"
        for index in range(QUICK_DOCUMENTS if quick else DOCUMENTS):
            text = chance.choice(texts)
            kind = chance.random()
            data = mutate_structure(text, chance) if kind < 0.7 else mutate_bytes(text.encode(), chance)
            path.write_bytes(data)
            try:
                counts[judge(path, scratch)] += 1
            except Exception as problem:  # the finding itself
                counts["failed"] += 1
                print(f"document {index} of seed {seed}: {type(problem).__name__}: {str(problem)[:200]}")
                if counts["failed"] <= 3:
                    print(f"  {data[:3000]!r}")
    print(
        f"mutated model files: {counts.total():,} (seed {seed}), refused in one line {counts['refused']:,}, valid and "
        f"usable {counts['valid']:,}, anything else {counts['failed']:,}; {time.perf_counter() - started:.0f} s"
    )
    return int(counts["failed"] > 0)


if __name__ == "__main__":
    sys.exit(main())
