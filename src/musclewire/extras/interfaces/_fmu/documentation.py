"""documentation/index.html of an FMU: what it is, its variables, what it does not contain."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from musclewire.extras.interfaces._fmu.description import ModelDescription
from musclewire.extras.interfaces._fmu.variables import FmuVariable, FmuVariables

__all__ = ["documentation_page"]

PAGE = """<!DOCTYPE html>
<html lang="en">
<head><meta charset="utf-8"><title>{name}</title></head>
<body>
<h1>{name}</h1>
<p>{title}</p>
<p>Written by musclewire (musclewire export fmu). FMI 2.0, co-simulation, GUID {guid}. SI units throughout; the unit
ends each name. Inputs are held over a communication step, so no output depends on an input of its own communication
point. The communication step that fits the rig is {step_s:g} s.</p>
<h2>Variables</h2>
<table border="1">
<tr><th>name</th><th>role</th><th>unit</th><th>start</th><th>meaning</th></tr>
{rows}
</table>
<h2>Not in it</h2>
<ul>
{left_out}
</ul>
<h2>Messages</h2>
<ul>
{owners}
</ul>
<h2>Compile it</h2>
<p>All C files of sources/, C99, no library beyond C's own: <code>cc -std=c99 -O2 -ffp-contract=off -fPIC -shared
sources/*.c -o {name}.so</code>. Without -ffp-contract=off a compiler may fuse a product and a sum, and results then
differ in the last digits from those tested.</p>
</body>
</html>
"""


def documentation_page(about: ModelDescription, variables: FmuVariables, left_out: Sequence[str]) -> str:
    """Return the page of an FMU."""
    return PAGE.format(
        name=escape(about.name),
        title=escape(about.title),
        guid=escape(about.guid),
        step_s=about.step_s,
        rows="\n".join(row(variable) for variable in variables.ordered),
        left_out="\n".join(f"<li>{escape(text)}</li>" for text in left_out),
        owners="\n".join(f"<li>{escape(owner)}: {escape(meaning)}</li>" for owner, meaning in about.log_owners),
    )


def row(variable: FmuVariable) -> str:
    """Return the row of a variable."""
    start = "" if variable.role == "output" else f"{variable.start:g}"
    cells = (variable.name, variable.role, variable.unit, start, variable.meaning)
    return "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>"
