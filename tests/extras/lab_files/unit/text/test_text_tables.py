import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.errors import RecordingError
from musclewire.files import ImportMapping, read_recording
from musclewire.identify import import_recording

PLAIN = "time_s,force_n\n0,1.5\n1,2.5\n"


@pytest.fixture
def file(tmp_path):
    def write(text, name="loop.csv", encoding="utf-8"):
        path = tmp_path / name
        path.write_bytes(text.encode(encoding))
        return path

    return write


def refusal(path, **options):
    with pytest.raises(RecordingError) as caught:
        read_recording(path, **options)
    message = str(caught.value)
    assert "\n" not in message
    return message.replace(f"{path}: ", "", 1)


def test_commas_between_thousands_show_where_smaller_numbers_have_none(file):
    recording = read_recording(file("time [s]\tForce [mN]\n0.5\t998\n1.0\t1,002\n1.5\t1,250\n"))
    assert recording["force_n"].tolist() == pytest.approx([0.998, 1.002, 1.25])
    with pytest.raises(RecordingError, match="'1,000' is not a number"):
        read_recording(file("time [s]\tForce [mN]\n0.5\t1,000\n1.0\t1,002\n1.5\t1,250\n"))


def test_a_point_among_decimal_commas_is_no_decimal_sign_and_an_apostrophe_none_at_all(file):
    path = file("Zeit (s);Kraft (mN)\n0,5;998\n1,0;1.002\n1,5;1.250\n")
    assert refusal(path) == "line 3, column 'Kraft (mN)': '1.002' is not a number; correct it or remove the line"
    recording = read_recording(file("Time (s),Force (mN)\n0.5,998\n1.0,1'002\n1.5,1'250\n"))
    assert recording["force_n"].tolist() == pytest.approx([0.998, 1.002, 1.25])


def test_a_comma_between_thousands_is_never_a_decimal_comma(file):
    path = file("time_s;force_n\n0.5;1,234\n1.5;1,235\n")
    assert refusal(path) == "line 2, column 'force_n': '1,234' is not a number; correct it or remove the line"


def test_comments_before_the_table_are_metadata(file):
    comments = (
        "# wire = 125 um Flexinol\n# Shunt resistance = 1.0 ohm\n# pretension [gf] = 100\n# count = 3\n"
        "# gain = 2.5\n# pulse = true\n# operator = none\n# see https://example.org\n"
        "# software_version = 0.10\n"
        '# quoted = "1.0"\n# wire_length = 100 mm\n# format = odd\n# = 4\n'
    )
    assert dict(read_recording(file(comments + PLAIN)).metadata) == {
        "wire": "125 um Flexinol",
        "shunt_resistance_ohm": 1.0,
        "pretension_n": pytest.approx(0.980665),
        "count": 3,
        "gain": 2.5,
        "pulse": True,
        "operator": None,
        "software_version": "0.10",
        "quoted": "1.0",
        "wire_length_m": pytest.approx(0.1),
        "file_format": "odd",
    }


@pytest.mark.parametrize("cell", ["abc", "1_000", "0x10", "1.2.3", "--1"])
def test_what_is_no_number_is_found_by_line_and_column(file, cell):
    message = refusal(file(f"# rig = a\ntime_s,force_n\n0,1\n\n1,{cell}\n2,3\n"))
    end = ", or leave such rows out (drop_missing=True)" if cell == "abc" else ""
    assert message == f"line 5, column 'force_n': '{cell}' is not a number; correct it or remove the line{end}"


@pytest.mark.parametrize("row", ["1,", "1, ", "1"])
def test_a_blank_cell_is_found_by_line_and_column(file, row):
    message = refusal(file(f"time_s,force_n\n0,1\n{row}\n2,3\n"))
    assert message.startswith("line 3, column '")
    assert "the cell is blank" in message


@pytest.mark.parametrize("cell", ["nan", "NaN", "n/a", "#N/A", "--", "OL"])
def test_a_missing_number_is_found_and_left_out_if_asked_for(file, cell):
    path = file(f"time_s,force_n\n0,1\n1,{cell}\n2,3\n")
    assert "line 3, column 'force_n': the cell is blank or NaN; correct it, or leave such rows out" in refusal(path)
    assert read_recording(path, mapping=ImportMapping(drop_missing=True))["time_s"].tolist() == [0.0, 2.0]


cells = st.sampled_from(["0", "1.5", "-2,5", "", "nan", "x", '"', '"a"', "1e3", "#", "time_s", "force_n", "t [s]"])
scraps = st.lists(cells | st.text(max_size=6) | st.sampled_from([",", ";", "\t", "\n", " ", "\n# a = 1 ohm\n"]))


@settings(max_examples=300, deadline=None)
@given(scraps.map("".join), st.sampled_from([".csv", ".txt", ".tsv"]))
def test_no_text_at_all_ends_in_anything_but_a_recording_or_one_line(text, suffix):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"scraps{suffix}"
        for beginning in ("time_s,force_n\n", "", "# a remark\n"):
            path.write_bytes((beginning + text).encode("utf-8", "replace"))
            message = ""
            try:
                assert len(read_recording(path)) >= 2
            except RecordingError as problem:
                message = str(problem)
            assert "\n" not in message


def test_a_large_file_is_read_as_a_small_one_wherever_it_stops_being_plain(file, monkeypatch):
    rows = [f"{number * 0.1:.1f},{number % 7 * 0.5}" for number in range(400)]
    rows[250] = '"25.0",2.5'
    text = "time_s,force_n\n" + "\n".join(rows)
    small = read_recording(file(text, "small.csv"))
    monkeypatch.setattr("musclewire.extras.lab_files._text_tables._LARGE", 1)
    monkeypatch.setattr("musclewire.extras.lab_files._plain_rows._PIECE", 500)
    assert read_recording(file(text, "large.csv")) == small
    assert "line 302, column 'force_n': 'x' is not a number" in refusal(
        file(text.replace("30.0,3.0", "30.0,x"), "bad.csv")
    )


ROWS = [f"{0.1 * number:.1f},{1.5 + number:.3f}" for number in range(12)]


@pytest.mark.parametrize("rule", ["-------- ---------", "========"])
def test_a_rule_below_names_with_blanks_is_none_of_them(file, rule):
    rows = [row.replace(",", "  ") for row in ROWS]
    assert read_recording(file("\n".join(["Time [s]  Force [N]", rule, *rows, ""]), "rule.txt"))["force_n"][0] == 1.5


def test_a_cell_beyond_the_names_is_refused_with_its_own_line(file):
    path = file("\n".join(["time_s,force_n", *(f"{row}," for row in ROWS), "1.2,13.5,F"]))
    assert "line 14 has 3 cells for 2 headers" in refusal(path)


def test_a_damaged_name_among_lines_of_values_hides_no_row(file):
    prints = "".join("Time: {} s\nForce: {} N\n".format(*row.split(",")) for row in ROWS).replace(
        "Time: 0.5", "Tixe: 0.5"
    )
    found = read_recording(file(prints, "prints.txt"), mapping=ImportMapping(drop_missing=True))
    assert found["force_n"].tolist() == [1.5 + number for number in range(12) if number != 5]


@pytest.mark.parametrize(
    ("lines", "rows", "said"),
    [
        ([*ROWS[:5], "READY", *ROWS[5:]], 12, "a line that is no row left out, as line 7: 'READY'"),
        ([*ROWS, "", ",Min,Max", "CH1,0,3"], 12, "2 lines that are no rows left out, as line 15"),
        ([*ROWS, "1.2,13.5"], 12, "the file is cut off in line 14, which is left out"),
        ([*ROWS, "1.2"], 12, "the file is cut off in line 14, which is left out"),
        ([*ROWS, "1.2,13.500"], 13, ""),
    ],
)
def test_lines_that_are_no_rows_are_left_out_with_their_number(file, lines, rows, said):
    understood = import_recording(file("\n".join(["time_s,force_n", *lines])))
    assert (understood.problem, understood.row_count) == ("", rows)
    assert said in "; ".join(understood.notes)


@pytest.mark.parametrize(
    ("head", "units"),
    [
        (["Model,X", "Unit of Load,mN", "Time [s],Load"], 1e-3),
        (["Model,X", "Time,Load", "s,mN"], 1e-3),
        (["Model,X", "Horizontal Units,s", "Vertical Units,CH1:mN,", "Time,Load"], 1e-3),
        (["Model,X", "Unit of Torque,mN", "Time [s],Load [N]"], 1.0),
    ],
)
def test_a_unit_counts_wherever_the_file_states_it(file, head, units):
    recording = read_recording(file("\n".join([*head, *ROWS, ""])))
    assert recording["force_n"][1] == pytest.approx(2.5 * units)


def test_headers_that_stand_once_more_begin_a_test_unless_the_clock_goes_on(file):
    pages = ["time_s,force_n", *ROWS[:6], "time_s,force_n", *ROWS[6:], ""]
    assert len(read_recording(file("\n".join(pages)))) == 12
    tests = ["time_s,force_n", *ROWS[:5], "time_s,force_n", *ROWS, ""]
    assert "2 tests are below each other" in refusal(file("\n".join(tests)))
    assert len(read_recording(file("\n".join(tests)), group="test 2")) == 12


def test_two_units_that_a_file_states_of_one_column_are_refused_with_both(file):
    text = "\n".join(["Unit of Load [N],mN", "Time [s],Load [N]", *ROWS, ""])
    assert "states N, and apart from it the file states mN" in refusal(file(text))
