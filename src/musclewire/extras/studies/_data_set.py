"""The data set of a study: one Parquet file, read as xarray. Needs the extra ``sweep``."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, require_extra
from musclewire.extras.studies._plan import Plan, engine
from musclewire.extras.studies._run_kind import OVERHEATED, Overheated
from musclewire.signals import write_whole

if TYPE_CHECKING:
    import xarray as xr

# Key of the file's own metadata, as JSON: what the study was, with units and meanings.
KEY = b"musclewire-study"
ERROR = "error"
# Column of the runs whose wires went beyond their limits; a data set without one has none.
OVERHEATED_K = "overheated_k"
RESULT = " (result)"
DATA = "data.parquet"


def write_data(
    path: Path,
    plan: Plan,
    columns: Mapping[str, FloatArray],
    errors: Sequence[str],
    texts: Mapping[str, Sequence[str]],
    overheated: Sequence[Overheated] = (),
) -> None:
    """Write all runs as one Parquet file, whole or not at all: a row for each run, with error and overheating."""
    require_extra("a study's data set", "sweep")
    import pyarrow as pa
    from pyarrow import parquet

    named: dict[str, Any] = {name: pa.array(plan.design.column(name)) for name in plan.design.names}
    for name, values in columns.items():
        if values.ndim == 1:
            named[quantity_name(name, plan)] = pa.array(values)
        else:
            flat = pa.array(np.ascontiguousarray(values).ravel())
            named[quantity_name(name, plan)] = pa.FixedSizeListArray.from_arrays(flat, values.shape[1])
    named |= {quantity_name(name, plan): pa.array(list(found)) for name, found in texts.items()}
    named[ERROR] = pa.array(list(errors))
    known = description(plan)
    if overheated:
        hottest_k = {one.run: one.temperature_max_k for one in overheated}
        named[OVERHEATED_K] = pa.array([hottest_k.get(run) for run in range(len(errors))], pa.float64())
        known[OVERHEATED] = [one._asdict() for one in overheated]
    table = pa.table(named).replace_schema_metadata({KEY: json.dumps(known).encode()})
    # One writer, no time of day: the same study gives the same bytes.
    write_whole(path, lambda part: parquet.write_table(table, part, compression="zstd"))


def quantity_name(name: str, plan: Plan) -> str:
    """Return the column of a quantity; one that varies, too, has another name than the parameter."""
    return f"{name}{RESULT}" if name in plan.design.names else name


def description(plan: Plan) -> dict[str, Any]:
    """Return what a data set says of its study."""
    design = plan.design
    return {
        "name": plan.file.name,
        "description": plan.file.description,
        "fingerprint": plan.fingerprint,
        "engine": engine(),
        "method": design.method,
        "seed": plan.file.seed,
        "study": plan.file.model_dump(mode="json", exclude_none=True),
        "axes": {axis.name: list(axis.values) for axis in design.axes},
        "samples": len(design.samples),
        "parameters": design.units,
        "quantities": {
            quantity_name(name, plan): {"unit": item.unit, "meaning": item.meaning, "text": item.is_text}
            for name, item in plan.keep.items()
        },
    }


def data_set_of(
    plan: Plan,
    columns: Mapping[str, FloatArray],
    errors: Sequence[str],
    texts: Mapping[str, Sequence[str]],
    overheated: Sequence[Overheated] = (),
) -> xr.Dataset:
    """Return all runs as xarray, as ``read_study_data`` returns them from the file."""
    values = {name: plan.design.column(name) for name in plan.design.names}
    found: dict[str, Any] = {**columns, **{name: np.array(column, dtype=str) for name, column in texts.items()}}
    quantities = {quantity_name(name, plan): found[name] for name in plan.keep}
    known = {**description(plan), OVERHEATED: [one._asdict() for one in overheated]}
    return built(known, values, quantities, list(errors))


def read_study_data(path: str | Path) -> xr.Dataset:
    """Return the data set of a study.

    Parameters
    ----------
    path
        The file ``data.parquet``, or the folder of the study.

    Returns
    -------
    Quantities as variables over ``run`` (a series also over ``sample``), parameters as coordinates, both with their
    units; the message of each run's error; the study in the attributes. ``on_grid`` makes the grid's axes dimensions.

    Raises
    ------
    MissingExtraError
        If the extra ``sweep`` is not installed.
    CallerError
        For another file.
    """
    require_extra("a study's data set", "sweep")
    table, known = read_table(Path(path) / DATA if Path(path).is_dir() else Path(path))
    values = {name: table.column(name).to_numpy() for name in known["parameters"]}
    quantities = {
        name: np.array(table.column(name).to_pylist(), dtype=str) if item.get("text") else numbers(table.column(name))
        for name, item in known["quantities"].items()
    }
    return built(known, values, quantities, table.column(ERROR).to_pylist())


def read_columns(
    file: Path,
) -> tuple[dict[str, FloatArray], tuple[str, ...], dict[str, tuple[str, ...]], tuple[Overheated, ...]]:
    """Return the quantities over the runs, by their names in the study, each run's error, texts, and too hot runs."""
    table, known = read_table(file)
    columns, texts = {}, {}
    for name, item in known["quantities"].items():
        if item.get("text"):
            texts[name.removesuffix(RESULT)] = tuple(table.column(name).to_pylist())
        else:
            columns[name.removesuffix(RESULT)] = numbers(table.column(name))
    return (
        columns,
        tuple(table.column(ERROR).to_pylist()),
        texts,
        tuple(Overheated(**one) for one in known.get(OVERHEATED, ())),
    )


def read_table(file: Path) -> tuple[Any, dict[str, Any]]:
    """Return the table in a file, and what it says of its study."""
    require_extra("a study's data set", "sweep")
    import pyarrow as pa
    from pyarrow import parquet

    try:
        table = parquet.ParquetFile(file).read()
        known: dict[str, Any] = json.loads(table.schema.metadata[KEY])
    except (OSError, pa.ArrowException, KeyError, TypeError, ValueError) as problem:
        raise CallerError(
            f"{file} is no data set of a study ({' '.join(str(problem).split())}): give a .parquet that a study wrote"
        ) from None
    return table, known


def numbers(column: Any) -> FloatArray:
    """Return a column of numbers, (n_runs,), or of lists, (n_runs, n_samples)."""
    import pyarrow as pa

    if not pa.types.is_fixed_size_list(column.type):
        return np.asarray(column.to_numpy(), dtype=np.float64)
    parts = [part.flatten().to_numpy() for part in column.chunks]
    return np.concatenate(parts).reshape(len(column), column.type.list_size)


def built(
    known: Mapping[str, Any], values: Mapping[str, Any], quantities: Mapping[str, Any], errors: list[str]
) -> xr.Dataset:
    """Return a data set from its parts."""
    require_extra("a study's data set", "sweep")
    import xarray as xr

    coordinates = {
        name: (
            "run",
            column if column.dtype.kind in "fbiu" else column.astype(str),
            attributes(known["parameters"][name]),
        )
        for name, column in values.items()
    }
    variables: dict[str, Any] = {
        name: (("run", "sample")[: column.ndim], column, {**attributes(item["unit"]), "long_name": item["meaning"]})
        for (name, column), item in ((pair, known["quantities"][pair[0]]) for pair in quantities.items())
    }
    variables[ERROR] = ("run", np.array(errors, dtype=str))
    plain = ("name", "description", "fingerprint", "engine", "method", "seed", "samples")
    notes = {
        **{key: known[key] for key in plain},
        "axes": json.dumps(known["axes"]),
        "study": json.dumps(known["study"]),
        **({OVERHEATED: json.dumps(known[OVERHEATED])} if known.get(OVERHEATED) else {}),
    }
    return xr.Dataset(variables, coordinates, notes)


def attributes(unit: str) -> dict[str, str]:
    """Return the attributes of a variable with a unit, none without one."""
    return {"units": unit} if unit else {}


def on_grid(data: xr.Dataset) -> xr.Dataset:
    """Return a study's data set with the axes of its grid as dimensions.

    Parameters
    ----------
    data
        What ``read_study_data`` has returned.

    Returns
    -------
    The same numbers: each axis of the grid is a dimension, and ``draw`` counts the samples at each of its points. A
    sampled parameter varies along ``draw`` only.
    """
    import xarray as xr

    axes = json.loads(data.attrs["axes"])
    dimensions = (*axes, "draw")
    shape = (*(len(values) for values in axes.values()), int(data.attrs["samples"]))
    variables = {
        str(name): ((*dimensions, *item.dims[1:]), item.values.reshape(*shape, *item.shape[1:]), item.attrs)
        for name, item in data.data_vars.items()
    }
    coordinates: dict[str, Any] = {name: (name, values, data[name].attrs) for name, values in axes.items()}
    for name in data.coords:
        if name not in axes:
            drawn = data[name].values[: shape[-1]]
            coordinates[str(name)] = ("draw", drawn, data[name].attrs)
    return xr.Dataset(variables, coordinates, data.attrs)
