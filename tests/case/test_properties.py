"""Properties of case files, grids, units and checkpoints for generated inputs (hypothesis, derandomised)."""

from __future__ import annotations

import contextlib
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from support.paths import CONFIGS

from wroll_fem import load_case
from wroll_fem.case.loader import build_case
from wroll_fem.case.strict_yaml import dump_yaml, parse_yaml
from wroll_fem.case.units import in_si
from wroll_fem.errors import InputError
from wroll_fem.jobs.grid import load_grid
from wroll_fem.results.storage.checkpoint import read_checkpoint, write_checkpoint
from wroll_fem.results.storage.seal import seal_of, write_sealed

SAME = settings(
    derandomize=True, deadline=None, max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
TINY = parse_yaml((CONFIGS / "tiny.yaml").read_text(encoding="utf-8"), "tiny")

texts = st.text(st.characters(exclude_categories=["C"], exclude_characters="\x85\u2028\u2029\ufeff"), max_size=20)
scalars = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | texts
plain = st.recursive(
    scalars, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(texts, inner, max_size=4), max_leaves=12
)


def sections(data: Any, path: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    own = [path] if path else []
    return own + [p for k, v in data.items() for p in sections(v, (*path, k))] if isinstance(data, dict) else own


@SAME
@given(st.dictionaries(texts, plain, max_size=6))
def test_plain_data_survive_yaml(data: dict[str, Any]) -> None:
    assert parse_yaml(dump_yaml(data, default_flow_style=None, allow_unicode=True), "here") == data


@SAME
@given(st.text(max_size=200))
def test_any_text_is_yaml_or_one_line(text: str) -> None:
    refused: list[InputError] = []
    try:
        parse_yaml(text, "here")
    except InputError as error:
        refused.append(error)
    for error in refused:
        assert "\n" not in str(error)
        assert str(error).encode()
        assert error.remedy


@SAME
@given(st.sampled_from(sections(TINY)), plain)
def test_any_value_at_any_key_is_a_case_or_one_line(path: tuple[str, ...], value: Any) -> None:
    data = parse_yaml(dump_yaml(TINY), "here")
    here = data
    for part in path[:-1]:
        here = here[part]
    here[path[-1]] = value
    try:
        case = build_case(data)
    except InputError as error:
        for line in error.lines:
            assert "\n" not in line
            assert len(line) < 1900
        return
    again = build_case(parse_yaml(case.resolved_yaml(), "here"))
    assert (again, again.hash()) == (case, case.hash())


@SAME
@given(st.floats(1e-20, 1e20), st.sampled_from([("mm", 1e-3), ("um", 1e-6), ("km", 1e3), ("cm", 1e-2), ("m", 1.0)]))
def test_a_length_in_any_unit_is_the_length(value: float, unit: tuple[str, float]) -> None:
    found = in_si(f"{value!r} {unit[0]}", "m")
    assert isinstance(found, float)
    assert math.isclose(found, value * unit[1], rel_tol=1e-14)  # 15 digits are kept


@settings(SAME, max_examples=15)
@given(
    pressures=st.lists(st.floats(1e3, 1e6), min_size=1, max_size=4, unique=True),
    mus=st.lists(st.floats(0.05, 1.0), min_size=1, max_size=3, unique=True),
)
def test_a_grid_has_every_combination_once(pressures: list[float], mus: list[float], tmp_path: Path) -> None:
    file = tmp_path / "grid.yaml"
    grid = {"preload.pressure": pressures, "contact.friction.mu": mus}
    file.write_text(dump_yaml({"base": str(CONFIGS / "tiny.yaml"), "grid": grid}))
    members = load_grid(file).members
    found = {(m.case.preload.pressure, m.case.contact.friction.mu) for m in members}
    assert found == {(p, mu) for p in pressures for mu in mus}
    assert len({m.name for m in members}) == len(members) == len(pressures) * len(mus)
    assert all(len(m.name.encode()) <= 255 for m in members)


@SAME
@given(content=st.binary(max_size=3000), data=st.data())
def test_a_seal_finds_every_change(content: bytes, data: st.DataObject, tmp_path: Path) -> None:
    path = tmp_path / "file"
    write_sealed(path, content)
    assert seal_of(path) == "intact"
    whole = path.read_bytes()
    at = data.draw(st.integers(0, len(whole) - 1))
    path.write_bytes(whole[:at])
    assert seal_of(path) == "missing"
    path.write_bytes(whole[:at] + bytes([whole[at] ^ data.draw(st.integers(1, 255))]) + whole[at + 1 :])
    assert seal_of(path) != "intact"


@SAME
@given(
    stored=st.dictionaries(
        st.from_regex(r"[a-z][a-z_0-9]{0,10}", fullmatch=True),
        arrays(st.sampled_from([np.float64, np.int64, np.bool_]), array_shapes(min_dims=0, max_dims=3, max_side=4)),
        max_size=5,
    )
)
def test_a_checkpoint_keeps_every_bit(stored: dict[str, np.ndarray], tmp_path: Path) -> None:
    write_checkpoint(tmp_path / "c.npz", stored)
    found = read_checkpoint(tmp_path / "c.npz")
    assert list(found) == list(stored)
    for name, array in stored.items():
        assert (found[name].dtype, found[name].shape, found[name].tobytes()) == (
            array.dtype,
            array.shape,
            array.tobytes(),
        )


@settings(SAME, max_examples=25)
@given(content=st.binary(max_size=400), name=st.sampled_from(["case.npz", "case.mat"]))
def test_any_bytes_are_no_matrices_in_one_line(content: bytes, name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    (tmp_path / "case.yaml").write_text(f"analysis: modal\nstructure: {{file: {name}}}\n")
    with contextlib.suppress(InputError):
        load_case(tmp_path / "case.yaml")
    from wroll_fem.dynamics.system.array_file import ArrayFile

    with pytest.raises(InputError) as found:
        ArrayFile(path)
    assert "\n" not in str(found.value)
