"""The fitted law runs in the finite-element model without retyping: friction.yaml is a value of `--set`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from support.paths import CONFIGS
from typer.testing import CliRunner

import wroll_fem as wf
from wroll_fem.case import load_case
from wroll_fem.cli import app
from wroll_fem.contact.rate_coulomb import RateCoulomb
from wroll_fem.errors import InputError
from wroll_fem.lab.examples import example_files
from wroll_fem.lab.friction.section import law_text


@pytest.fixture(scope="module")
def fitted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fitted")
    files = example_files("friction", folder / "measured")
    words = ["lab", "friction", *map(str, files), "--settings", str(folder / "measured" / "settings.yaml")]
    done = CliRunner().invoke(app, [*words, "--set", "figures=false", "--out", str(folder / "out")])
    assert done.exit_code == 0, done.output
    return folder / "out"


def test_example_returns_the_truth_that_made_it(fitted: Path) -> None:
    summary = json.loads((fitted / "summary.json").read_text(encoding="utf-8"))
    truths = {
        "elastic_slip_interval_m": 2e-6, "state_ageing_a_interval": 0.01, "state_ageing_b_interval": 0.01,
        "state_ageing_distance_interval_m": 2e-5, "elastic_slip_mu_interval": 0.25,
    }  # fmt: skip
    for name, truth in truths.items():
        low, high = np.ravel(summary[name])
        assert low < truth < high, name
    assert summary["state_law"] == ["ageing"]
    rates, mu = np.array(summary["rate_table_m_s"]), np.array(summary["rate_table_mu"])
    np.testing.assert_allclose(mu, 0.25 + 0.01 * np.log(np.maximum(rates, 8e-3) / 8e-3), atol=1e-3)


def test_fitted_law_runs_in_the_smallest_case(fitted: Path, tmp_path: Path) -> None:
    file, out = fitted / "friction.yaml", tmp_path / "run"
    text = file.read_text(encoding="utf-8")
    words = ["run", str(CONFIGS / "tiny.yaml"), "--set", f"contact.friction=@{file}", "--out", str(out)]
    done = CliRunner().invoke(app, [*words, "--set", "excitation.cycles=3", "--set", "output.figures=false"])
    assert done.exit_code == 0, done.output
    section = load_case(out / "case.yaml").contact.friction
    law = RateCoulomb.from_section(section)
    written = yaml.safe_load(text)
    assert list(law.rates) == written["rate_table"]["slip_rate"]
    assert list(law.coefficients) == written["rate_table"]["mu"]
    assert law.elastic_slip == written["elastic_slip"]
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    assert summary["friction_energy_j"] > 0.0
    assert abs(summary["energy_balance_error"]) < 1e-6


def test_missing_file_of_a_value_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none.yaml: --set contact.friction: cannot be read \(no such file"):
        load_case(CONFIGS / "tiny.yaml", [f"contact.friction=@{tmp_path / 'none.yaml'}"])


def test_fitted_law_reaches_python_as_a_mapping(fitted: Path) -> None:
    law = yaml.safe_load((fitted / "friction.yaml").read_text(encoding="utf-8"))
    case = load_case(CONFIGS / "tiny.yaml").replace({"contact.friction": law})
    assert case.contact.friction.mu == law["rate_table"]["mu"][0]
    assert isinstance(case, wf.Case)


def test_law_that_no_case_accepts_is_refused() -> None:
    with pytest.raises(InputError, match="the fitted law is not admissible"):
        law_text({"law": "penalty_coulomb", "mu": -0.1, "elastic_slip": 1e-6}, [])
