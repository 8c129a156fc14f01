"""The list of what absent parts would offer says what the parts offer that are there."""

from __future__ import annotations

import pytest
from tests.places import CHECKOUT

from musclewire.manifest import Manifest, folder_of, manifests, parts


def names_by_kind(one: Manifest) -> dict[str, list[str]]:
    """What parts.toml lists of a manifest."""
    top = [command.name for command in one.commands if command.group != one.name]
    return {
        "commands": sorted([group.name for group in one.groups] + top),
        "names": sorted(one.names),
        "estimators": sorted(one.estimators),
        "devices": sorted(one.devices),
        "load_parts": sorted(one.load_parts),
        "rig_keys": sorted(one.rig_keys),
        "rig_files": sorted(file.stem for file in folder_of(one.rig_files).glob("*.toml")) if one.rig_files else [],
        "suffixes": sorted(one.suffixes_read),
        "run_kinds": sorted(one.run_kinds),
    }


def listed_parts() -> list[pytest.ParameterSet]:
    """One case per part that is there; one installed apart comes with what developers have, as `slow` tests do."""
    apart = {name for name, offer in parts().items() if "install" in offer}
    return [
        pytest.param(one, id=one.name, marks=[pytest.mark.slow] if one.name in apart else [])
        for one in manifests()
        if one.name in parts()
    ]


@pytest.mark.parametrize("one", listed_parts())
def test_the_list_of_absent_parts_says_what_the_manifest_offers(one: Manifest) -> None:
    listed = parts()[one.name]
    kinds = names_by_kind(one)
    assert {kind: sorted(listed.get(kind, [])) for kind in kinds} == kinds
    assert listed["what"]


def test_every_part_of_the_checkout_is_listed() -> None:
    installed_apart = {name for name, offer in parts().items() if "install" in offer}
    assert {each.name for each in manifests()} >= parts().keys() - installed_apart


def test_a_package_that_is_installed_apart_is_where_its_line_says() -> None:
    for offer in parts().values():
        if "install" in offer:
            assert (CHECKOUT / offer["install"].removeprefix("pip install ") / "pyproject.toml").is_file()
