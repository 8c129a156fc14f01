"""Files of settings: none is read without bound, and whatever one says, what is wrong with it is one line."""

from __future__ import annotations

import json
import sys
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.controllers import load_rule_base
from musclewire.errors import CallerError
from musclewire.files import load_mapping
from musclewire.parameters import load_wire
from musclewire.rigs import read_rig_file
from musclewire.sensing import load_model
from musclewire.small_files import MAX_BYTES, json_of, read_small, toml_of, toml_text

endless = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no device file without an end")
WHOLE, TEXT = st.integers(-(2**63), 2**63 - 1), st.text(st.characters(codec="utf-8"))
VALUES = st.recursive(
    st.none() | st.booleans() | WHOLE | TEXT | st.floats(allow_nan=False, allow_infinity=False),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXT, inner, max_size=3),
)


@endless
@pytest.mark.parametrize(
    "read",
    [read_rig_file, load_wire, load_mapping, load_rule_base, load_model],
    ids=["rig", "wire", "mapping", "rule base", "model"],
)
def test_no_file_of_settings_is_read_without_an_end(
    read: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each kind by its own reader; where a kind goes by its suffix a link has that."""
    place = tmp_path / "endless.toml"
    place.symlink_to("/dev/zero")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(CallerError, match=f"is larger than {MAX_BYTES} bytes"):
        read("endless.toml" if read is load_wire else place)  # type: ignore[operator]


def test_the_largest_file_that_is_read_and_the_smallest_that_is_not(tmp_path: Path) -> None:
    place = tmp_path / "a.toml"
    place.write_bytes(b" " * MAX_BYTES)
    assert len(read_small(place, "file")) == MAX_BYTES
    place.write_bytes(b" " * (MAX_BYTES + 1))
    with pytest.raises(CallerError, match="is larger than"):
        read_small(place, "file")


@pytest.mark.parametrize(
    "text",
    [
        f"seed = {'9' * 5000}",
        f"seed = {'9' * 500}",
        f"seed = [{2**63}]",
        f"[a]\nb = {{ c = {-(2**63) - 1} }}",
        "a = 1\na = 2",
        "[" * 5000,
        f"x = {'[' * 3000}{']' * 3000}",
        'a = "\nb = 1',
    ],
)
def test_what_is_no_toml_or_has_no_end_is_one_line(text: str) -> None:
    with pytest.raises(CallerError) as caught:
        toml_of(text, "rig file")
    assert str(caught.value).startswith("rig file ")
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    "text",
    ['{"a": 1, "a": 1}', '{"b": [{"a": 1, "c": 2, "a": 3}]}', "NaN", "[-Infinity]", "[1e999]", '["\\ud800"]',
     '{"\\udfff": 1}', "9" * 5000, str(2**63), "[" * 100_000, b"\xff\xfe1\x00", "{", ""],
)  # fmt: skip
def test_what_is_no_json_or_says_a_thing_twice_is_one_line(text: str | bytes) -> None:
    with pytest.raises(CallerError) as caught:
        json_of(text, "message")
    assert len(str(caught.value).splitlines()) == 1
    assert len(str(caught.value)) < 250


@given(VALUES)
def test_every_other_value_comes_back_as_it_was(value: object) -> None:
    assert json_of(json.dumps(value), "message") == value


@given(
    st.dictionaries(
        st.text("abc", min_size=1), st.integers(-(2**63), 2**63 - 1) | st.text(st.characters(codec="utf-8"), min_size=1)
    )
)
def test_tables_are_what_the_toml_reader_says(tables: dict[str, object]) -> None:
    text = toml_text(tables)
    assert toml_of(text, "file") == tomllib.loads(text) == tables
