"""Table of groups and layers: rows by number or by place, and wrong tables in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from wroll_fem.errors import InputError
from wroll_fem.lab.slip_images.regions.regions import Regions
from wroll_fem.lab.slip_images.table import MANDREL, Member, read_table
from wroll_fem.lab.slip_images.targets.targets import in_reading_order


def regions(centroid: list[tuple[float, float]], diameter: list[float]) -> Regions:
    size = np.array(diameter)
    area = 0.25 * np.pi * size**2
    n = len(size)
    return Regions(np.array(centroid), area, area, np.pi * size, np.zeros((n, 4)), np.zeros(n, dtype=bool))


NEST = regions([(20.0, 20.0), (20.2, 20.1), (20.0, 60.0), (19.9, 60.1)], [8.0, 20.0, 8.0, 20.0])
GOOD = "target,group,layer\n1,2,mandrel\n2,2,6\n3,1,mandrel\n4,1,6\n"


def read(text: str, folder: Path, targets: Regions = NEST) -> tuple[Member, ...]:
    path = folder / "targets.csv"
    path.write_text(text, encoding="utf-8")
    return read_table(path, targets)


def test_targets_are_numbered_from_the_top_and_rings_follow_their_disc() -> None:
    rng = np.random.default_rng(1)
    places = [(x, y) for y in (30.0, 90.0, 150.0) for x in (40.0, 120.0)]
    centres = [(x + rng.uniform(-4, 4), y + rng.uniform(-4, 4)) for x, y in places for _ in range(1)]
    nested = [(x + rng.uniform(-1, 1), y + rng.uniform(-1, 1)) for x, y in centres for _ in range(3)]
    whole = regions(nested, [8.0, 20.0, 32.0] * 6)
    shuffled = whole.chosen(rng.permutation(18))
    assert in_reading_order(shuffled).centroid == pytest.approx(whole.centroid)


def test_rows_belong_to_targets_by_number(tmp_path: Path) -> None:
    assert read(GOOD, tmp_path) == (Member(2, 1, MANDREL), Member(3, 1, 6), Member(0, 2, MANDREL), Member(1, 2, 6))
    spaced = GOOD.replace(",", " , ").replace("layer", "Layer")
    assert read(spaced, tmp_path) == read(GOOD, tmp_path)


def test_rows_belong_to_targets_by_place_and_size(tmp_path: Path) -> None:
    text = (
        "target,group,layer,x_px,y_px,diameter_px,diameter_mm\n"
        "7,1,mandrel,20.5,61,8,0.8\n8,1,6,20.5,61,19,2.0\n9,,,20,20,8,\n10,,,20,20,20,\n"
    )
    assert read(text, tmp_path) == (Member(2, 1, MANDREL, 8e-4), Member(3, 1, 6, 2e-3))


def test_wrong_tables_are_one_line(tmp_path: Path) -> None:
    wrong = {
        "column 'layer' is missing; rename the column 'layers'": GOOD.replace("layer\n", "layers\n"),
        "column 'group' is missing; write a first line target,group,layer": "target,b\n1,2\n",
        "column 'target' is missing": "",
        "line 3: layer is 'six'; write a number or mandrel": GOOD.replace("2,2,6", "2,2,six"),
        "line 3: group is empty; write a whole number": GOOD.replace("2,2,6", "2,,6"),
        "line 3: target is 1.5; write a whole number": GOOD.replace("2,2,6", "1.5,2,6"),
        "line 3: target 9, but the first frame has 4 targets": GOOD.replace("2,2,6", "9,2,6"),
        "target 1 is listed twice": GOOD.replace("2,2,6", "1,2,6"),
        "group 2 has layer 6 twice": GOOD.replace("4,1,6", "4,2,6"),
        "group 1 has no target on the mandrel": GOOD.replace("3,1,mandrel", "3,1,11"),
        "no target has a layer": "target,group,layer\n1,,\n",
        "line 2 has 4 cells": "target,group,layer\n1,2,3,4\n",
        "line 2: diameter_mm is '-2'": "target,group,layer,diameter_mm\n1,1,mandrel,-2\n",
        "line 2: no target within 8 px of x = 50 px": "target,group,layer,x_px,y_px\n1,1,mandrel,50,20\n",
        "line 2: x_px is '1e300'": "target,group,layer,x_px,y_px\n1,1,mandrel,1e300,20\n",
        "line 2: diameter_px is '1e-320'": "target,group,layer,x_px,y_px,diameter_px\n1,1,mandrel,30,20,1e-320\n",
        "line 2: x_px or y_px is missing": "target,group,layer,x_px,y_px\n1,1,mandrel,,20\n",
    }
    for message, text in wrong.items():
        with pytest.raises(InputError) as error:
            read(text, tmp_path)
        assert message in str(error.value)
        assert "\n" not in str(error.value)


@pytest.mark.parametrize("count", [1000, pytest.param(10_000, marks=pytest.mark.slow)])
def test_mutated_tables_are_read_or_one_line(count: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(count)
    path = tmp_path / "targets.csv"
    text = "target,group,layer,x_px,y_px,diameter_px,diameter_mm\n1,1,mandrel,20,20,8,0.8\n2,1,6,20,20,20,2\n"
    for original in (GOOD.encode(), text.encode()):
        for _ in range(count // 2):
            data = bytearray(original)
            for _ in range(int(rng.integers(1, 5))):
                place = int(rng.integers(0, len(data)))
                if rng.random() < 0.5:
                    data[place] = int(rng.integers(0, 256))
                else:
                    del data[place : place + int(rng.integers(1, 6))]
                data = data or bytearray(b"x")
            path.write_bytes(data)
            try:
                assert read_table(path, NEST)
            except InputError as error:
                assert "\n" not in str(error)  # noqa: PT017
