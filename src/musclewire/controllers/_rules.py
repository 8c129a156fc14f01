"""Rule bases as data: the fuzzy tables, from TOML files, checked before use.

A rule base maps two inputs in [-1, 1], the error and its change, to three ratios in [0, 1], one for each
gain range of the paper's Eq. 6. The paper prints no rules, so several published sets come with the package,
each with its source:

- ``zhao-1993`` (the default): Zhao, Tomizuka, Isaka 1993, doi 10.1109/21.260670; the same tuning for both
  directions.
- ``liu-7x7``: the widespread self-tuning tables; nearly antisymmetric, so the two directions are tuned
  oppositely.
- ``liu-7x7-mirrored``: the same, read at ``(-|e|, -sign(e) de)``, so that both directions are tuned alike.
- ``fixed``: all ratios 0.5, no fuzzy tuning.

A user's own file has the same form; pass its path to ``load_rule_base``.
"""

from __future__ import annotations

import tomllib
from functools import cache
from importlib import resources
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias, get_args

from pydantic import BeforeValidator, Field, model_validator

from musclewire.controllers._schema import StrictModel
from musclewire.errors import CallerError, nearest_hint
from musclewire.small_files import read_small, toml_of

DEFAULT_RULE_BASE = "zhao-1993"
SetName: TypeAlias = Literal["NB", "NM", "NS", "ZO", "PS", "PM", "PB"]
SET_NAMES: tuple[SetName, ...] = get_args(SetName)


def _split_rows(table: Any) -> Any:
    """Turn seven lines such as "B B S S S B B" into a 7x7 table; the schema judges anything else."""
    if not isinstance(table, list):
        return table
    rows = [row.split() if isinstance(row, str) else row for row in table]
    widths = [len(row) for row in rows if isinstance(row, list)]
    if len(rows) != 7 or widths != [7] * 7:
        raise ValueError(f"must be 7 rows of 7 cells, not {len(rows)} rows of {sorted(set(widths))} cells")
    return rows


Size: TypeAlias = Literal["S", "B"]
SizeTable: TypeAlias = Annotated[tuple[tuple[Size, ...], ...], BeforeValidator(_split_rows)]
LabelTable: TypeAlias = Annotated[tuple[tuple[SetName, ...], ...], BeforeValidator(_split_rows)]
AlphaTable: TypeAlias = Annotated[
    tuple[tuple[Annotated[float, Field(ge=2.0, le=5.0)], ...], ...], BeforeValidator(_split_rows)
]


class MembershipSet(StrictModel):
    """One fuzzy set on the universe -3..3.

    ``triangle`` has three points (foot, peak, foot). ``z`` falls from 1 at its first point to 0 at its
    second, ``s`` rises from 0 to 1, both along two parabolas, like the functions of these names in other libraries.
    """

    shape: Literal["triangle", "z", "s"]
    points: tuple[float, ...]

    @model_validator(mode="after")
    def _points_fit_the_shape(self) -> MembershipSet:
        needed = 3 if self.shape == "triangle" else 2
        if len(self.points) != needed:
            raise ValueError(f"a {self.shape} needs {needed} points, not {len(self.points)}")
        if any(right <= left for left, right in pairwise(self.points)):
            raise ValueError(f"the points must increase, not {list(self.points)}")
        return self


SetTable: TypeAlias = dict[SetName, MembershipSet]


def _check_all_sets(sets: SetTable, what: str) -> None:
    missing = [name for name in SET_NAMES if name not in sets]
    if missing:
        raise ValueError(f"{what} lacks {', '.join(missing)}: give all of {', '.join(SET_NAMES)}")


class ZhaoRules(StrictModel):
    """Product implication and weighted sum over the logarithmic sets Small and Big (Zhao et al. 1993).

    mu_S(x) = -ln(x)/4 and mu_B(x) = -ln(1-x)/4 are inverted exactly: a rule that fires with mu contributes
    x_S = exp(-4 mu) or x_B = 1 - exp(-4 mu), weighted by mu.
    """

    inference: Literal["product-weighted-sum"]
    kp: SizeTable
    kd: SizeTable
    alpha: AlphaTable


class MamdaniRules(StrictModel):
    """Minimum for "and" and for implication, maximum to join, centroid over 101 points of -3..3."""

    inference: Literal["min-max-centroid"]
    kp: LabelTable
    ki: LabelTable
    kd: LabelTable
    output_sets: SetTable

    @model_validator(mode="after")
    def _all_output_sets(self) -> MamdaniRules:
        _check_all_sets(self.output_sets, "output_sets")
        return self


class ConstantRules(StrictModel):
    """The same three ratios everywhere."""

    inference: Literal["constant"]
    kp: Annotated[float, Field(ge=0.0, le=1.0)]
    ki: Annotated[float, Field(ge=0.0, le=1.0)]
    kd: Annotated[float, Field(ge=0.0, le=1.0)]


class RuleBase(StrictModel):
    """A fuzzy rule base: its tables, how they are inferred, and where they are from.

    Parameters
    ----------
    name
        Its name on the command line.
    title
        Description in a few words.
    source
        The publication.
    licence
        Licence of the tables.
    notes
        Remarks for the reader.
    mirrored
        Makes both directions alike by reading one half of the tables only: "positive-error" at
        ``(|e|, sign(e) de)``, "negative-error" at ``(-|e|, -sign(e) de)``, with sign(0) = 0. "no" reads
        the tables as printed.
    input_sets
        The seven membership functions of both inputs by name; none for constant rules.
    rules
        The tables, and how they are combined.
    """

    name: str
    title: str
    source: str
    licence: str
    notes: str = ""
    mirrored: Literal["no", "positive-error", "negative-error"] = "no"
    input_sets: SetTable = Field(default_factory=dict)
    rules: Annotated[ZhaoRules | MamdaniRules | ConstantRules, Field(discriminator="inference")]

    @model_validator(mode="after")
    def _all_input_sets(self) -> RuleBase:
        if not isinstance(self.rules, ConstantRules):
            _check_all_sets(self.input_sets, "input_sets")
        return self

    def __str__(self) -> str:
        """Return name, title and source in one line."""
        return f"{self.name}: {self.title} ({self.source})"


def rule_base_names() -> tuple[str, ...]:
    """Return the names of the package's rule bases, the default first."""
    names = sorted(path.name.removesuffix(".toml") for path in _folder().iterdir() if path.name.endswith(".toml"))
    return (DEFAULT_RULE_BASE, *(name for name in names if name != DEFAULT_RULE_BASE))


def load_rule_base(name: str | Path = DEFAULT_RULE_BASE) -> RuleBase:
    """Return a rule base by its name, or from a user's file.

    Parameters
    ----------
    name
        One of :func:`rule_base_names`, or a TOML file: a ``Path``, or a text that ends in .toml. The default is
        the rule base that the closed loop uses.

    Returns
    -------
    The rule base, checked.

    Raises
    ------
    CallerError
        If there is no such name or file, or it holds no rule base; the message names the key.
    """
    if isinstance(name, Path) or name.endswith(".toml"):
        path = Path(name)
        return parse_rule_base(read_small(path, "rule base"), where=str(path))
    return _built_in(name)


def parse_rule_base(text: str, where: str = "rule base") -> RuleBase:
    """Return the checked rule base of a TOML text, which may derive from one of the package's."""
    values = toml_of(text, where)
    try:
        return RuleBase(**_with_parent(values))
    except CallerError as error:
        raise CallerError(f"{where}: {error}") from None


@cache
def _built_in(name: str) -> RuleBase:
    return parse_rule_base(_text(name), where=f"{name}.toml")


def _text(name: str) -> str:
    if name not in rule_base_names():
        raise CallerError(f"unknown rule base '{name}'{nearest_hint(name, rule_base_names())}")
    text: str = (_folder() / f"{name}.toml").read_text(encoding="utf-8")
    return text


def _with_parent(values: dict[str, Any]) -> dict[str, Any]:
    parent = values.get("derives_from")
    if parent is None:
        return values
    own = {key: value for key, value in values.items() if key != "derives_from"}
    return {**_with_parent(tomllib.loads(_text(str(parent)))), **own}


def _folder() -> Any:
    return resources.files("musclewire.controllers") / "data" / "rules"
