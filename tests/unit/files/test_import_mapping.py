"""Mapping files keep what they are given, and name the nearest key for a typo; none can execute anything."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.errors import CallerError, RecordingError
from musclewire.files import ImportMapping, load_mapping, read_recording, save_mapping

HEAD = 'format = "musclewire-mapping"\nversion = 1\n'
headers = st.text(st.characters(codec="utf-8"), min_size=1, max_size=12).filter(str.strip)


@settings(max_examples=60, deadline=None)
@given(
    st.dictionaries(st.sampled_from(["time_s", "wire_voltage_v", "force_n"]), headers),
    st.none() | st.floats(1e-9, 1e4),
    st.dictionaries(st.sampled_from(["wire", "leg_length_m", "count"]), st.floats(-1e9, 1e9) | st.integers(-9, 9)),
    st.booleans(),
)
def test_what_is_saved_is_loaded(
    tmp_path_factory: pytest.TempPathFactory,
    columns: dict[str, str],
    period_s: float | None,
    metadata: dict[str, float],
    switch: bool,
) -> None:
    path = tmp_path_factory.mktemp("mapping") / "m.toml"
    mapping = ImportMapping(columns, (), period_s, switch, not switch, switch, metadata, only_mapped=True)
    save_mapping(mapping, path)
    loaded = load_mapping(path)
    assert loaded.columns == mapping.columns
    assert loaded.sample_period_s == pytest.approx(period_s) if period_s is not None else loaded.sample_period_s is None
    assert (loaded.drop_missing, loaded.zero, loaded.invert) == (switch, not switch, switch)
    assert dict(loaded.metadata) == metadata


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "begins with format"),
        (HEAD + 'sample_perod = "10 ms"\n', "unknown key 'sample_perod'; did you mean 'sample_period'"),
        (HEAD + "sample_period = 10\n", "sample_period is 10; it must be text"),
        (HEAD + 'sample_period = "10 mm"\n', "is a length"),
        (HEAD + "ignore = [3]\n", "ignore is a list of headers"),
        (HEAD + '[columns]\nwire_voltage = "a:V"\n', "unknown column 'wire_voltage'; did you mean 'wire_voltage_v'"),
        (HEAD + "[columns]\ntime_s = 3\n", 'columns.time_s is 3; write "HEADER"'),
        (HEAD + "[metadata]\nWire = 'x'\n", "metadata key 'Wire'"),
        ("a = " + "[" * 5000, "cannot be read"),
    ],
)
def test_a_wrong_mapping_file_is_named_in_one_line(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "m.toml"
    path.write_text(text)
    with pytest.raises(CallerError) as caught:
        load_mapping(path)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_mapping_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(CallerError, match=r"there is no mapping .*; save_mapping writes one"):
        load_mapping(tmp_path / "none.toml")


def test_the_voltage_of_a_shunt_of_no_ohm_is_refused(tmp_path: Path) -> None:
    rows = "".join(f"{0.05 * row},1.0,0.1\n" for row in range(3))
    (tmp_path / "a.csv").write_text(f"# shunt_resistance_ohm = 0\ntime_s,wire_voltage_v,shunt_voltage_v\n{rows}")
    with pytest.raises(RecordingError, match="the voltage of a shunt of 0 ohm is no current"):
        read_recording(tmp_path / "a.csv")
