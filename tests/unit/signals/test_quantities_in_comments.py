import pytest

from musclewire.signals._units import quantity_with_suffix


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1.0 ohm", (1.0, "_ohm")),
        ("100 mm", (0.1, "_m")),
        ("1.7 N", (1.7, "_n")),
        ("4 %", (0.04, "")),
        ("1.7", None),
        ("Flexinol 125", None),
        ("2024-01-01", None),
        ("25 C", (298.15, "_k")),
        ("5 pF", None),
    ],
)
def test_a_quantity_in_a_comment_gives_its_value_and_the_suffix_of_its_name(text, expected):
    found = quantity_with_suffix(text)
    assert found == (expected if expected is None else (pytest.approx(expected[0]), expected[1]))
