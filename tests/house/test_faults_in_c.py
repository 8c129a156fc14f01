"""The faults that are drawn in C: all of them, and each what it says."""

from __future__ import annotations

from checks.c_faults import changed, faults_in

TEXT = """\
#include "a<b.h"
#define LIMIT 3u
/* a > b; */
static float half(float x, const float *at)
{
    if (x < 0.5f && !at)
        return -x;
    for (int i = 0; i < 2; i++)
        x = x * at[i]; // twice
    return x;
}
#ifdef MW_FAULT_INJECTION
static int broken = 1 + 1;
#endif
"""


def changes(kind: str) -> list[str]:
    """Return the lines that faults of a kind change, as they are then."""
    found = []
    for occurrence, fault in enumerate(faults_in(TEXT)):
        before, after = TEXT.splitlines(), changed(TEXT, occurrence).splitlines()
        if fault.kind == kind:
            found += [new.strip() for old, new in zip(before, after, strict=True) if old != new]
    return found


def test_each_kind_is_drawn_where_it_is_and_nowhere_else() -> None:
    assert changes("< to <=") == ["if (x <= 0.5f && !at)", "for (int i = 0; i <= 2; i++)"]
    assert changes("&& to ||") == ["if (x < 0.5f || !at)"]
    assert changes("* to /") == ["x = x / at[i]; // twice"]
    assert changes("without !") == ["if (x < 0.5f && at)"]
    assert changes("without -") == ["return x;"]
    assert changes("not") == ["if (!(x < 0.5f && !at))"]
    assert changes("loop without a round") == ["for (int i = 0; 0; i++)"]
    assert changes("without the statement") == ["{ } // twice"]


def test_numbers_are_one_more_and_one_less_but_never_below_an_unsigned_zero() -> None:
    assert changes("number +1") == [
        "#define LIMIT 4u",
        "if (x < 1.5f && !at)",
        "for (int i = 1; i < 2; i++)",
        "for (int i = 0; i < 3; i++)",
    ]
    assert changes("number -1")[:2] == ["#define LIMIT 2u", "if (x < -0.5f && !at)"]
    assert not [fault for fault in faults_in("x = 0u;") if fault.kind == "number -1"]


def test_comments_other_directives_and_test_images_are_left_out() -> None:
    assert {fault.kind for fault in faults_in(TEXT)} == {
        *("< to <=", "&& to ||", "* to /", "without !", "without -", "not"),
        *("loop without a round", "without the statement", "number +1", "number -1"),
    }
