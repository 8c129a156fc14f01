"""The page of the documentation says what the tests run."""

from __future__ import annotations

import importlib.util

from tests.places import CHECKOUT


def test_the_page_of_faults_is_written_from_the_matrix() -> None:
    spec = importlib.util.spec_from_file_location("faults_page", CHECKOUT / "docs" / "images" / "faults_page.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    said = (CHECKOUT / "docs" / "reference" / "faults.md").read_text(encoding="utf-8")
    assert said == module.page(), "write it again: python docs/images/draw.py physics"
