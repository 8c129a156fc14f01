"""Materials: every number says where it is from, and a mistake in a user's file is one line."""

from __future__ import annotations

import tomllib
from typing import Any

import pytest

from musclewire.errors import CallerError
from musclewire.parameters import Material, folder_of_materials, load_material, material_names, validated


@pytest.fixture
def pom() -> dict[str, Any]:
    return tomllib.loads((folder_of_materials() / "pom.toml").read_text("utf-8"))


def complaint(data: dict[str, Any]) -> str:
    with pytest.raises(CallerError) as caught:
        validated(Material, data, "material file mine.toml")
    return str(caught.value)


def test_at_least_eight_materials_come_along() -> None:
    assert {"pom", "pa12", "pla", "petg", "peek", "spring-steel", "aluminium-7075", "ti-6al-4v"} <= set(
        material_names()
    )


@pytest.mark.parametrize("name", material_names())
def test_a_material_is_called_as_its_file_and_every_number_has_a_source(name: str) -> None:
    material = load_material(name)
    assert material.name == name
    for _, item in [*material.items(), *material.minimum_thickness_m.items()]:
        assert len(item.source) > 5


@pytest.mark.parametrize("name", material_names())
def test_the_numbers_are_of_the_right_order(name: str) -> None:
    numbers = load_material(name).values()
    elastomer = name.startswith("tpu")
    if elastomer:
        # What printed TPU has been measured to have: 24 to 247 MPa (Haid et al., 2022).
        assert 24e6 <= numbers["youngs_modulus_pa"] <= 247e6
        assert numbers["allowable_stress_pa"] <= 0.05 * numbers["youngs_modulus_pa"]
    else:
        assert 0.5e9 < numbers["youngs_modulus_pa"] < 250e9
    assert 0.25 <= numbers["poisson_ratio"] < 0.5
    # A flexure's strain at yield: half a percent for metals, several for plastics; never a tenth but for rubber.
    assert 0.002 < numbers["yield_stress_pa"] / numbers["youngs_modulus_pa"] < (0.21 if elastomer else 0.1)
    assert 800.0 < numbers["density_kg_per_m3"] < 9000.0
    assert all(5e-5 <= item.value <= 2e-3 for item in load_material(name).minimum_thickness_m.values())


def test_a_process_is_found_by_name_and_the_first_is_the_usual_one() -> None:
    pom = load_material("pom")
    assert pom.minimum_thickness_by("mill") == pom.minimum_thickness_m["mill"].value
    assert pom.minimum_thickness_by(None) == pom.minimum_thickness_m[pom.processes[0]].value


@pytest.mark.parametrize(("material", "said"), [("petg", "fdm"), ("tpu-95a", "FFF"), ("pa12", "sls")])
def test_a_process_is_found_by_what_printers_owners_call_it(material: str, said: str) -> None:
    one = load_material(material)
    assert one.process_called(said) == one.processes[0]
    assert one.minimum_thickness_by(said) == one.minimum_thickness_by(None)


@pytest.mark.parametrize(
    ("said", "words"),
    [("fdm", "pom is not made by 'fdm'; known: laser-cut, mill"), ("milled", "did you mean 'mill'")],
)
def test_a_process_that_a_material_has_not_is_answered_with_those_it_has(said: str, words: str) -> None:
    with pytest.raises(CallerError, match=words):
        load_material("pom").minimum_thickness_by(said)


@pytest.mark.parametrize(
    ("name", "words"), [("pon", "did you mean 'pom'"), ("nowhere.toml", r"there is no material file nowhere\.toml")]
)
def test_a_material_that_is_not_there_is_said(name: str, words: str) -> None:
    with pytest.raises(CallerError, match=words):
        load_material(name)


@pytest.mark.parametrize(
    ("key", "part", "value", "words"),
    [
        ("youngs_modulus_pa", "unit", "GPa", "it must be given in 'Pa'"),
        ("youngs_modulus_pa", "value", 0.0, "it must be above 0"),
        ("poisson_ratio", "value", 0.5, "it must be below 0.5"),
        ("allowable_stress_pa", "value", 1e9, "is above yield_stress_pa"),
    ],
)
def test_a_number_that_cannot_be_is_said(pom: dict[str, Any], key: str, part: str, value: object, words: str) -> None:
    pom[key][part] = value
    assert words in complaint(pom)


def test_a_process_is_checked_too_and_a_material_has_one(pom: dict[str, Any]) -> None:
    pom["minimum_thickness_m"]["mill"]["unit"] = "mm"
    assert "minimum_thickness_m.mill has the unit 'mm'" in complaint(pom)
    pom["minimum_thickness_m"] = {}
    assert "minimum_thickness_m" in complaint(pom)
