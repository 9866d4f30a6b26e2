"""A run in other forms: one table (CSV, Parquet), or its log made whole again (MCAP)."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.bridge.log_file import LogFile
from mobius.bridge.read_log import find_log, read_log
from mobius.bridge.read_run import Run, open_run
from mobius.bridge.to_ros import time_ns
from mobius.errors import InvalidInput, MissingDependency, MobiusError, UnknownName
from mobius.files import write_bytes_atomic
from mobius.model.joints import JOINTS
from mobius.types import LIMBS

__all__ = ["FORMS", "build_table", "export"]

_AS_IT_IS = {
    "rerun": "Rerun opens the log as it is; type: rerun {log}",
    "foxglove": "Foxglove opens the log as it is: drop {log} on its window",
    "rosbag": "ROS 2 plays the log as it is; type: ros2 bag play {log}",
    "lerobot": "nothing here writes that form; --to parquet gives the same numbers, a row a sample",
}
_XYZ = ("x", "y", "z")


def export(path: str | Path, to: str, out: str | Path | None = None) -> Path:
    """Write a run in another form; the file is whole or absent.

    Args:
        path: The folder of a run, or a ``.mcap`` file.
        to: One of :data:`FORMS`.
        out: A file that does not exist; beside the run, named after it, if not given.

    Returns:
        The file.

    Raises:
        UnknownName: There is no such form.
        InvalidInput: The run cannot be read, the form needs no export, or the file exists.
        MissingDependency: ``parquet`` without pyarrow.
    """
    log = find_log(path)
    if to in _AS_IT_IS:
        raise InvalidInput(f"--to {to}: {_AS_IT_IS[to].format(log=log)}")
    if to not in FORMS:
        raise UnknownName("form", to, FORMS)
    stem = log.parent.resolve() if log.name == "run.mcap" else log.with_suffix("")
    ending = ".whole.mcap" if to == "mcap" else f".{to}"
    target = Path(out) if out is not None else stem.with_name(stem.name + ending)
    if target.exists():
        raise InvalidInput(f"{target} exists; choose another --out")
    data = FORMS[to](log)
    try:
        write_bytes_atomic(target, data)
    except OSError as error:
        raise MobiusError(f"{target} cannot be written ({error.strerror})") from None
    return target


def build_table(run: Run) -> dict[str, NDArray[Any]]:
    """Columns of n rows, the unit in each name; what was not recorded is left out."""
    table: dict[str, NDArray[Any]] = {"t_s": run.t, "mode": np.array(run.modes, dtype=object)}

    def add(names: list[str], values: NDArray[np.float64] | None) -> None:
        if values is not None:
            table.update(zip(names, values.reshape(len(run), -1).T, strict=True))

    add([f"{j}_rad" for j in JOINTS], run.q)
    add([f"{j}_radps" for j in JOINTS], run.dq)
    add([f"{j}_Nm" for j in JOINTS], run.torque)
    add([f"{j}_target_rad" for j in JOINTS], run.q_target)
    for whose in ("true", "believed"):
        track = getattr(run, whose)
        if track is not None:
            add([f"{whose}_{a}_m" for a in _XYZ], track.p_M)
            add([f"{whose}_q{a}" for a in "wxyz"], track.q_M)
            add(_twist(whose), track.twist_H)
    add(_twist("cmd"), run.cmd_twist_H)
    add([f"{limb}_contact" for limb in LIMBS], run.contact)
    parts = [f"{k}{a}_{unit}" for k, unit in (("f", "N"), ("t", "Nm")) for a in _XYZ]
    add([f"{side}_wrist_{part}" for side in ("left", "right") for part in parts], run.wrench_S)
    add([f"gyro_{a}_radps" for a in _XYZ], run.gyro_I)
    add([f"accel_{a}_mps2" for a in _XYZ], run.accel_I)
    table["power_W"] = run.power
    return table


def _twist(whose: str) -> list[str]:
    return [f"{whose}_vx_mps", f"{whose}_vy_mps", f"{whose}_wz_radps"]


def _csv(log: Path) -> bytes:
    """Numbers in the shortest form that reads back as the same float64."""
    table = build_table(open_run(log))
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(table)
    writer.writerows(zip(*(column.tolist() for column in table.values()), strict=True))
    return text.getvalue().encode()


def _parquet(log: Path) -> bytes:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise MissingDependency("pyarrow", "sweep", "export --to parquet") from None
    run = open_run(log)
    rows = pyarrow.table(build_table(run)).replace_schema_metadata(run.about.as_record())
    sink = pyarrow.BufferOutputStream()
    parquet.write_table(rows, sink)
    return bytes(sink.getvalue())


def _mcap(log: Path) -> bytes:
    """The same messages with an index: what readers want that do not open a cut-off log."""
    found = read_log(log)
    rows = [(t, name, data) for name, said in found.messages.items() for t, data in said]
    if not rows:
        raise InvalidInput(f"{log}: nothing in it can be read")
    stream = io.BytesIO()
    file = LogFile(stream, about=found.about, live=False)
    for t, name, data in sorted(rows, key=lambda row: row[0]):
        file.write(name, time_ns(t), data)
    file.finish()
    return stream.getvalue()


FORMS: dict[str, Callable[[Path], bytes]] = {"csv": _csv, "parquet": _parquet, "mcap": _mcap}
"""What a run can be exported to."""
