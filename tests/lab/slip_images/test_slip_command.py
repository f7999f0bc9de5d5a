"""Evaluation `slip` as a whole: the example against its truth, table and rest left out, errors of the command."""

from __future__ import annotations

import json
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageSequence
from support.target_frames import FREQUENCY, RATE, record
from typer.testing import CliRunner

import wroll_fem as wf
from wroll_fem.cli import app
from wroll_fem.lab.examples import example_files
from wroll_fem.lab.result import LabResult
from wroll_fem.lab.slip_images import example
from wroll_fem.lab.slip_images.frames.rendering import Disc

FLOOR = 0.02
"""Error that is asked for at the excitation frequency, px; also the noise floor of the thesis (C56)."""

SHORT = {"frame_rate": RATE, "frequency": FREQUENCY, "band": 60.0, "frames": 150}


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return example_files("slip", tmp_path_factory.mktemp("slip") / "measured")


@pytest.fixture(scope="module")
def result(files: list[Path]) -> LabResult:
    return wf.lab.evaluate("slip", files, settings_file=files[0].parent / "settings.yaml")


def test_the_slip_of_the_example_is_found(result: LabResult) -> None:
    data, truth = result.data, example.true_slip()
    assert result.warnings == []
    for pair in range(data.sizes["pair"]):
        one = data.isel(pair=pair)
        group, layer, inner = (int(one[f"slip_{name}"]) for name in ("group", "layer", "relative_to"))
        true = truth[group, layer] - (truth[group, inner] if inner else 0.0)
        found = one["slip_amplitude_px"].values
        assert found == pytest.approx([0.0, true], abs=FLOOR), (group, layer, inner)
        if true > 0.1:
            assert float(one["slip_phase"].values[1]) == pytest.approx(1.2, abs=FLOOR / true)
            assert bool(one["slip_is_real"].values[1])
    flat = data.isel(pair=np.flatnonzero((data["slip_relative_to"] >= 6).values))
    assert not flat["slip_is_real"].any()  # Fig. 3.22: no slip beyond layer 6


def test_the_summary_of_the_example(result: LabResult) -> None:
    summary = result.summary
    assert summary["targets"] == 15
    assert (summary["frames"], summary["lost_share"], summary["false_regions"]) == (400, 0.0, 0)
    assert summary["slip_noise_floor_px"] == pytest.approx(np.sqrt(2.0) * summary["noise_floor_px"])
    assert 0.005 < summary["noise_floor_px"] < 0.02  # fig. 3.19: about 0.01 px
    true = 1e-3 * example.MILLIMETRE_PER_PIXEL
    assert abs(summary["pixel_length_m"] - true) < 2.0 * summary["pixel_length_error_m"]
    assert summary["mandrel_slip_group"] == 1
    assert summary["mandrel_slip_axis"] == "y"
    assert abs(summary["mandrel_slip_m"] - 0.2 * true) < 2.0 * summary["mandrel_slip_error_m"]
    assert summary["layer_slip_layer"] == 6
    rest = result.data["rest_position"]
    largest = float(np.abs(rest - rest.mean("rest_time")).max())
    assert largest > 5.0 * summary["noise_floor_px"]  # fig. 3.19: an order of magnitude


def test_the_table_of_a_result_is_a_table(files: list[Path], result: LabResult, tmp_path: Path) -> None:
    table = tmp_path / "targets.csv"
    table.write_text(result.texts["targets.csv"], encoding="utf-8")
    again = wf.lab.evaluate("slip", files, **SHORT, table=str(table), relative_to=6)
    for name in ("target_group", "target_layer"):
        assert np.array_equal(again.data[name], result.data[name])
    assert set(again.data["slip_relative_to"].values) == {0, 6}
    assert again.summary["pixel_length_m"] == pytest.approx(result.summary["pixel_length_m"], rel=1e-3)


def test_without_rest_and_table_the_motion_is_told_with_warnings(files: list[Path]) -> None:
    found = wf.lab.evaluate("slip", files, **SHORT)
    _, motion = example.scene()
    order = [*range(10, 15), *range(5, 10), *range(5)]  # group 1 is the lowest
    assert found.data["target_amplitude"].values[order] == pytest.approx(np.abs(motion), abs=2.0 * FLOOR)  # 150 frames
    assert "slip_amplitude_px" not in found.data
    assert len(found.warnings) == 2
    assert "no table of groups and layers" in found.warnings[1]
    assert found.summary["noise_source"] == "beside the excitation"


def test_a_wrong_frequency_and_a_short_rest_are_warned_of(files: list[Path], tmp_path: Path) -> None:
    with Image.open(files[0].parent / "rest.tif") as rest:
        for k in range(50):
            rest.seek(k)
            rest.save(tmp_path / f"rest_{k}.png")
    found = wf.lab.evaluate("slip", files, **{**SHORT, "frames": 200, "rest": str(tmp_path), "frequency": 141.5})
    text = " ".join(found.warnings)
    assert "the motion is largest at 140" in text
    assert "50 frames at rest, but 200 in motion: the noise floor is too high by about 2" in text
    assert found.summary["motion_frequency_hz"] == pytest.approx(140.0, abs=0.2)


def test_more_frames_than_the_recording_has_are_warned_of_and_change_no_line(files: list[Path]) -> None:
    found = wf.lab.evaluate("slip", files, **{**SHORT, "first_frame": 250, "frames": 10**9})
    assert any("the recording has 150 from first_frame on" in text for text in found.warnings)
    step = float(np.diff(found.data["frequency"].values)[0])
    assert step == pytest.approx(RATE / 150)


def test_a_folder_of_images_runs_into_a_folder_with_warnings_in_the_summary(tmp_path: Path) -> None:
    discs = (Disc(30.0, 30.0, 14.0), Disc(70.0, 30.0, 14.0), Disc(90.0, 60.0, 14.0))
    motion = np.array([[0.5, 0.0], [0.3, 0.0], [0.0, 0.0]])
    recording = record((80, 110), discs, motion, 120, noise=2.0, shown=lambda k: (True, not 20 <= k < 30, 40 <= k < 60))
    frames = tmp_path / "frames"
    frames.mkdir()
    for k, frame in enumerate(recording):
        Image.fromarray(frame.astype(np.uint8)).save(frames / f"{k}.png")
    (tmp_path / "table.csv").write_text("target,group,layer\n1,1,mandrel\n2,1,6\n", encoding="utf-8")
    words = ["lab", "slip", str(frames), "--out", str(tmp_path / "out"), "--set", "frame_rate=2000", "--set"]
    words += ["frequency=140", "--set", "band=60", "--set", f"table={tmp_path / 'table.csv'}", "--set"]
    words += ["target_diameter=1.4 mm", "--set", "figures=false"]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert summary["mandrel_slip_px"] == pytest.approx(0.2, abs=FLOOR)
    assert summary["pixel_length_m"] == pytest.approx(1e-4, rel=0.03)
    text = " ".join(summary["warnings"])
    assert "target 2 is lost in 10 of 120 frames" in text
    assert "in 20 frames from 40 to 59 at x = 90.0 px, y = 60.0 px" in text
    assert (tmp_path / "out" / "targets.csv").read_text(encoding="utf-8").startswith("target,group,layer,x_px")


def test_wrong_input_is_one_line(files: list[Path], tmp_path: Path) -> None:
    given = ["--set", "frame_rate=2000", "--set", "frequency=140"]
    cut, first = tmp_path / "cut.tif", tmp_path / "first.tif"
    with Image.open(files[0]) as recording:
        pages = [page.copy() for page in islice(ImageSequence.Iterator(recording), 80)]
    pages[0].save(first, save_all=True, append_images=pages[1:])
    cut.write_bytes(first.read_bytes()[:-9000])
    raw = tmp_path / "v.raw"
    raw.write_bytes(bytes(1000))
    wrong = {
        "frame_rate: required key is missing": [str(first)],
        "the image is damaged or cut off": [str(cut), *given, "--set", "band=100"],
        "no target found in the first frame: the largest regions have": [
            str(first), *given, "--set", "band=100", "--set", "circularity=1.15",
        ],
        "2.14 per cycle of 140 Hz": [str(first), "--set", "frame_rate=300", "--set", "frequency=140"],
        "too coarse for a band of +-10 Hz": [str(first), *given],
        "raw video has no size; set raw.width and raw.height": [str(raw), *given],
        "0.977 frames of 32 x 32 px": [str(raw), *given, "--set", "raw={width: 32, height: 32}"],
        "must be positive and rise": [str(first), *given, "--set", "area=[50, 20]"],
        "rest: file or folder not found": [str(first), *given, "--set", "band=100", "--set", "rest=nowhere"],
    }  # fmt: skip
    for message, words in wrong.items():
        done = CliRunner().invoke(app, ["lab", "slip", *words, "--out", str(tmp_path / "out")])
        assert done.exit_code == 2, done.output
        lines = [line for line in done.output.splitlines() if not line.startswith("frames")]
        assert len(lines) == 1, done.output
        assert message in lines[0], done.output
