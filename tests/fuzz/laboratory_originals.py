"""Small measurements of every kind of the laboratory, and how they are damaged."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import scipy.io
import xarray as xr

from tests.fuzz.damaged_files import damaged
from tests.fuzz.laboratory_images import Images
from tests.fuzz.laboratory_original import CELLS, Damaged, Original
from wroll_fem.lab.fits.family_file import read_families
from wroll_fem.lab.fits.synthetic_roll import measured_family, write_backbones
from wroll_fem.lab.shaker.synthetic import oscillator_tip
from wroll_fem.lab.shear.simulated import ramp, sine_loops, velocity_steps
from wroll_fem.results.dataset import save_dataset
from wroll_fem.signals.random.random_motion import random_record
from wroll_fem.tribology import RateAndState, ShearTest

Columns = dict[str, np.ndarray]

NAMES = ("", "tim", "TIME", "time ", "base", "1", "täst", "a" * 300, "nan", "time", "force", "tension")
SCALES = (0.0, -1.0, 1e-300, 1e-30, 1e-9, 1e-3, 1e3, 1e9, 1e30, 1e155, 1e300)
"""Factors of a whole column: wrong units, and numbers whose squares overflow or vanish."""


def changed(columns: Columns, chance: random.Random) -> Columns:
    """One change of the numbers of a record."""
    found = {name: values.copy() for name, values in columns.items()}
    name = chance.choice(list(found))
    values, count = found[name], len(found[name])
    at = chance.randrange(max(count, 1))
    what = chance.randrange(15)
    if what == 0:
        del found[name]
    elif what == 1 and count:
        values[at] = chance.choice((np.nan, np.inf, -np.inf, 1e308, -1e308, 0.0, 1e30, -1e12, 5e-324))
    elif what == 2 and count:
        values[at : at + chance.choice((2, 20, 10**6))] = chance.choice((np.nan, 0.0, 1e300, values[at]))
    elif what == 3:
        with np.errstate(over="ignore"):
            found[name] = values * chance.choice(SCALES)
    elif what == 4:
        found[name] = values + chance.choice((1e-3, 1.0, 1e9, 1e300)) * float(np.ptp(values) if count else 1.0)
    elif what == 5:
        cut = chance.choice((0, 1, 2, 3, 5, 8, at))
        found = {key: one[:cut] for key, one in found.items()}
    elif what == 6:
        found[name] = values[: chance.choice((0, 1, at))]
    elif what == 7:
        found = {key: one[::-1] for key, one in found.items()}
    elif what == 8:
        found[name] = values[::-1]
    elif what == 9:
        gap = slice(at, at + chance.choice((1, 30)))
        found = {key: np.delete(one, gap) for key, one in found.items()}
    elif what == 10:
        found[chance.choice(NAMES)] = found.pop(name)
    elif what == 11:
        other = chance.choice(list(found))
        found[name], found[other] = found[other], found[name]
    elif what == 12:
        mixed = chance.random() < 0.8
        found = {key: np.random.default_rng(at).permutation(one) if mixed or key == name else one
                 for key, one in found.items()}  # fmt: skip
    elif what == 13 and count:
        low, high = np.quantile(values, [0.3, 0.7])
        found[name] = np.clip(values, low, high)
    elif count:
        found[name] = np.repeat(values, 2)[:count] if chance.random() < 0.5 else np.round(values, chance.choice((0, 3)))
    return found or columns


def text_of(columns: Columns, chance: random.Random) -> bytes:
    """CSV, with changes of cells, lines and separators."""
    rows = min((len(one) for one in columns.values()), default=0)
    lines = [list(columns)] + [[f"{one[k]:.9g}" for one in columns.values()] for k in range(rows)]
    for _ in range(chance.choice((0, 0, 0, 0, 0, 1, 3))):
        line = chance.randrange(len(lines))
        what = chance.randrange(6)
        if what == 0 and lines[line]:
            lines[line][chance.randrange(len(lines[line]))] = chance.choice(CELLS)
        elif what == 1 and lines[line]:
            del lines[line][chance.randrange(len(lines[line]))]
        elif what == 2:
            lines[line].append(chance.choice(CELLS))
        elif what == 3:
            lines.insert(line, list(chance.choice(lines)))
        elif what == 4 and len(lines) > 1:
            del lines[line]
        else:
            lines[line] = [chance.choice(CELLS)]
    separator = chance.choice((",",) * 40 + (";", "\t", " ", "  ", "|"))
    end = chance.choice(("\n",) * 20 + ("\r\n", "\r", "\n\n"))
    text = end.join(separator.join(line) for line in lines) + chance.choice((end,) * 30 + ("", "\x00", " "))
    return (chance.choice(("",) * 20 + ("\ufeff", "# note\n", "%\n")) + text).encode("utf-8")


def write_uff(path: Path, columns: Columns) -> None:
    """Universal file with a set 58 per column beside the time."""
    import pyuff

    time = columns.get("time", np.arange(8.0))
    for k, (name, values) in enumerate((n, v) for n, v in columns.items() if n != "time"):
        count = min(len(time), len(values))
        entry = pyuff.prepare_58(
            binary=0, func_type=1, rsp_node=k + 1, rsp_dir=1, ref_node=1, ref_dir=1, data=values[:count],
            x=time[:count], id1=name, rsp_ent_name="a", ref_ent_name="b", abscissa_spacing=1,
            abscissa_spec_data_type=17, ordinate_spec_data_type=12,
            orddenom_spec_data_type=0, ver_num=1, load_case_id=0,
        )  # fmt: skip
        pyuff.UFF(str(path)).write_sets(entry, mode="add")


class Records(Original):
    """Records with columns, one file each, in any format.

    Parameters
    ----------
    kind
        Kind of the evaluation.
    records
        Columns of each file.
    settings
        Settings of the evaluation.
    others
        Key -> values that a setting may take too.
    formats
        Endings of the files.
    alone
        Whether most copies have the damaged file alone.
    """

    def __init__(
        self,
        kind: str,
        records: Sequence[Columns],
        settings: dict[str, Any],
        others: dict[str, Sequence[Any]],
        formats: Sequence[str] = ("csv",),
        *,
        alone: bool = False,
    ) -> None:
        self.kind, self._records, self._settings, self._alone = kind, records, settings, alone
        self._others, self._formats = others, formats

    def damaged(self, place: Path, chance: random.Random) -> Damaged:
        hit = chance.randrange(len(self._records))
        alone = self._alone and chance.random() < 0.8
        paths = []
        form = chance.choice(self._formats)
        for k, columns in enumerate(self._records):
            if alone and k != hit:
                continue
            own = columns
            for _ in range(chance.choice((0, 1, 1, 2)) if k == hit else 0):
                own = changed(own, chance)
            path = place / f"record_{k}.{form}"
            self._write(path, own, chance if k == hit else random.Random(0), whole=k != hit)
            if k == hit and chance.random() < 0.15:
                path.write_bytes(damaged(path.read_bytes(), chance))
            paths.append(path)
        settings = dict(self._settings)
        for _ in range(chance.choice((0, 0, 1, 2))):
            key = chance.choice(list(self._others))
            settings[key] = chance.choice(self._others[key])
        return paths, settings

    @staticmethod
    def _write(path: Path, columns: Columns, chance: random.Random, *, whole: bool) -> None:
        if path.suffix == ".npz":
            extra: dict[str, Any] = {} if whole else chance.choice(({}, {}, {"a": "text"}, {"m": np.zeros((3, 4))}))
            kept = {name: values for name, values in columns.items() if name and "\x00" not in name}
            np.savez(path, **(kept | extra))
        elif path.suffix == ".mat":
            scipy.io.savemat(path, {(name[:20] or "x"): v for name, v in columns.items() if name.isascii()})
        elif path.suffix == ".uff":
            try:
                write_uff(path, columns)
            except Exception:  # too short, or without columns: what pyuff does not write
                path.write_bytes(b"    -1\n    58\n    -1\n")
        elif whole:
            np.savetxt(path, np.transpose(list(columns.values())), "%.9g", ",", header=",".join(columns), comments="")
        else:
            path.write_bytes(text_of(columns, chance))


def shaker(formats: Sequence[str]) -> Original:
    """Two short trials of an oscillator."""
    records = []
    for seed in (1, 2):
        base = random_record([20.0, 200.0], 0.001, 1.5, 512.0, seed=seed)
        records.append(
            {"time": np.arange(base.size) / 512.0, "base": base, "tip": oscillator_tip(base, 1 / 512, 80.0, 0.05)}
        )
    units = {"base_unit": "m/s^2", "tip_unit": "m/s^2"}
    names = {"base": "base", "tip": "tip"} if formats != ("uff",) else {"base": "1:+X", "tip": "2:+X"}
    others = {
        "method": ("auto", "random", "sweep"), "band": ((30.0, 180.0), (70.0, 90.0), (1.0, 3.0), (30.0, 250.0)),
        "resolution": ("auto", 8.0, 0.01, 100.0, 1e-9),
        "damping": ("auto", "half_power", "gaussian_fit", "rational_fraction", "choose"),
        "base_unit": ("g", "mm", "um/s"), "tip_unit": ("m/s", "mm"), "tip_relative": (True,),
        "sampling_rate": (512.0, 1e-3, 1e9), "time": ("time", 1, 2), "base": (1, 2, 9, "tip"),
    }  # fmt: skip
    return Records(
        "transmissibility", records, {"resolution": 8.0, "method": "random", **names, **units}, others, formats
    )


_SHEAR = {"units": {"displacement": "m", "force": "N"}, "normal_force": 200.0}
_SHEAR_OTHERS: dict[str, Sequence[Any]] = {
    "profile": ("auto", "ramp", "loops", "sliding"), "event_rule": ("auto", "force_drop", "displacement_jump", "none"),
    "event_drop": (1e-6, 1.0, 1e6), "event_jump": (1e-9, 1.0), "window": ([0.1, 0.8], [0.0, 0.05], [0.79, 0.8]),
    "skip": (0.0, 1e-4, 1.0), "steady": (0.01, 1.0), "skip_cycles": (0, 1, 100), "moving_mass": (0.1, 1e6),
    "fixture_stiffness": (1e3, 1e9), "normal_force": (1e-9, 0.0, -1.0, 1e12),
    "units": ({"displacement": "um", "force": "kN"}, {"displacement": "m", "force": "m"}),
}  # fmt: skip


def _tests() -> list[Columns]:
    rng = np.random.default_rng(3)
    test = ShearTest(interfaces=1, normal_force=200.0)
    steps = velocity_steps(RateAndState(), rng, rates=(1e-6, 1e-5, 1e-6), points=24)
    records = [ramp(test, rng, count=100), ramp(test, rng, count=100, drop=5.0), steps]
    records.append(sine_loops(lambda v: 0.25 + 0.0 * v, rng, cycles=4, points=40))
    return [{"time": one.time, "displacement": one.displacement, "force": one.force} for one in records]


def shear() -> Original:
    """Ramps, velocity steps and loops."""
    others = _SHEAR_OTHERS | {"area": (1e-3, 1e-30), "thickness": (1e-4, 1e20)}
    return Records("shear", _tests(), _SHEAR, others, alone=True)


def friction() -> Original:
    """The same, with the fits of friction laws."""
    others = _SHEAR_OTHERS | {
        "fits": (["rate"], ["state"], ["elastic_slip"]), "rate_model": ("constant", "logarithmic", "table"),
        "knots": ([1e-6, 1e-5], [1e-9, 1.0], [1e-5, 1e-6]), "reference_rate": (1e-6, 1e3), "interfaces": (1, 51),
        "series_compliance": (0.0, 1e-8, 1.0), "elastic_slip": (1e-6, 1.0),
        "normal_force": ([50.0, 100.0, 200.0, 200.0], 0.0),
    }  # fmt: skip
    return Records("friction", _tests(), _SHEAR, others, alone=True)


def tension() -> Original:
    """Four trials at two settings."""
    rng = np.random.default_rng(5)
    time = np.arange(0.0, 6.0, 0.05)
    records = [
        {"time": time, "tension": 20.0 + rng.standard_normal(time.size), "volt": 6.0 + 0.0 * time} for _ in range(4)
    ]
    settings = {"units": {"tension": "N"}, "voltage": [4.0, 4.0, 6.0, 6.0], "current": 0.2}
    others: dict[str, Sequence[Any]] = {
        "skip": (0.0, 1.0, 100.0), "pooled": (True,), "current": (0.0, [1.0], [1.0, 2.0, 3.0, 4.0]),
        "units": ({"tension": "kN", "time": "ms"}, {"tension": "V"}), "voltage": (0.0, [1.0, 2.0, 3.0, 4.0], 1e300),
        "columns": ({"tension": "volt"}, {"tension": 2}, {"time": "volt"}, {"tension": 0}, {"tension": -1}),
    }  # fmt: skip
    return Records("tension", records, settings, others)


class Family(Original):
    """Results of `transmissibility`, with variables that are changed, cut or missing, for the kind `fit`."""

    kind = "fit"

    def __init__(self) -> None:
        self._data = measured_family()
        self._store = TemporaryDirectory()
        self._grid = Path(self._store.name) / "backbones"

    def damaged(self, place: Path, chance: random.Random) -> Damaged:
        data = self._data.copy(deep=True)
        for _ in range(chance.choice((1, 1, 2))):
            data = self._changed(data, chance)
        file = save_dataset(data, place / "measured.nc")
        if chance.random() < 0.2:
            file.write_bytes(damaged(file.read_bytes(), chance))
        if not self._grid.exists():
            write_backbones(self._grid)
        model: dict[str, Any] = {"kind": "backbones", "grid": str(self._grid)}
        if chance.random() < 0.2:
            model |= chance.choice(
                ({"level_error": 1e-9}, {"frequency_error": 1.0}, {"pressure": [1e5]}, {"frequency_factor": False})
            )
        return [file], {"model": model}

    def read_alone(self, files: list[Path], settings: dict[str, Any]) -> bool:
        read_families(files)
        return True

    @staticmethod
    def _changed(data: xr.Dataset, chance: random.Random) -> xr.Dataset:
        name = chance.choice(list(data.data_vars))
        values, what = data[name].values, chance.randrange(6)
        if what == 0:
            return data.drop_vars(name)
        if what == 1 and values.dtype.kind == "f" and values.size:
            values.flat[chance.randrange(values.size)] = chance.choice((np.nan, np.inf, 0.0, -1.0, 1e300, 1e-300))
        elif what == 2 and values.dtype.kind == "f":
            with np.errstate(over="ignore"):
                return data.assign({name: data[name] * chance.choice(SCALES)})
        elif what == 3:
            return data.isel(condition=slice(0, chance.choice((0, 1, 2, 3))))
        elif what == 4:
            return data.isel(frequency=slice(0, chance.choice((0, 1, 5))))
        elif what == 5:
            return data.assign_attrs(method=chance.choice(("random", "sweep", "", 3)))
        return data


ORIGINALS: dict[str, Callable[[], Original]] = {
    "shaker csv": lambda: shaker(("csv",)),
    "shaker npz": lambda: shaker(("npz",)),
    "shaker mat": lambda: shaker(("mat",)),
    "shaker uff": lambda: shaker(("uff",)),
    "shear": shear,
    "friction": friction,
    "tension": tension,
    "frames png": lambda: Images("png"),
    "frames tiff": lambda: Images("tiff"),
    "frames raw": lambda: Images("raw"),
    "table of targets": lambda: Images("table"),
    "fit": Family,
}
"""Name of a reader -> its measurement."""
