"""Judge the claims of chapter 4 of the source from the runs of configs/studies and write docs/claims-chapter4.md.

`.venv/bin/python tools/claims_ch4.py [RUNS]`, after the studies have been run into RUNS (runs/docs/chapter4).
Nothing is simulated here; a claim whose study is missing is written as open.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from chapter4_runs import PRELOAD_STUDY, ROOT, Runs, Verdict, areas, kpa, largest, monotone, rank_correlation, tops

from wroll_fem.analyses.advice import interface_pressures
from wroll_fem.case import Case, load_case
from wroll_fem.errors import InputError
from wroll_fem.plotting.convergence import first_bending
from wroll_fem.plotting.history import chirp_law
from wroll_fem.plotting.study import PRESSURE, SeriesMember, friction_work, is_sweep, natural_frequency, read
from wroll_fem.signals.base_motion import base_motion
from wroll_fem.winding import wound_roll

AMPLITUDE = "excitation.amplitude"


def listed(members: list[SeriesMember], value: Callable[[SeriesMember], float], form: str) -> str:
    return ", ".join(f"{value(m):{form}}" for m in members)


def both(runs: Runs, said: Callable[[list[SeriesMember]], str]) -> str:
    """Text for the free base, with the clamped one beside it where that was run."""
    text = f"free base: {said(runs.sweeps('free'))}"
    try:
        clamped = runs.sweeps("clamped")
        rings = " (it rings)" if any(read(m).rings for m in clamped) else ""
        return f"{text}; clamped: {said(clamped)}{rings}"
    except InputError:
        return text


# ---- definitions ---------------------------------------------------------------------------------


def at_interface(runs: Runs, said: Callable[[list[SeriesMember]], str]) -> str:
    """Text for the preloads that put 10 kPa and more on the interface; the layer's ring takes the rest of them."""
    members = [m for m in runs.sweeps("free") if runs.summary("preload", m)["interface_pressure_mean_pa"][0] >= 1e4]
    return f"; free base, 10 kPa and more at the interface ({kpa(members[0])} outside and up): {said(members)}"


def lab(*overrides: str) -> Case:
    return load_case(ROOT / "configs" / "lab_sweep.yaml", overrides)


def c57(runs: Runs) -> Verdict:
    sums = [n * lab(f"coil.layers={n}").coil.layer_thickness for n in range(1, 6)]
    return Verdict(f"n t_l = {1e3 * sums[0]:.4g} mm for n = 1 to 5", bool(np.allclose(sums, 25 * 0.05e-3, rtol=1e-12)))


def c58(runs: Runs) -> Verdict:
    alone = float(runs.mandrel().data.attrs["mass_total_kg"])
    with_layer = runs.one("bounds", modal__interface="bonded", coil__base="free")
    tube = alone - lab().mandrel.tip_mass
    coil = float(with_layer.data.attrs["mass_total_kg"]) - alone
    value = f"coil {coil:.4f} kg at {lab().coil.material.rho:g} kg/m^3, tube {tube:.4f} kg (tip mass 0.05 kg apart)"
    return Verdict(value, True, "thesis error: explained")


def c59(runs: Runs) -> Verdict:
    f_m = natural_frequency(runs.mandrel())
    bonded = {base: runs.bound("bonded", base) for base in ("free", "clamped")}
    top = runs.sweeps("free")[-1]
    f_n = read(top).f_n
    value = (
        f"f_b = {bonded['free']:.2f} Hz (free), {bonded['clamped']:.2f} Hz (clamped); f_b/f_m = "
        f"{bonded['free'] / f_m:.3f} "
        f"and {bonded['clamped'] / f_m:.3f}; f_n({kpa(top)}) = {f_n:.2f} Hz, "
        f"{100 * (f_n / bonded['free'] - 1):+.1f} % of f_b"
    )
    return Verdict(value, 1.02 <= bonded["free"] / f_m <= 1.13 and abs(f_n / bonded["free"] - 1) <= 0.02)


def c60(runs: Runs) -> Verdict:
    parts = []
    for base in ("free", "clamped"):
        f = [read(m).f_n for m in runs.sweeps(base)]
        low, high = runs.bound("frictionless", base), runs.bound("bonded", base)
        parts.append(
            f"{base}: frictionless {low:.2f} Hz, bonded {high:.2f} Hz, sweeps span {min(f):.1f} to {max(f):.1f} Hz"
        )
    return Verdict("; ".join(parts), True)


def c61(runs: Runs) -> Verdict:
    rolls = []
    for tension in (20.0, 60.0):
        winding = load_case(ROOT / "configs" / "winding_lab.yaml", [f"winding.tension_newton={tension}"]).winding
        assert winding is not None
        rolls.append(wound_roll(winding))
    pressures, bounds = [roll.pressure[0] for roll in rolls], [roll.hoop_bound for roll in rolls]
    value = (
        f"25 wraps, w = 0.3 m: P at the mandrel {pressures[0] / 1e3:.0f} kPa at 20 N and {pressures[1] / 1e3:.0f} kPa "
        f"at 60 N; hoop bound sum of F/(w r) {bounds[0] / 1e3:.0f} and {bounds[1] / 1e3:.0f} kPa, so that 300 kPa is "
        "far above what the measured tensions can give ([the wound roll](winding.md))"
    )
    return Verdict(value, all(10e3 <= p <= bound <= 300e3 for p, bound in zip(pressures, bounds, strict=True)))


def c62(runs: Runs) -> Verdict:
    chirp = lab().excitation
    duration = base_motion(chirp).duration
    value = (
        f"{chirp.f_start:g} to {chirp.f_end:g} Hz at {chirp.rate_oct_per_min:g} oct/min, "
        f"{chirp.amplitude:g} m/s^2: {duration:.2f} s"
    )
    return Verdict(value, math.isclose(duration, math.log2(1.4) / 2 * 60, rel_tol=1e-9) and chirp.amplitude == 5.0)


def c63(runs: Runs) -> Verdict:
    parts, offs = [], []
    for study, base in (("mesh_linear_clamped", "base clamped as in the source"), ("mesh_linear", "base free")):
        finest = max(runs.study(study), key=lambda m: m.values["mesh.circumferential"] * m.values["mesh.axial"])
        offs.append(
            first_bending(runs.one(study, mesh__circumferential=30, mesh__axial=10)) / first_bending(finest) - 1
        )
        parts.append(f"{base}: {100 * offs[-1]:+.2f} % off {first_bending(finest):.2f} Hz of the finest mesh")
    value = f"linear, bonded, 30 x 10: {'; '.join(parts)}"
    try:
        most = max(m.values["mesh.axial"] for m in runs.study("mesh_friction"))
        best = read(runs.one("mesh_friction", mesh__grading=6, mesh__axial=most))
        coarse = read(runs.one("mesh_friction", mesh__grading=1, mesh__axial=10))
        change = [100 * (getattr(coarse, key) / getattr(best, key) - 1) for key in ("f_n", "peak", "zeta")]
        value += (
            f"; friction at 100 kPa, which the source did not check: uniform 30 x 10 is {change[0]:+.2f} % off in f_n, "
            f"{change[1]:+.1f} % in the peak, {change[2]:+.1f} % in zeta"
        )
    except InputError as error:
        value += f"; friction: {error}"
    return Verdict(value, max(abs(off) for off in offs) <= 0.01)


# ---- preload series ------------------------------------------------------------------------------


def c64(runs: Runs) -> Verdict:
    def said(members: list[SeriesMember]) -> str:
        f, zeta = [read(m).f_n for m in members], [read(m).zeta for m in members]
        best = int(np.nanargmax(zeta))
        return f"f_n {min(f):.1f} to {max(f):.1f} Hz, zeta up to {100 * zeta[best]:.2f} % ({kpa(members[best])})"

    members = runs.sweeps("free")
    f, zeta = [read(m).f_n for m in members], [read(m).zeta for m in members]
    holds = 128 <= min(f) <= 142 and 157 <= max(f) <= 173 and 0.02 <= np.nanmax(zeta) <= 0.08
    return Verdict(both(runs, said), bool(holds))


def c65(runs: Runs) -> Verdict:
    def said(members: list[SeriesMember]) -> str:
        peaks = listed(members, lambda m: read(m).peak, ".1f")
        return f"T_pk {peaks}; SK({kpa(members[0])}) = {read(members[0]).skewness + 1:.2f}"

    members = runs.sweeps("free")
    peaks = [read(m).peak for m in members]
    value = both(runs, said) + at_interface(runs, said)
    return Verdict(value, monotone(peaks, 1) and read(members[0]).skewness + 1 > 1.05)


def c66(runs: Runs) -> Verdict:
    f_m = natural_frequency(runs.mandrel())

    def said(members: list[SeriesMember]) -> str:
        return ", ".join(f"f_n({kpa(m)}) = {read(m).f_n:.1f} Hz" for m in (members[-1], members[0]))

    members = runs.sweeps("free")
    return Verdict(f"f_m = {f_m:.1f} Hz; {both(runs, said)}", read(members[-1]).f_n > f_m > read(members[0]).f_n)


def c67(runs: Runs) -> Verdict:
    def rho(members: list[SeriesMember]) -> float:
        return rank_correlation([read(m).f_n for m in members], [read(m).zeta for m in members])

    def said(members: list[SeriesMember]) -> str:
        return f"rank correlation {rho(members):.2f}, zeta {listed(members, lambda m: 100 * read(m).zeta, '.2f')} %"

    return Verdict(both(runs, said) + at_interface(runs, said), rho(runs.sweeps("free")) < -0.8)


def c68(runs: Runs) -> Verdict:
    """Share of E_F gained within 10 % of f_n, and where the rate (over windows of about 20 cycles) is largest."""
    members = runs.sweeps("free")
    parts, holds = [], True
    for m in (members[0], members[-1]):
        law = chirp_law(m.data)
        assert law is not None
        time, work = m.data["time"].values, m.data["friction_energy"].values
        frequency = law[0] * np.exp(law[1] * time)
        f_n = read(m).f_n
        near = np.abs(frequency / f_n - 1) <= 0.1
        share = (work[near][-1] - work[near][0]) / work[-1]
        edges = np.linspace(0, time.size - 1, max(2, int((time[-1] - time[0]) * f_n / 20))).astype(int)
        window = int(np.argmax(np.diff(work[edges]) / np.diff(time[edges])))
        at = float(frequency[(edges[window] + edges[window + 1]) // 2])
        holds &= share >= 0.5 and abs(at / f_n - 1) <= 0.1
        parts.append(
            f"{kpa(m)}: {100 * share:.0f} % within 10 % of f_n, largest rate at {at:.1f} Hz (f_n {f_n:.1f} Hz)"
        )
    return Verdict("free base: " + "; ".join(parts), bool(holds))


def c69(runs: Runs) -> Verdict:
    def said(members: list[SeriesMember]) -> str:
        return (
            f"E_F {listed(members, lambda m: 1e3 * friction_work(m), '.0f')} mJ at {', '.join(kpa(m) for m in members)}"
        )

    return Verdict(both(runs, said), monotone([friction_work(m) for m in runs.sweeps("free")], -1))


def c70(runs: Runs) -> Verdict:
    def r(members: list[SeriesMember]) -> float:
        return float(np.corrcoef([friction_work(m) for m in members], [read(m).zeta for m in members])[0, 1])

    def said(members: list[SeriesMember]) -> str:
        work, zeta = [friction_work(m) for m in members], [read(m).zeta for m in members]
        return (
            f"r = {r(members):.2f}, max zeta at {kpa(members[int(np.argmax(zeta))])}, "
            f"max E_F at {kpa(members[int(np.argmax(work))])}"
        )

    return Verdict(both(runs, said) + at_interface(runs, said), r(runs.sweeps("free")) > 0.8)


# ---- slip ----------------------------------------------------------------------------------------


def dwells(runs: Runs, study: str = "dwell_layers") -> list[SeriesMember]:
    return sorted(runs.study(study), key=lambda m: m.values[AMPLITUDE])


def level(member: SeriesMember) -> str:
    return f"{member.values[AMPLITUDE] / 9.80665:.3g} g"


def both_bases(runs: Runs, said: Callable[[list[SeriesMember]], str]) -> str:
    text = f"free base: {said(dwells(runs))}"
    try:
        return f"{text}; clamped: {said(dwells(runs, 'dwell_layers_clamped'))}"
    except InputError:
        return text


def c71(runs: Runs) -> Verdict:
    m = dwells(runs)[0]
    found = runs.summary("dwell_layers", m)["interface_pressure_mean_pa"]
    split = interface_pressures(load_case(ROOT / "configs" / "lab_dwell_layers.yaml"))
    value = (
        f"mean interface pressures {', '.join(f'{p:.0f}' for p in found)} Pa (inner first); thin-ring split "
        "by E t/R^2: "
        f"{', '.join(f'{p:.0f}' for p in split)} Pa; sum applied 1000 Pa, outermost 200 Pa"
    )
    return Verdict(value, abs(found[0] / 1000 - 1) <= 0.02 and abs(found[-1] / 200 - 1) <= 0.02)


def c72(runs: Runs) -> Verdict:
    def said(members: list[SeriesMember]) -> str:
        return (
            f"{level(members[0])}: slipped {', '.join(f'{1e4 * a:.1f}' for a in areas(members[0]))} cm^2, inner first"
        )

    first = areas(dwells(runs)[0])
    return Verdict(both_bases(runs, said), bool(np.all(first[0] > first[1:]) and first[-1] == 0.0))


def c73(runs: Runs) -> Verdict:
    def said(members: list[SeriesMember]) -> str:
        k, hoop, axial, angle = largest(members[0])
        return (
            f"{level(members[0])}: interface {k + 1}, vertical {1e6 * abs(axial):.2f} um, horizontal "
            f"{1e6 * abs(hoop):.2f} um, "
            f"{angle:.0f} deg from the axis"
        )

    k, hoop, axial, angle = largest(dwells(runs)[0])
    return Verdict(both_bases(runs, said), k == 0 and abs(axial) > abs(hoop) and angle <= 45.0)


def c74(runs: Runs) -> Verdict:
    def facts(members: list[SeriesMember]) -> list[tuple[float, float, int]]:
        return [(float(areas(m).sum()), tops(m), int(np.count_nonzero(areas(m)))) for m in members]

    def said(members: list[SeriesMember]) -> str:
        return ", ".join(
            f"{level(m)}: {1e4 * a:.0f} cm^2, up to {1e3 * z:.0f} mm, {n} interfaces"
            for m, (a, z, n) in zip(members, facts(members), strict=True)
        )

    found = facts(dwells(runs))
    area, top, count = (np.diff(column) for column in zip(*found, strict=True))
    grows = bool(np.all(area > 0) and np.all(top >= 0) and np.all(count >= 0) and (top.any() or count.any()))
    return Verdict(both_bases(runs, said), grows and len(found) == 3)


def c75(runs: Runs) -> Verdict:
    most = {}
    for n in (1, 2):
        group = [m for m in runs.study("layer_count") if m.values["coil.layers"] == n and is_sweep(m)]
        if not group:
            raise InputError(f"study layer_count has no finished sweep with {n} layers", remedy="run it")
        best = max(group, key=lambda m: np.nan_to_num(read(m).zeta))
        most[n] = (read(best).zeta, kpa(best))
    ratio = most[2][0] / most[1][0]
    value = "; ".join(f"n = {n}: max zeta {100 * z:.2f} % at {p}" for n, (z, p) in most.items())
    return Verdict(f"{value}; ratio {ratio:.2f}", 0.02 <= most[1][0] <= 0.08 and 1 / 1.5 <= ratio <= 1.5)


def c76(runs: Runs) -> Verdict:
    contact = lab().contact
    friction = contact.friction
    same = friction.law == "penalty_coulomb" and friction.mu == 0.25 and friction.elastic_slip == 1e-6
    same = same and contact.normal.separation
    errors = [
        runs.summary(study, m)["energy_balance_error"]
        for base, study in PRELOAD_STUDY.items()
        for m in runs.sweeps(base)
    ]
    numerical = [
        abs(float(m.data["numerical_dissipation"].values[-1]) / float(m.data["input_work"].values[-1]))
        for m in runs.sweeps("free")
    ]
    value = (
        f"law {friction.law}, mu {friction.mu:g}, gamma* {friction.elastic_slip:g} m, separation on; balance "
        "off by at most "
        f"{100 * max(errors):.1e} % at any time of {len(errors)} sweeps; numerical part of the input at most "
        f"{100 * max(numerical):.2f} % (free base)"
    )
    return Verdict(value, same and max(errors) < 0.01)


def c125(runs: Runs) -> Verdict:
    files = {}
    for m in runs.study("friction_laws"):
        if is_sweep(m):
            files.setdefault(m.values[PRESSURE], {})[m.values["case"]] = read(m)
    worst = np.zeros(3)
    for pair in files.values():
        a, b = pair.values()
        worst = np.maximum(worst, [abs(b.f_n / a.f_n - 1), abs(b.peak / a.peak - 1), abs(b.zeta / a.zeta - 1)])
    friction = load_case(ROOT / "configs" / "lab_sweep_rate.yaml").contact.friction
    value = (
        f"largest change over {len(files)} preloads: f_n {100 * worst[0]:.2f} %, T_pk {100 * worst[1]:.1f} %, "
        f"zeta {100 * worst[2]:.1f} %; mu(V) used: {friction.model_dump(exclude_unset=True)}"
    )
    return Verdict(value, bool(worst[0] <= 0.01 and worst[1] <= 0.1 and worst[2] <= 0.1))


CLAIMS: dict[str, tuple[str, Callable[[Runs], Verdict]]] = {
    "C57": ("layers together as thick as 25 Kapton layers (1.25 mm)", c57),
    "C58": ("densities 2000 and 1200 kg/m^3 from weighed masses", c58),
    "C59": ("bonded frequency equals that of the highest preload", c59),
    "C60": ("base of the layers bonded; does not restrict slip much", c60),
    "C61": ("10 to 300 kPa encompass the experiment's radial stresses", c61),
    "C62": ("chirp 125 to 175 Hz, 2 oct/min, 5 m/s^2 (14.56 s)", c62),
    "C63": ("30 x 10 elements keep 99 % of the converged f_n", c63),
    "C64": ("f_n about 135 to 165 Hz, zeta 1 to 5 %", c64),
    "C65": ("peak falls with preload; low preload skewed to the right", c65),
    "C66": ("f_n(300 kPa) above, f_n(10 kPa) below the mandrel's", c66),
    "C67": ("zeta falls as f_n rises along the preload", c67),
    "C68": ("friction works fastest around resonance", c68),
    "C69": ("friction work falls with preload", c69),
    "C70": ("friction work correlates strongly with zeta", c70),
    "C71": ("n = 5, 200 Pa each: 1 kPa at the mandrel", c71),
    "C72": ("largest slip area innermost; outer interfaces stick at 1 g", c72),
    "C73": ("slip vertical, on the faces along the excitation, at the mandrel", c73),
    "C74": ("slip spreads upward and outward from 1 to 3 g", c74),
    "C75": ("one slipping interface is enough for the damping", c75),
    "C76": ("penalty law, gamma* 1 um, mu 0.25, no other damping", c76),
    "C125": ("rate-dependent friction changes nothing much", c125),
}


def judge(runs: Runs) -> dict[str, Verdict]:
    """Every claim; open where its study is missing."""
    found = {}
    for name, (_, claim) in CLAIMS.items():
        try:
            found[name] = claim(runs)
        except InputError as error:
            found[name] = Verdict(str(error), None)
    return found


def page(found: dict[str, Verdict], reasons: str) -> str:
    """Markdown page: the table, then the reasons."""
    counts: dict[str, int] = {}
    for verdict in found.values():
        counts[verdict.text()] = counts.get(verdict.text(), 0) + 1
    lines = [
        "# Claims of chapter 4",
        "",
        "Written by `.venv/bin/python tools/claims_ch4.py` from the studies of [chapter 4](chapter4.md); "
        "each is judged by the",
        "criterion of the claims list. " + ", ".join(f"{n} {word}" for word, n in counts.items()) + ".",
        "",
        "| id | the source says | computed here | verdict |",
        "|---|---|---|---|",
    ]
    lines += [f"| {name} | {CLAIMS[name][0]} | {v.value} | **{v.text()}** |" for name, v in found.items()]
    return "\n".join(lines) + "\n\n" + reasons


def write(folder: Path) -> None:
    """Print one line per claim and write the page from the studies in ``folder``."""
    found = judge(Runs(folder))
    for name, verdict in found.items():
        print(f"{name:<5} {verdict.text():<24} {verdict.value}")
    reasons = ROOT / "tools" / "claims_ch4_reasons.md"
    target = ROOT / "docs" / "claims-chapter4.md"
    target.write_text(page(found, reasons.read_text() if reasons.is_file() else ""))
    print(f"written: {target}")


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "runs" / "docs" / "chapter4")
