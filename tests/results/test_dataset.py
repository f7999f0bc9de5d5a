"""Field table, NetCDF round trip, provenance."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr
from support import synthetic_roll

from wroll_fem.errors import InputError
from wroll_fem.results.dataset import (
    FIELDS,
    annotate,
    label,
    load_dataset,
    netcdf_image,
    provenance,
    save_dataset,
)
from wroll_fem.results.provenance import git_revision
from wroll_fem.results.storage import guarded

ATTRS = {
    "analysis": "sweep",
    "f_n_hz": 148.25,
    "steps": 47400,
    "complete": True,
    "advice": None,
    "case": {"mandrel": {"E": 2.7e9, "name": "µ"}, "layers": [1, 2]},
    "modes_hz": [148.3, np.float64(402.7)],
    "zeta": float("nan"),
    "empty": [],
    "looks_like_json": '{"not": "decoded"}',
}


@pytest.fixture(scope="module")
def sweep():
    return synthetic_roll.sweep()


def test_every_variable_leaves_with_unit_and_label(sweep):
    for dataset in (sweep, annotate(synthetic_roll.modes())):
        for name, variable in dataset.variables.items():
            assert variable.attrs["units"], name
            assert variable.attrs["long_name"], name
    assert sweep["cumulative_slip"].attrs["units"] == "m"
    assert sweep["time"].attrs["units"] == "s"


def test_unknown_name_is_refused_with_the_place_to_add_it():
    with pytest.raises(InputError, match=r"'friction_enrgy'.*wroll_fem/results/fields.py"):
        annotate(xr.Dataset({"friction_enrgy": ("time", np.zeros(3))}))
    with pytest.raises(InputError, match="'phase_of_moon'"):
        annotate(xr.Dataset(coords={"phase_of_moon": [1.0, 2.0]}))


def test_annotate_leaves_its_argument_alone():
    raw = synthetic_roll.modes()
    annotate(raw)
    assert raw["mode_frequency"].attrs == {}


def test_results_survive_save_and_load(sweep, tmp_path):
    """Values and types (bool, string, integer) and attributes (dict, list, bool, None, nan) come back as they were."""
    dataset = xr.merge([sweep, annotate(synthetic_roll.modes())])
    dataset.attrs = dict(ATTRS)
    path = save_dataset(dataset, tmp_path / "deep" / "results.nc")
    back = load_dataset(path)
    xr.testing.assert_equal(back, dataset)
    for name, variable in dataset.variables.items():
        assert back[name].dtype.kind == variable.dtype.kind, name
        assert back[name].attrs == variable.attrs, name
    assert back["slipped"].dtype == bool
    assert np.isnan(back.attrs.pop("zeta"))
    expected = {key: value for key, value in ATTRS.items() if key != "zeta"}
    assert back.attrs == expected
    for key, value in expected.items():
        assert type(back.attrs[key]) is type(value), key


def test_a_lazy_reader_takes_what_it_is_asked_for(sweep, tmp_path):
    save_dataset(sweep, tmp_path / "results.nc")
    whole, lazy = (load_dataset(tmp_path / "results.nc", lazy=wanted) for wanted in (False, True))
    assert whole["tip_displacement"].variable._in_memory
    assert not lazy["tip_displacement"].variable._in_memory
    xr.testing.assert_identical(lazy, whole)
    lazy.close()


def test_saving_replaces_a_file_only_when_the_new_one_is_complete(sweep, tmp_path):
    path = save_dataset(sweep, tmp_path / "results.nc")
    before = path.read_bytes()
    with pytest.raises(InputError, match="cannot be stored"):
        save_dataset(sweep.assign_attrs(bad=object()), path)
    with pytest.raises(InputError, match="complex"):
        save_dataset(xr.Dataset({"mode_shape": ("node", np.zeros(3, complex))}), path)
    assert path.read_bytes() == before
    load_dataset(path)
    save_dataset(sweep.isel(time=slice(0, 100)), path)  # the file is not held open by load_dataset
    assert load_dataset(path).sizes["time"] == 100
    assert [p.name for p in tmp_path.iterdir()] == ["results.nc"]


def test_long_histories_are_compressed(tmp_path):
    slow = annotate(xr.Dataset({"tip_displacement": ("time", np.zeros(100_000))}))
    assert save_dataset(slow, tmp_path / "a.nc").stat().st_size < 100_000


def test_unreadable_results_are_one_clear_message(tmp_path):
    with pytest.raises(InputError, match=r"results\.nc: results file not found"):
        load_dataset(tmp_path / "results.nc")
    (tmp_path / "results.nc").write_text("not a file of this kind")
    with pytest.raises(InputError, match="not a readable NetCDF file"):
        load_dataset(tmp_path / "results.nc")


def test_labels_carry_units_once():
    assert label("time") == "Time (s)"
    assert label("cumulative_slip", "µm") == "Accumulated slip (µm)"
    assert label("tip_acceleration") == "Tip acceleration relative to the base (m/s²)"
    assert label("mode") == "Mode number"
    assert all(entry.units and entry.long_name for entry in FIELDS.values())
    assert len({entry.long_name for entry in FIELDS.values()}) == len(FIELDS)


def test_provenance_names_versions_machine_and_time_without_heavy_imports():
    heavy = {"dolfinx", "gmsh", "petsc4py", "pyvista"} - set(sys.modules)
    record = provenance()
    assert not heavy & set(sys.modules)
    assert record["versions"]["numpy"] == np.__version__
    assert set(record["versions"]) >= {"python", "scipy", "xarray", "numba", "gmsh", "dolfinx", "petsc4py"}
    assert record["machine"]["processors"] >= 1
    assert record["time_utc"].endswith("+00:00")
    assert json.loads(json.dumps(record)) == record


def test_git_revision_is_that_of_the_checkout_that_tracks_the_package(tmp_path):
    """Installed, untracked, into a folder inside some repository it has none; tracked, it has that repository's."""

    def git(*arguments):
        name = ("-c", "user.name=test", "-c", "user.email=test@example.org", "-c", "commit.gpgsign=false")
        done = subprocess.run(["git", *name, *arguments], cwd=tmp_path, check=True, capture_output=True, text=True)
        return done.stdout.strip()

    package = tmp_path / "package"
    package.mkdir()
    (package / "__init__.py").touch()
    (tmp_path / "other").touch()
    assert git_revision(package) == {"revision": None, "modified": None}
    git("init")
    git("add", "package")
    assert git_revision(package) == {"revision": None, "modified": None}  # no commit yet
    git("reset")
    git("add", "other")
    git("commit", "-m", "other")
    assert git_revision(package) == {"revision": None, "modified": None}
    git("add", "package")
    git("commit", "-m", "package")
    assert git_revision(package) == {"revision": git("rev-parse", "HEAD"), "modified": False}
    (package / "__init__.py").write_text("changed = True")
    assert git_revision(package)["modified"] is True


@pytest.fixture
def unsealed(sweep, tmp_path):
    """Results as version 0.1.0 wrote them, without a checksum."""
    path = tmp_path / "old.nc"
    path.write_bytes(netcdf_image(sweep[["tip_displacement"]].isel(time=slice(0, 100)).drop_attrs()))
    return path


def test_results_of_version_0_1_0_are_read(sweep, unsealed):
    assert load_dataset(unsealed)["tip_displacement"].equals(sweep["tip_displacement"].isel(time=slice(0, 100)))


@pytest.mark.parametrize(
    ("trial", "told"),
    [
        ("while True: pass", "HDF5 does not return from it"),
        ("import os; os.abort()", "HDF5 crashes on it"),
        ("bytearray(1 << 60)", "MemoryError"),
    ],
)
def test_damaged_results_without_checksum_neither_hang_nor_end_the_program(trial, told, unsealed, monkeypatch):
    """HDF5 may loop for ever, crash, or ask for all memory; that happens in a child process, within limits."""
    reading = 'xarray.load_dataset(path, engine="h5netcdf")'
    assert guarded._TRIAL.count(reading) == 1
    monkeypatch.setattr(guarded, "_TRIAL", guarded._TRIAL.replace("import xarray", "").replace(reading, trial))
    monkeypatch.setattr(guarded, "LEAST_SECONDS", 1)
    with pytest.raises(InputError) as caught:
        load_dataset(unsealed)
    assert str(caught.value) == (
        f"{unsealed}: not a readable NetCDF file ({told}); delete this file and run the case again"
    )


def test_git_is_asked_without_its_locks(tmp_path, monkeypatch):
    """`git status` refreshes the index under `.git/index.lock`; a commit of the user meanwhile would fail."""
    asked = []
    monkeypatch.setattr(
        "wroll_fem.results.provenance.subprocess.run",
        lambda words, **_: asked.append(words) or subprocess.CompletedProcess(words, 0, "# branch.oid 0", ""),
    )
    git_revision(tmp_path)
    assert {words[3] for words in asked} == {str(tmp_path)}
    assert {words[4] for words in asked} == {"status", "ls-files"}
    assert all(words[:2] == ["git", "--no-optional-locks"] for words in asked)
