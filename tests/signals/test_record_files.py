"""Records of a base motion: reading files, conditioning, and files that are refused."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from wroll_fem.errors import InputError
from wroll_fem.signals.records.columns import _damaged
from wroll_fem.signals.records.mat_columns import mat_matrices
from wroll_fem.signals.records.motion import RecordedMotion
from wroll_fem.signals.records.record import Record, read_record
from wroll_fem.signals.shock.pulses import HalfSine

RATE, G = 5000.0, 9.80665
TIME = np.arange(400) / RATE
BASE = 30.0 * np.sin(2 * np.pi * 90.0 * TIME) * np.exp(-((TIME - 0.04) ** 2) / 2e-4)  # m/s^2


def write_csv(path: Path, header="time,base,tip", separator=",", rows=None) -> Path:
    rows = np.column_stack([TIME, BASE / G, 2 * BASE / G]) if rows is None else rows
    lines = [header] if header else []
    lines += [separator.join(f"{value:.9g}" for value in row) for row in rows]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


# --- formats ------------------------------------------------------------------------------------------------------


def test_the_same_record_is_read_from_every_format(tmp_path):
    plain = write_csv(tmp_path / "a.csv")
    units = write_csv(tmp_path / "b.txt", "time;base;tip\ns;g;g", ";")
    blanks = write_csv(tmp_path / "c.dat", "", " ")
    comment = write_csv(tmp_path / "d.tsv", "# shaker table\n% run 7\ntime\tbase\ttip", "\t")
    np.savez(tmp_path / "e.npz", time=TIME, base=BASE / G, tip=2 * BASE / G, note="text is left out")
    savemat(tmp_path / "f.mat", {"t": TIME, "data": np.column_stack([BASE / G, 2 * BASE / G]), "fs": RATE})
    records = [
        read_record(plain, unit="g", column="base"),
        read_record(units, unit="g", column="base"),
        read_record(blanks, unit="g", column=2, time=1),
        read_record(blanks, unit="g", column="2", time="1"),
        read_record(comment, unit="g", column="Base"),
        read_record(tmp_path / "e.npz", unit="g", column="base"),
        read_record(tmp_path / "f.mat", unit="g", column="data[1]"),
        read_record(plain, unit="g", column=2, sampling_rate=RATE),
    ]
    for record in records:
        np.testing.assert_allclose(record.acceleration, BASE, atol=1e-6)  # nine digits in the text
        assert record.dt == pytest.approx(1 / RATE, rel=1e-7)
        assert record.remarks == ()
    in_si = write_csv(tmp_path / "g.csv", "t,base", rows=np.column_stack([TIME, BASE]))
    np.testing.assert_allclose(read_record(in_si, unit="m/s^2").acceleration, BASE, rtol=1e-7, atol=1e-12)


def test_universal_file_is_read_by_pyuff(tmp_path):
    pyuff = pytest.importorskip("pyuff")
    path = tmp_path / "a.uff"
    common = {
        "binary": 0,
        "func_type": 1,
        "rsp_dir": 1,
        "ref_node": 0,
        "ref_dir": 0,
        "abscissa_spec_data_type": 17,
        "orddenom_spec_data_type": 0,
    }
    sets = [
        pyuff.prepare_58(**common, rsp_node=node, data=scale * BASE, x=TIME, id1="record", ordinate_spec_data_type=12,
                         ord_data_type=4, num_pts=len(TIME), abscissa_spacing=1, abscissa_min=0.0,
                         abscissa_inc=1 / RATE)
        for node, scale in ((1, 1.0), (7, 2.0))
    ]  # fmt: skip
    pyuff.UFF(str(path)).write_sets(sets, "overwrite")
    record = read_record(path, unit="m/s^2", column="7:+X")
    np.testing.assert_allclose(record.acceleration, 2 * BASE, rtol=1e-9, atol=1e-9)
    assert record.dt == pytest.approx(1 / RATE, rel=1e-6)
    path.write_text("    -1\n   151\n\n    -1\n")
    with pytest.raises(InputError, match="set"):
        read_record(path, unit="g")


def test_channels_of_a_universal_file_are_named_by_node_and_direction(tmp_path):
    pyuff = pytest.importorskip("pyuff")
    path = tmp_path / "a.uff"
    named = {0: "", 1: "+X", 2: "+Y", 3: "+Z", -1: "-X", -2: "-Y", -3: "-Z"}
    common = {"binary": 0, "func_type": 1, "ref_node": 0, "ref_dir": 0, "abscissa_spec_data_type": 17}
    sets = [
        pyuff.prepare_58(**common, rsp_node=4, rsp_dir=direction, data=(5.0 + direction) * BASE, x=TIME, id1="record",
                         ordinate_spec_data_type=12, orddenom_spec_data_type=0, ord_data_type=4, num_pts=len(TIME),
                         abscissa_spacing=1, abscissa_min=0.0, abscissa_inc=1 / RATE)
        for direction in named
    ]  # fmt: skip
    pyuff.UFF(str(path)).write_sets(sets, "overwrite")
    for direction, name in named.items():
        record = read_record(path, unit="m/s^2", column=f"4:{name}")
        np.testing.assert_allclose(record.acceleration, (5.0 + direction) * BASE, rtol=1e-6, atol=1e-6)


# --- refusals -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("text", ["", "\n \n", "# of the shaker\n", "time,base\n", "time,base\ns,g\n"])
def test_a_text_file_without_numbers_is_refused_in_one_line(text, tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_record(path, unit="g")
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.remedy


def rows_with(change):
    rows = np.column_stack([TIME, BASE / G])
    change(rows)
    return rows


def _gap(rows):
    rows[200:, 0] += 0.01


def _falls(rows):
    rows[200, 0] = rows[198, 0]


def _unequal(rows):
    rows[:, 0] = TIME + 1e-4 * np.sin(2 * np.pi * TIME / TIME[-1])


def _nan(rows):
    rows[33, 1] = np.nan


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (_gap, r"gap of 0.0102 s after 0.0398 s"),
        (_falls, r"time does not rise: sample 201"),
        (_unequal, r"unequal time steps"),
        (_nan, r"sample 34 is nan"),
        (lambda rows: rows[:, 1].fill(0.0), "all samples are zero"),
    ],
)
def test_wrong_samples_are_refused_in_one_line(tmp_path, change, text):
    path = write_csv(tmp_path / "a.csv", "time,base", rows=rows_with(change))
    with pytest.raises(InputError, match=text) as error:
        read_record(path, unit="g")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"unit": "g", "column": "bse"}, r"no column 'bse'; did you mean 'base'\?"),
        ({"unit": "g"}, "2 columns besides the time"),
        ({"unit": "g", "column": 4}, "column 4 of 3"),
        ({"unit": "g", "column": "time"}, "is the time"),
        ({"unit": "gal", "column": "base"}, "unknown unit 'gal'.*use one of: m/s"),
        ({"unit": "g", "column": "base", "time": "clock"}, "no column 'clock'"),
        ({"unit": "g", "column": "base", "time": 1, "sampling_rate": 10.0}, "both given"),
        ({"unit": "g", "column": "base", "sampling_rate": -1.0}, "sampling_rate = -1"),
    ],
)
def test_wrong_choices_are_refused_in_one_line(tmp_path, options, text):
    with pytest.raises(InputError, match=text) as error:
        read_record(write_csv(tmp_path / "a.csv"), **options)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("name", "content", "text"),
    [
        ("a.csv", "", "no series"),
        ("a.csv", "time,base\n0,1\n0.1,2", "line break"),
        ("a.csv", "time,base\n0,1\n0.1\n", "line 3 has 1 columns"),
        ("a.csv", "time;base\n0;1,5\n0,1;2\n", "write decimal points"),
        ("a.csv", "time,base\n0,1\n0.1,x\n", r"line 3, column 2: 'x' is no number"),
        ("a.csv", "time,time\n0,1\n0.1,2\n", "repeated"),
        ("a.csv", "time,base\n0,1\n0.1,2\n", "2 samples"),
        ("a.npz", "no archive", "damaged"),
        ("a.mat", "no matrix file", "damaged"),
        ("a.wav", "x", "unknown format '.wav'"),
    ],
)
def test_damaged_files_are_refused_in_one_line(tmp_path, name, content, text):
    (tmp_path / name).write_text(content)
    with pytest.raises(InputError, match=text) as error:
        read_record(tmp_path / name, unit="g", column=2)
    assert "\n" not in str(error.value)
    with pytest.raises(InputError, match="not found"):
        read_record(tmp_path / "missing.csv", unit="g")


def test_mutated_files_raise_nothing_but_input_errors(tmp_path):
    """Seed 58: 600 files with changed, removed, repeated or added bytes, or cut off; each is read or refused."""
    rng = np.random.default_rng(58)
    short = slice(0, 60)
    sources = [write_csv(tmp_path / "s.csv", rows=np.column_stack([TIME, BASE, BASE])[short])]
    np.savez(tmp_path / "s.npz", time=TIME[short], base=BASE[short])
    savemat(tmp_path / "s.mat", {"time": TIME[short], "base": BASE[short]})
    savemat(tmp_path / "z.mat", {"time": TIME[short], "base": BASE[short]}, do_compression=True)
    sources += [tmp_path / name for name in ("s.npz", "s.mat", "z.mat")]
    refused: list[str] = []
    for source in sources:
        whole = source.read_bytes()
        for _ in range(150):
            data = bytearray(whole)
            kind = rng.integers(5)
            at = int(rng.integers(len(data)))
            if kind == 0:
                data = data[:at]
            elif kind == 1:
                for k in rng.integers(len(data), size=rng.integers(1, 6)):
                    data[k] = rng.integers(256)
            elif kind == 2:
                del data[at : at + int(rng.integers(1, 40))]
            elif kind == 3:
                data[at:at] = data[: int(rng.integers(1, 40))]
            else:
                data[at] ^= 1 << int(rng.integers(8))
            path = tmp_path / f"mutated{source.suffix}"
            path.write_bytes(bytes(data))
            try:
                record = read_record(path, unit="g", column="base")
            except InputError as error:
                refused.append(str(error))
            else:
                assert np.isfinite(record.acceleration).all()
    assert len(refused) > 300
    assert not any("\n" in text for text in refused)


def test_a_binary_file_that_is_cut_off_is_refused(tmp_path):
    np.savez(tmp_path / "s.npz", time=TIME[:20], base=BASE[:20])
    savemat(tmp_path / "s.mat", {"time": TIME[:20], "base": BASE[:20]})
    for name in ("s.npz", "s.mat"):
        whole = (tmp_path / name).read_bytes()
        for length in range(0, len(whole), 3):
            path = tmp_path / f"cut{Path(name).suffix}"
            path.write_bytes(whole[:length])
            with pytest.raises(InputError):
                read_record(path, unit="g", column="base")


def test_matlab_files_are_read_as_scipy_reads_them(tmp_path):
    """Types, shapes, long and short names, compression; what is no full real matrix is left out."""
    rng = np.random.default_rng(7)
    kinds = ("f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8")
    wanted = {f"v_{kind}": (100 * rng.random((7, 3))).astype(kind) for kind in kinds}
    wanted |= {"a": rng.normal(size=5), "long_name_of_a_record": rng.normal(size=(2, 40)), "one": np.array([[3.0]])}
    others = {"text": "words", "cell": np.array([1, "a"], dtype=object), "z": np.ones(3) + 1j, "struct": {"x": 1.0}}
    for compressed in (False, True):
        savemat(tmp_path / "a.mat", wanted | others, do_compression=compressed, long_field_names=True)
        found = mat_matrices((tmp_path / "a.mat").read_bytes())
        assert set(found) == set(wanted)
        for name, value in loadmat(tmp_path / "a.mat", variable_names=list(wanted)).items():
            if not name.startswith("__"):
                np.testing.assert_array_equal(found[name], value)


def test_a_text_cut_off_within_a_row_is_refused(tmp_path):
    whole = write_csv(tmp_path / "a.csv", rows=np.column_stack([TIME, BASE, BASE])[:20]).read_bytes()
    for length in range(len(whole)):
        if whole[length - 1 : length] == b"\n":
            continue  # whole rows: nothing tells that there were more
        (tmp_path / "a.csv").write_bytes(whole[:length])
        with pytest.raises(InputError):
            read_record(tmp_path / "a.csv", unit="g", column="base")


@pytest.mark.parametrize("expected", [{"rows": 20}, {"length": float(TIME[19])}])
def test_a_text_of_known_size_is_refused_when_cut_off_at_any_byte(tmp_path, expected):
    """Without the last line break too: whether a number is complete cannot be seen there."""
    whole = write_csv(tmp_path / "a.csv", rows=np.column_stack([TIME, BASE, BASE])[:20]).read_bytes()
    for length in range(len(whole)):
        (tmp_path / "a.csv").write_bytes(whole[:length])
        with pytest.raises(InputError) as caught:
            read_record(tmp_path / "a.csv", unit="g", column="base", **expected)
        assert "\n" not in str(caught.value)
    (tmp_path / "a.csv").write_bytes(whole)
    assert len(read_record(tmp_path / "a.csv", unit="g", column="base", **expected).acceleration) == 20
    with pytest.raises(InputError, match="cut off, or of another record"):
        read_record(tmp_path / "a.csv", unit="g", column="base", **{name: 2 * v for name, v in expected.items()})


def test_clipped_record_is_remarked_on(tmp_path):
    clipped = np.clip(BASE / G, -2.0, 2.0)
    path = write_csv(tmp_path / "a.csv", "time,base", rows=np.column_stack([TIME, clipped]))
    (remark,) = read_record(path, unit="g").remarks
    assert "clipped" in remark


# --- conditioning -------------------------------------------------------------------------------------------------


def test_motion_follows_a_band_limited_record_between_its_samples():
    """Five samples per cycle: the filter and the spline recover the sine within 1e-3 away from the ends."""
    motion = RecordedMotion(Record(np.sin(2 * np.pi * 1000.0 * np.arange(600) / 5000.0 + 0.3), 1 / 5000.0))
    time = np.linspace(0.03, 0.09, 4321)
    np.testing.assert_allclose(motion.acceleration(time), np.sin(2 * np.pi * 1000.0 * time + 0.3), atol=2e-3)
    assert motion.acceleration(-1e-6) == 0.0
    assert motion.acceleration(motion.duration + 1e-6) == 0.0


@pytest.mark.parametrize(("share", "told"), [(0.3, False), (0.45, True)])
def test_a_record_sampled_below_2_5_times_its_band_is_remarked_on(share, told):
    """A tone at a share of the sampling rate, 5 kHz, which fades in and out."""
    n = np.arange(2000)
    motion = RecordedMotion(Record(np.sin(2 * np.pi * share * n) * np.sin(np.pi * n / 1999) ** 2, 1 / 5000.0))
    found = [text for text in motion.remarks if "5000 samples per second, fewer than 2.5 times" in text]
    assert len(found) == told


def test_low_pass_removes_the_noise_above_its_limit_without_delay():
    rng = np.random.default_rng(1)
    time = np.arange(4000) / 10000.0
    slow = np.sin(2 * np.pi * 40.0 * time) * np.sin(np.pi * time / time[-1]) ** 2
    noise = np.convolve(rng.normal(size=4000), [1, -1], "same")
    noise = np.fft.irfft(np.fft.rfft(noise) * (np.fft.rfftfreq(4000, 1e-4) > 2000.0), 4000)
    motion = RecordedMotion(Record(slow + noise, 1e-4), low_pass=500.0)
    inside = slice(400, 3600)
    np.testing.assert_allclose(motion.acceleration(time)[inside], slow[inside], atol=2e-3)


def test_default_low_pass_leaves_nothing_above_half_the_rate_of_the_time_steps():
    """A half-sine with weak noise: 20 steps per cycle of its band must not alias what is above."""
    rng = np.random.default_rng(2)
    dt = 1e-5
    pulse = HalfSine(100.0, 0.011, 0.005, 0.02)
    base = pulse.acceleration(dt * np.arange(int(pulse.duration / dt)))
    motion = RecordedMotion(Record(base + 0.05 * rng.normal(size=base.size), dt))
    assert motion.highest_frequency_hz < 200.0
    assert motion.limit < 10.0 * motion.highest_frequency_hz
    step, fine = motion._fine
    power = np.abs(np.fft.rfft(fine * np.hanning(fine.size))) ** 2
    beyond = np.fft.rfftfreq(fine.size, step) > 1.2 * motion.limit
    assert power[beyond].sum() < 1e-8 * power.sum()
    after = np.linspace(0.02, 0.034, 500)  # 2 % of the noise's band is left, and ripple of the pulse's corner
    assert motion.acceleration(after).std() < 0.4 * 0.05


def test_baseline_leaves_no_velocity_and_no_displacement():
    time = np.arange(2000) / 2000.0
    drifting = Record(np.sin(2 * np.pi * 15 * time) * np.exp(-5 * time) + 0.3 + 0.2 * time, 1 / 2000.0)
    for baseline, wanted in (("none", (0.4, 0.15)), ("velocity", (0.0, None)), ("displacement", (0.0, 0.0))):
        motion = RecordedMotion(drifting, baseline=baseline)
        fine = np.linspace(0.0, motion.record.duration, 20001)
        base = motion.acceleration(fine)
        velocity = np.concatenate([[0.0], np.cumsum(0.5 * (base[1:] + base[:-1]))]) * fine[1]
        displacement = np.sum(0.5 * (velocity[1:] + velocity[:-1])) * fine[1]
        assert velocity[-1] == pytest.approx(wanted[0], abs=0.03 if baseline == "none" else 1e-5)
        assert motion.velocity_change == pytest.approx(velocity[-1], abs=1e-5)
        if wanted[1] is not None:
            assert displacement == pytest.approx(wanted[1], abs=0.06 if baseline == "none" else 1e-5)


def test_ends_taper_scale_and_pauses():
    record = Record(np.full(101, 2.0) + 0.01 * np.arange(101), 0.01)
    jumping = RecordedMotion(record)
    assert any("jumps" in remark for remark in jumping.remarks)
    motion = RecordedMotion(record, taper=0.1, scale=3.0, before=0.5, after=1.0)
    assert motion.remarks == ()
    assert motion.duration == pytest.approx(2.5)
    assert motion.end == pytest.approx(1.5)
    assert motion.acceleration(0.49) == 0.0
    assert motion.acceleration(1.0) == pytest.approx(3.0 * 2.5, rel=1e-3)
    assert abs(float(motion.acceleration(0.5))) < 0.05
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert motion.amplitude == pytest.approx(3.0 * 2.9, rel=0.02)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"baseline": "mean"}, "excitation.baseline.*displacement"),
        ({"taper": 0.6}, "excitation.taper"),
        ({"low_pass": 2500.0}, "excitation.low_pass.*2500"),
        ({"after": -1.0}, "excitation.after"),
    ],
)
def test_wrong_conditioning_is_refused(options, text):
    with pytest.raises(InputError, match=text):
        RecordedMotion(Record(BASE, 1 / RATE), **options)


@pytest.mark.parametrize(
    ("error", "said"), [(ValueError("no  header\n here"), "no header here"), (OSError(), "OSError")]
)
def test_a_damaged_file_is_refused_with_the_words_of_its_reader(error: Exception, said: str) -> None:
    refusal = _damaged(Path("record.npz"), error)
    assert f"({said})" in str(refusal)
    assert refusal.file == "record.npz"
