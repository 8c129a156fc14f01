"""What parts offer, which are there, and what is said of one that is not."""

from __future__ import annotations

from importlib.metadata import EntryPoint

import pytest

from musclewire import manifest
from musclewire.errors import CallerError
from musclewire.manifest import Manifest, absent_part, manifests_of_others, offered
from musclewire.registry import Registry


def test_a_name_of_an_absent_part_is_one_line_that_says_which_part(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(manifest, "manifests", lambda: ())
    told = str(absent_part("commands", "reproduce"))
    assert "'reproduce' belongs to the part 'paper'" in told
    assert "musclewire/extras/paper" in told
    assert "\n" not in told
    assert absent_part("commands", "control") is None


def test_a_command_of_a_package_that_is_not_installed_names_the_line_that_installs_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(manifest, "manifests", lambda: ())
    told = str(absent_part("commands", "robustness"))
    assert told.endswith("not installed: pip install ./studies/robustness in the checkout")
    assert "extras" not in told


def test_a_name_of_a_part_that_is_there_is_not_absent(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(manifest, "manifests", lambda: (Manifest("paper"),))
    assert absent_part("commands", "reproduce") is None


def test_a_registry_finds_the_kinds_of_parts_and_names_the_absent_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    kinds: Registry[object] = Registry("kind of rig", "devices", {"own": "math:e"})
    there = Manifest("robots", devices={"arm": "math:pi", "own": "math:tau"})
    monkeypatch.setattr(manifest, "manifests", lambda: (there,))
    assert kinds.find("arm") == pytest.approx(3.14159, abs=1e-5)
    assert kinds.find("own") == pytest.approx(2.71828, abs=1e-5), "nobody takes a name of the core's"
    assert kinds.own_names() == ("own", "arm")
    with pytest.raises(CallerError, match="'serial' belongs to the part 'board'"):
        kinds.find("serial")


def test_of_two_offers_of_a_name_the_first_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    both = (Manifest("one", names={"x": "math:pi"}), Manifest("two", names={"x": "math:e", "y": "math:e"}))
    monkeypatch.setattr(manifest, "manifests", lambda: both)
    assert offered("names") == {"x": "math:pi", "y": "math:e"}


def test_a_package_whose_manifest_fails_is_named_and_the_others_stay(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    points = [
        EntryPoint("broken", "there_is_no_such_module:MANIFEST", "musclewire.extras"),
        EntryPoint("odd", "math:pi", "musclewire.extras"),
    ]
    monkeypatch.setattr(manifest, "entry_points", lambda **_: points)
    assert list(manifests_of_others()) == []
    first, second = capsys.readouterr().err.splitlines()
    assert first.startswith("musclewire: package 'broken' adds nothing: its manifest there_is_no_such_module:MANIFEST")
    assert (
        second
        == "musclewire: package 'odd' adds nothing: math:pi is no musclewire.manifest.Manifest; update or uninstall it"
    )
