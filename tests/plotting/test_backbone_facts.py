"""Headline of a backbone: every statement is tested on the data."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from wroll_fem.plotting.backbone import backbone_facts, plot_backbone

TIP = np.geomspace(1e-7, 1e-4, 7)
SOFTER = np.linspace(30.0, 27.0, 7)
NONE = np.zeros(7)


def backbone(hertz, damping, share):
    data = {
        "resonance_frequency": hertz, "modal_damping": damping, "slipping_fraction": share,
        "resonant_base_acceleration": 1e3 * TIP,
    }  # fmt: skip
    return xr.Dataset({name: ("tip_amplitude", values) for name, values in data.items()}, {"tip_amplitude": TIP})


@pytest.mark.parametrize(
    ("hertz", "damping", "share", "facts"),
    [
        (
            np.full(7, 27.1), 1e-18 * np.ones(7), NONE,
            ["Resonance stays at 27.1 Hz from 0.1 to 100 µm", "no point slips", "friction dissipates nothing"],
        ),
        (
            SOFTER, np.array([0, 0, 0, 1, 3, 2, 1]) / 100, np.array([0, 0, 0, 0.1, 0.4, 0.8, 1.0]),
            ["Resonance falls from 30.0 to 27.0 Hz with rising amplitude", "slip starts at 3.16 µm",
             "largest damping ratio 3 % at 10 µm"],
        ),
        (
            SOFTER[::-1], np.linspace(1, 4, 7) / 100, np.linspace(0.2, 1.0, 7),
            ["Resonance rises from 27.0 to 30.0 Hz with rising amplitude",
             "points slip from the smallest amplitude on (20 %)",
             "largest damping ratio 4 % at 100 µm, the largest amplitude"],
        ),
    ],
)  # fmt: skip
def test_headline_of_a_backbone_states_what_holds(hertz, damping, share, facts):
    dataset = backbone(hertz, damping, share)
    assert backbone_facts(dataset) == facts
    assert (
        plot_backbone(dataset)
        .get_title("left")
        .replace("\xa0", " ")
        .replace("\n", " ")
        .startswith(facts[0].split(" from ")[0])
    )


def test_backbone_without_interfaces_says_nothing_of_slip():
    facts = backbone_facts(backbone(SOFTER, 0.01 * np.ones(7), NONE).drop_vars("slipping_fraction"))
    assert len(facts) == 2
    assert not any("slip" in fact for fact in facts)
