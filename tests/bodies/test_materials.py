"""Cylindrical-orthotropic stiffness: conventions, admissibility, isotropic limit, mixture of constituents."""

import re
from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from wroll_fem.bodies.materials import CONSTANTS, Constituent, CylindricalOrthotropic, homogenise, violation
from wroll_fem.case.coil import Coil
from wroll_fem.errors import InputError

STRIP = CylindricalOrthotropic(10e9, 5e9, 0.1e9, 0.3, 0.3, 0.3, 1e9, 0.4e9, 0.7e9, 1600.0)  # Table 2.4, G_r distinct
RR, TT, ZZ, TZ, RZ, RT = range(6)


def test_stress_along_one_axis_gives_the_defined_strains():
    for axis, others in ((TT, {ZZ: 0.3, RR: 0.3}), (ZZ, {RR: 0.3})):
        strain = np.linalg.solve(STRIP.stiffness(), np.eye(6)[axis])
        for other, nu in others.items():
            assert -strain[other] / strain[axis] == pytest.approx(nu, rel=1e-12)
    moduli = 1 / np.diag(np.linalg.inv(STRIP.stiffness()))
    np.testing.assert_allclose(moduli, [0.1e9, 10e9, 5e9, 1e9, 0.7e9, 0.4e9], rtol=1e-12)


def test_isotropic_limit_is_lames_matrix():
    E, nu = 4e9, 0.35
    lame, G = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
    expected = np.diag([2 * G] * 3 + [G] * 3)
    expected[:3, :3] += lame
    np.testing.assert_allclose(
        CylindricalOrthotropic.isotropic(E, nu, 1.0).stiffness(), expected, rtol=1e-12, atol=1e-3
    )
    assert pytest.approx(1.48e9, rel=2e-3) == G  # thesis, section 2.5


def test_admissible_exactly_where_the_stiffness_is_positive_definite():
    rng = np.random.default_rng(4)
    outcomes = []
    for _ in range(400):
        values = {name: rng.uniform(1, 9) for name in ("E_theta", "E_z", "E_r")}
        values |= {name: rng.uniform(-1.2, 1.2) for name in ("nu_theta_z", "nu_theta_r", "nu_z_r")}
        values |= dict.fromkeys(("G_z_theta", "G_r_theta", "G_r_z"), 1.0)
        loose = object.__new__(CylindricalOrthotropic)  # past the check, to look at the matrix itself
        for name, value in (values | {"rho": 1.0}).items():
            object.__setattr__(loose, name, value)
        positive = bool(np.linalg.eigvalsh(loose.compliance()).min() > 0)
        assert (violation(loose) is None) == positive
        outcomes.append(positive)
    assert 50 < sum(outcomes) < 350


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        ({"E_r": -1.0}, "E_r", "must be positive"),
        ({"G_r_z": 0.0}, "G_r_z", "must be positive"),
        ({"rho": float("nan")}, "rho", "must be positive"),
        ({"nu_theta_z": 1.5}, "nu_theta_z", "sqrt(E_theta / E_z) = 1.414"),
        ({"nu_theta_r": 30.0}, "nu_theta_r", "sqrt(E_theta / E_r) = 10"),
        ({"nu_z_r": -8.0}, "nu_z_r", "sqrt(E_z / E_r) = 7.071"),
        ({"nu_theta_z": 1.2, "nu_theta_r": 6.0, "nu_z_r": 5.0}, "nu_theta_z", "2 nu_tz nu_zr nu_rt > 0"),
    ],
)
def test_inadmissible_constants_get_one_line(change, key, words):
    with pytest.raises(InputError) as caught:
        replace(STRIP, **change)
    assert caught.value.key == key
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_mixture_is_the_weighted_mean_or_the_limiting_constituent():
    frame = Constituent(0.2, 60e9, 20e9, 0.25, 4e9, 1600.0)
    membrane = Constituent.isotropic(0.5, 2.5e9, 0.34, 1400.0)
    web = homogenise({"frame": frame, "membrane": membrane}, limited_by={"G_z_theta": "membrane"})
    assert web.E_theta == pytest.approx(0.2 * 60e9 + 0.5 * 2.5e9)  # 30 % of the volume is void
    assert web.E_z == pytest.approx(0.2 * 20e9 + 0.5 * 2.5e9)
    assert web.rho == pytest.approx(0.2 * 1600 + 0.5 * 1400)
    assert web.nu_theta_z == pytest.approx((0.2 * 0.25 + 0.5 * 0.34) / 0.7)
    assert web.G_z_theta == web.G_r_theta == web.G_r_z == membrane.G_z_theta
    assert web.E_r == pytest.approx(0.01 * web.E_theta)
    alone = homogenise(
        {"film": Constituent.isotropic(1.0, 4e9, 0.35, 1400.0)}, radial_ratio=1.0, nu_theta_r=0.35, nu_z_r=0.35
    )
    np.testing.assert_allclose(
        alone.stiffness(), CylindricalOrthotropic.isotropic(4e9, 0.35, 1400.0).stiffness(), rtol=1e-12
    )


@pytest.mark.parametrize(
    ("fractions", "limited", "key"),
    [((0.7, 0.7), {}, "fraction"), ((0.0, 0.5), {}, "a.fraction"), ((0.5, 0.5), {"E_r": "a"}, "limited_by")],
)
def test_mixtures_that_make_no_sense_are_refused(fractions, limited, key):
    parts = {name: Constituent.isotropic(f, 1e9, 0.3, 1.0) for name, f in zip("ab", fractions, strict=True)}
    with pytest.raises(InputError) as caught:
        homogenise(parts, limited_by=limited)
    assert caught.value.key == key


COIL = {
    "model": "solid", "thickness": 15e-3,
    "material": {name: getattr(STRIP, name) for name in CONSTANTS} | {"kind": "cylindrical_orthotropic"},
}  # fmt: skip


def test_case_section_hands_over_the_same_material_and_survives_a_round_trip():
    coil = Coil.model_validate(COIL)
    assert coil.solid() == STRIP
    assert coil.total_thickness == 15e-3
    dumped = coil.model_dump(mode="json")
    assert Coil.model_validate(dumped) == coil
    assert not {"layers", "bending", "total_thickness"} & set(dumped)
    film = Coil.model_validate(COIL | {"material": {"kind": "isotropic", "E": 4e9, "nu": 0.35, "rho": 1400}})
    assert film.material.solid() == CylindricalOrthotropic.isotropic(4e9, 0.35, 1400)
    assert "kind" not in film.model_dump()["material"]  # as cases were written before there were several kinds


def test_constants_left_out_are_those_of_a_web_isotropic_in_its_plane():
    few = {"kind": "cylindrical_orthotropic", "E_theta": 4e9, "E_r": 4e7, "G_r_theta": 1e6, "rho": 1400}
    few |= {"nu_theta_z": 0.35, "nu_theta_r": 0.35, "nu_z_r": 0.35}
    film = Coil.model_validate(COIL | {"material": few}).material
    assert (film.E_z, film.G_z_theta, film.G_r_z) == (4e9, pytest.approx(1.4815e9, rel=1e-4), 1e6)
    with pytest.raises(ValidationError, match="not isotropic in its plane"):
        Coil.model_validate(COIL | {"material": few | {"E_z": 5e9}})


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"material": COIL["material"] | {"nu_theta_r": 30.0}}, "sqrt(E_theta / E_r) = 10"),
        ({"model": "bonded"}, "shells (model: bonded) have no modulus through the stack of wraps"),
        ({"bending": False}, "does not apply to a solid coil"),
        ({"total_thickness": 10e-3}, "differs from total_thickness = 0.01 m"),
        ({"thickness": None}, "required key is missing; add it (thickness of the coil"),
    ],
)
def test_coil_sections_that_contradict_themselves_are_refused(change, words):
    with pytest.raises(ValidationError, match=re.escape(words)):
        Coil.model_validate(COIL | change)
