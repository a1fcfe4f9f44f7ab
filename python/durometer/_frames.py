"""Results as pandas tables."""

from typing import Any

from ._extras import extra


def of_run(run: Any) -> Any:
    """Returns a copy of the rows of a run, indexed by time."""
    pandas = extra("pandas", "pandas")
    frame = pandas.DataFrame(run.values, columns=run.columns, copy=True).set_index("t_s")
    frame.attrs["units"] = run.units
    return frame


def of_sensitivities(found: Any) -> Any:
    """Returns a copy of the derivatives, indexed by time, with columns labelled (column, key)."""
    pandas = extra("pandas", "pandas")
    columns = pandas.MultiIndex.from_product([found.columns, found.keys], names=["column", "key"])
    index = pandas.Index(found.times.copy(), name="t_s")
    return pandas.DataFrame(found.values.reshape(len(index), -1), index=index, columns=columns, copy=True)


def of_constants(fit: Any) -> Any:
    """Returns the constants with their units and intervals."""
    pandas = extra("pandas", "pandas")
    ends = [fit.intervals[name] or (float("nan"), float("nan")) for name in fit.constants]
    rows = {
        "value": list(fit.constants.values()),
        "lower": [end[0] for end in ends],
        "upper": [end[1] for end in ends],
        "unit": [fit.units[name] for name in fit.constants],
    }
    return pandas.DataFrame(rows, index=pandas.Index(list(fit.constants), name="constant"))
