"""A part of a load that another package brings: one class, one registration, and rig files know it as one of ours."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar, Literal

import pytest

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.manifest import Manifest, manifests
from musclewire.parameters import load_wire
from musclewire.rigs import LOAD_PARTS, Length, LoadPart, Metadata, Stiffness, open_rig, read_rig_file
from musclewire.signals import Drive

HEAD = '[[load]]\npart = "pretensioner"\nstiffness = "386.2 N/m"\n'
RUBBER = HEAD + '[[load]]\npart = "rubber band"\nstiffness = "800 N/m"\nreach = "3 mm"\n'


class RubberBand(LoadPart):
    """A band that grows stiffer as it is drawn, and rubs."""

    once: ClassVar[bool] = True

    part: Literal["rubber band"]
    stiffness: Stiffness
    reach: Length = 2e-3

    def force_n(self, displacement_m: FloatArray) -> FloatArray:
        return self.stiffness * displacement_m * (1.0 + displacement_m / self.reach)

    def friction_n(self, displacement_m: FloatArray) -> FloatArray:
        return 10.0 * displacement_m

    def facts(self) -> Metadata:
        return {"rubber_reach_m": self.reach}


@pytest.fixture
def _registered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(LOAD_PARTS, "_registered", {})
    LOAD_PARTS.register("rubber band", RubberBand)


@pytest.fixture
def _offered(monkeypatch: pytest.MonkeyPatch) -> None:
    """As an installed package offers it in its manifest."""
    monkeypatch.setitem(sys.modules, "rubber_bands", SimpleNamespace(Band=RubberBand))  # type: ignore[arg-type]
    there = (*manifests(), Manifest("rubber", load_parts={"rubber band": "rubber_bands:Band"}))
    monkeypatch.setattr("musclewire.manifest.manifests", lambda: there)


def rig_file(folder: Path, text: str) -> Path:
    path = folder / "rig.toml"
    path.write_text(text, "utf-8")
    return path


@pytest.mark.parametrize("known_by", ["_registered", "_offered"])
def test_a_rig_file_has_it_and_the_wire_pulls_it(known_by: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    request.getfixturevalue(known_by)
    # Enough for the wire to transform, little enough for the band, which triples the force of a full stroke.
    warm_v = 0.9 * load_wire("paper-100um").drive_amplitude_v.value

    def pulled(text: str) -> tuple[float, float, Metadata]:
        with open_rig(rig_file(tmp_path, text), acquisition_noise_v=0.0) as rig:
            for _ in range(60):
                sample = rig.exchange(Drive(warm_v))
            return float(sample.displacement_m or 0.0), float(sample.force_n or 0.0), rig.metadata()

    (free_m, _, _), (drawn_m, drawn_n, facts) = pulled(HEAD), pulled(RUBBER)
    assert free_m > drawn_m > 3e-4
    bare_n = float(facts["pretension_n"] or 0.0) + (386.2 + 800.0 * (1.0 + drawn_m / 3e-3)) * drawn_m
    # What the wire feels is the band's own law, up to the friction of band and guide and the instruments' noise.
    assert drawn_n == pytest.approx(bare_n, abs=10.0 * drawn_m + 0.1)
    assert facts["load"] == "pretensioner, rubber band"
    assert facts["rubber_reach_m"] == 3e-3
    assert "spring_stiffness_n_per_m" not in facts


@pytest.mark.usefixtures("_registered")
@pytest.mark.parametrize(
    ("text", "hint"),
    [
        (RUBBER.replace("reach", "raech"), "unknown key 'load.1.rubber band.raech'; did you mean 'reach'?"),
        (RUBBER.replace('"800 N/m"', '"800 mm"'), "mm is a length; a stiffness is needed"),
        (RUBBER.replace("rubber band", "ruber band"), "there is no part 'ruber band'; did you mean 'rubber band'?"),
        (RUBBER + RUBBER.removeprefix(HEAD), "there are 2 parts 'rubber band', 1 fits"),
    ],
)
def test_a_mistake_in_it_is_answered_as_in_one_of_ours(text: str, hint: str, tmp_path: Path) -> None:
    with pytest.raises(CallerError) as caught:
        read_rig_file(rig_file(tmp_path, text))
    assert hint in str(caught.value)


def test_without_registration_it_is_unknown_and_our_names_cannot_be_taken(tmp_path: Path) -> None:
    with pytest.raises(CallerError, match="there is no part 'rubber band'"):
        read_rig_file(rig_file(tmp_path, RUBBER))
    with pytest.raises(CallerError, match="already a part of a load named 'spring'"):
        LOAD_PARTS.register("spring", RubberBand)
