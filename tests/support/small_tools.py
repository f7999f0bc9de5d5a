"""Tools and benchmarks that make tables and figures, small enough for a test, and what some print."""

from __future__ import annotations

TOOLS: dict[str, list[tuple[str, str]]] = {
    "benchmarks/estimates.py": [('glob("*.yaml")', 'glob("tiny.yaml")')],
    "benchmarks/flight_meshes.py": [
        ('"irosa": (5e4, 2e5, 2e6), "sspp": (1e5, 5e5, 2e6), "habex": (5e4, 1e5, 2e5, 2e6)', '"irosa": (2e6,)'),
        ('"irosa": (2e5, 5e5, 2e6), "sspp": (1e4, 1e5, 5e5, 2e6), "habex": (2e5, 5e5, 2e6)', '"irosa": ()'),
        ("default=[*NAMES]", 'default=["irosa"]'),
    ],
    "benchmarks/hyper_reduction.py": [
        (
            "TOLERANCES = ((2e-2, np.inf), (1e-2, np.inf), (5e-3, np.inf), (2e-3, np.inf), (5e-3, 2e-3), (5e-3, 1e-3), "
            "(5e-3, 5e-4))",
            "TOLERANCES = ((5e-3, np.inf), (5e-3, 1e-3))",
        ),
    ],
    "benchmarks/opening_error.py": [
        ("range(asked.first, asked.first + asked.count)", "range(asked.first, asked.first + 1)"),
        (" for n, p, a in LOW]", " for n, p, a in LOW[3:4]]"),
    ],
    "benchmarks/random_coils.py": [
        ("parser.parse_args()", "parser.parse_args()\n    chosen.count = 1"),
        ("circumferential: 8, axial: 8, grading: 20, radial: 2", "circumferential: 8, axial: 4, radial: 1"),
        ("harmonic.harmonics=3", "harmonic.harmonics=1"),
    ],
    "benchmarks/random_preloads.py": [
        ("default=24", "default=1"),
        ("rng.choice([8, 12])", "8"),
        ("rng.integers(4, 9)", "rng.integers(2, 4)"),
        ('rng.integers(2, 4), "mesh.grading', 'rng.integers(1, 2), "mesh.grading'),
    ],
    "benchmarks/random_response.py": [
        ("PRESSURES, LEVELS = (1e5, 3e4), (-10.0, 0.0, 5.0, 10.0)", "PRESSURES, LEVELS = (1e5,), (0.0,)"),
        ("circumferential: 12, axial: 4", "circumferential: 8, axial: 2"),
        ("excitation.duration=30", "excitation.duration=4"),
    ],
    "benchmarks/random_rolls.py": [("default=200", "default=1"), ("default=list(ANALYSES)", 'default=["dwell"]')],
    "benchmarks/resolved_layers.py": [
        ("default=[5, 10, 20]", "default=[2, 5]"),
        ("default=16", "default=8"),
        ('default=8, help="elements along', 'default=2, help="elements along'),
        ('default=8, help="elements of', 'default=2, help="elements of'),
    ],
    "benchmarks/sampled_history.py": [
        ("circumferential: 32, axial: 16, grading: 40", "circumferential: 12, axial: 6, grading: 8"),
        ("rate_oct_per_min=2", "rate_oct_per_min=10"),
        ("FINE, EQUAL, CONDENSED = 160, 260, 160", "FINE, EQUAL, CONDENSED = 40, 40, 40"),
        ('for scheme in ("trigonometric", "hht")', "for scheme in ()"),
    ],
    "benchmarks/slip_images.py": [("default=10_000", "default=700")],
    "benchmarks/slipping_meshes.py": [
        ("default=list(ROWS)", 'default=["case study"]'),
        ('Row("slipping_coil", (), (1, 5, 15), FINE)', 'Row("slipping_coil", (), (5,), FINE)'),
        ("FINE = (24, 24, 60, 5, 10)", "FINE = (8, 8, 20, 2, 5)"),
        ('"slipping_coil": (16, 16, 40, 4, 10)', '"slipping_coil": (8, 6, 20, 2, 5)'),
    ],
    "benchmarks/time_steps.py": [
        ("STEPS, FINEST = (10, 20, 40, 80, 160), 640", "STEPS, FINEST = (20,), 80"),
        ("LEVELS = (5.0, 30.0)", "LEVELS = (30.0,)"),
    ],
    "tools/coil_table.py": [
        (
            "MESHES = [((12, 8, 2), (12, 8, 1)), ((16, 16, 3), (20, 12, 1)), ((20, 24, 4), (24, 20, 1)), "
            "((24, 32, 6), (32, 32, 2))]",
            "MESHES = [((8, 2, 1), (8, 2, 1)), ((8, 3, 1), (8, 3, 1))]",
        ),
        ("((20, 12, 1), (40, 40, 1))", "((8, 3, 1),)"),
    ],
    "tools/harmonic_table.py": [
        ("circumferential: 30, axial: 10", "circumferential: 8, axial: 2"),
        ("BANDS = {1.0e4: (120, 150), 3.0e4: (134, 158), 1.0e5: (144, 164), ", "BANDS = {"),
        ("RATES = (2.0, 0.5, 0.125)", "RATES = (30.0,)"),
    ],
    "tools/layers_table.py": [
        ("circumferential: 12, axial: 6, grading: 3", "circumferential: 8, axial: 2"),
        ('"excitation.cycles=12"', '"excitation.cycles=2"'),
        (" for level in LEVELS] + [(LEVELS[0], 80, 2e-3), (LEVELS[2], 40, 1e-3)]", " for level in LEVELS[:1]]"),
    ],
    "tools/low_pressure_table.py": [
        ("PRESSURES = (0.0, 1.0, 10.0, 100.0, 1000.0)", "PRESSURES = (0.0, 1000.0)"),
        ("LEVELS = {1: (0.5, 5.0, 20.0), 5: (0.5, 5.0)}", "LEVELS = {1: (0.5,)}"),
    ],
    "tools/reduced_table.py": [
        ("circumferential: 30, axial: 10", "circumferential: 8, axial: 2"),
        ('"10 kPa": 1.0e4, "30 kPa": 3.0e4, "100 kPa"', '"100 kPa"'),
        ("excitation.f_start=174", "excitation.f_start=130"),
    ],
    "tools/make_figures.py": [
        ('PRESSURES = {"10 kPa": "1.0e4", "30 kPa": "3.0e4", ', "PRESSURES = {"),
        ('["mesh.circumferential=24", "mesh.axial=12"]', '["mesh.circumferential=8", "mesh.axial=2"]'),
        ("((16, 8), (32, 16), (40, 20))", "((8, 2), (8, 4))"),
        ('words[0], "--out"', 'words[0], "--set", "output.figures=true", "--out"'),
        ('{"main": ["configs/lab_sweep.yaml"]', '{"main": ["configs/lab_sweep.yaml", "excitation.amplitude=50"]'),
        (
            "(RUNS / source, FIGURES / target)\n",
            "(RUNS / source, FIGURES / target)\n    STUDIES.clear()  # in full size\n",
        ),
    ],
}
"""File of the tool -> text of its constants, and what stands there in the scratch copy: coarse meshes, few values."""

PRINTED: dict[str, str] = {
    "benchmarks/hyper_reduction.py": "| 0.005 | 0.001 | # | 1/# | # % | # % | # |",
    "benchmarks/random_coils.py": "| 0 | # | # | # | # | # | # | #, #, # |",
    "benchmarks/random_coils.py --shaken": "| 0 | # | # | # | # | # | # | #, #, # |#, # | # | # |",
    "benchmarks/random_preloads.py": "1 of 1 converge in both, with tractions that differ by at most #",
    "benchmarks/resolved_layers.py": "| 5 | # % | # % | # % | # % | # % |",
    "benchmarks/resolved_layers.py --layers": "Hz [# # # #] damping % [# # # #]",
    "benchmarks/sampled_history.py": "| hht, 40 | # of # | # | # | # | # | # | # | # | # | # |",
    "benchmarks/slip_images.py": "largest error of an amplitude at 140 Hz # px, of a position # px",
}
"""Beginning of a command that writes no file -> a line that it prints; # is a number."""
