"""The map of mandrels and the modal analysis in harmonics, from the case file to figures."""

import numpy as np
import pytest

from wroll_fem import analyses
from wroll_fem.case import Case
from wroll_fem.errors import InputError
from wroll_fem.mesh.generate import build_mesh
from wroll_fem.plotting.design_map import plot_design_map
from wroll_fem.progress import SilentProgress
from wroll_fem.results.dataset import load_dataset, save_dataset

WEB = {
    "kind": "cylindrical_orthotropic", "E_theta": 4e9, "E_z": 4e9, "E_r": 0.04e9, "nu_theta_z": 0.35,
    "nu_theta_r": 0.35, "nu_z_r": 0.35, "G_z_theta": 1.48e9, "G_r_theta": 1.48e9, "G_r_z": 1.48e9, "rho": 1400.0,
}  # fmt: skip


def mapped(*overrides, **sections):
    given = {
        "analysis": "design_map",
        "design_map": {"mandrel_radius": [0.02, 0.05], "mandrel_thickness": [1e-3, 3.2e-3]},
        "geometry": {"length": 0.3, "mandrel_outer_diameter": 0.08, "mandrel_thickness": 1.6e-3},
        "mandrel": {"material": {"E": 2.7e9, "nu": 0.35, "rho": 1200}},
        "coil": {"model": "solid", "thickness": 1.25e-3, "material": WEB},
        "mesh": {"discretisation": "fourier", "axial": 2, "radial": 1},
    }
    given = {key: value for key, value in (given | sections).items() if value is not None}
    return Case.model_validate(given).changed(*overrides)


def modal(*overrides, **sections):
    return mapped(*overrides, **({"analysis": "modal", "design_map": None} | sections))


@pytest.fixture(scope="module")
def found():
    return analyses.run_analysis(mapped(), progress=SilentProgress())


def test_disparity_grows_with_the_radius_and_with_a_thinner_wall(found):
    disparity = found["frequency_disparity"].values
    assert (np.diff(disparity, axis=0) > 0).all()
    assert (np.diff(disparity, axis=1) < 0).all()
    assert (found["frequency_loosest"] < found["frequency_mandrel"]).all()
    assert (found["frequency_tightest"] > found["frequency_mandrel"]).all()
    assert set(found["limit_kind"].values.ravel()) == {"torsion"}


def test_a_design_of_the_map_is_the_case_with_that_mandrel(found):
    own = mapped(
        geometry={"length": 0.3, "mandrel_outer_diameter": 0.1, "mandrel_thickness": 1e-3},
        design_map={
            "mandrel_radius": [0.05],
            "mandrel_thickness": [1e-3],
            "loosest": float(found["loosest_shear_modulus"][1, 0]),
        },
    )
    alone = analyses.run_analysis(own, progress=SilentProgress())
    for name in ("frequency_tightest", "frequency_loosest", "frequency_mandrel", "loosest_shear_modulus"):
        assert alone[name].item() == pytest.approx(float(found[name][1, 0]), rel=1e-6)
        assert alone.attrs[f"own_{name}"] == pytest.approx(alone[name].item(), rel=1e-9)


def test_loosest_coil_may_be_given(found):
    low = float(found.attrs["own_loosest_shear_modulus"])
    single = {"mandrel_radius": [0.04], "mandrel_thickness": [1.6e-3]}
    above, below = (
        analyses.run_analysis(mapped(design_map=single | {"loosest": G}), progress=SilentProgress())
        for G in (1.01 * low, 0.5 * low)
    )
    assert float(above["frequency_loosest"][0, 0]) == pytest.approx(found.attrs["own_frequency_loosest"], rel=1e-3)
    assert np.isnan(float(below["frequency_loosest"][0, 0]))
    assert below["limit_kind"].item() == "torsion"


def test_summary_and_figure(found, tmp_path):
    summary = analyses.summarise(found, mapped())
    assert summary["designs"] == 4
    assert summary["designs_without_disparity"] == 0
    assert summary["disparity_hz"] == pytest.approx(summary["f_tightest_hz"] - summary["f_loosest_hz"])
    assert summary["disparity_largest_mandrel_radius_m"] == 0.05
    assert summary["disparity_largest_mandrel_thickness_m"] == 1e-3
    ax = plot_design_map(load_dataset(save_dataset(found, tmp_path / "results.nc")))
    assert "grows with the radius and with a thinner wall" in ax.get_title(loc="left").replace("\n", " ")
    np.testing.assert_allclose(ax.lines[0].get_ydata(), found["frequency_disparity"].values[:, 0])
    np.testing.assert_allclose(ax.lines[0].get_xdata(), [20.0, 50.0])


def test_mandrels_that_never_bend_first_are_said_to():
    wide = mapped(
        "mandrel.tip=free",
        design_map={"mandrel_radius": [0.02, 0.07], "mandrel_thickness": [1e-3], "loosest": 1e7},
    )
    dataset = analyses.run_analysis(wide, progress=SilentProgress())
    assert np.isnan(dataset["frequency_disparity"].values).ravel().tolist() == [False, True]
    assert dataset["limit_kind"].values[1, 0].startswith("ovalling")
    assert analyses.summarise(dataset, wide)["designs_without_disparity"] == 1
    assert "have a fundamental mode other than bending" in plot_design_map(dataset).get_title(loc="left")


@pytest.mark.parametrize(
    ("case", "words"),
    [
        (lambda: mapped("design_map.mandrel_radius=[0.05, 0.04]"), "ascending"),
        (lambda: mapped("design_map.mandrel_thickness=[0.0, 0.001]"), "positive"),
        (lambda: mapped("design_map.mandrel_thickness=[0.03]"), "the smallest radius must exceed the thickest wall"),
        (lambda: mapped("design_map.softest=soft"), "fundamental_bending"),
        (lambda: mapped("design_map.softest=-1"), "positive"),
        (lambda: mapped("design_map.softest=1e10"), "not softer than the coil of the case"),
        (lambda: mapped(design_map=None), "required section"),
        (lambda: mapped("mesh.discretisation=three_dimensional"), "semi-analytical"),
        (lambda: mapped(coil={"model": "none"}), "solid"),
        (lambda: mapped("coil.material={E: 4e9, nu: 0.35, rho: 1400}"), "cylindrical_orthotropic"),
        (lambda: mapped("analysis=modal"), "has no map"),
        (lambda: modal(coil={
            "model": "layers", "total_thickness": 1e-3, "material": {"E": 1e9, "nu": 0.3, "rho": 1e3},
        }), "couples the circumferential harmonics"),
    ],
)  # fmt: skip
def test_wrong_input_is_named(case, words):
    with pytest.raises(InputError, match=words):
        case()


def test_modal_analysis_lists_pairs_as_the_three_dimensional_model_does(tmp_path):
    flat = modal("modal.count=5", "mesh.circumferential=16", "mesh.axial=4")
    deep = flat.changed("mesh.discretisation=three_dimensional", "mesh.axial=4", "mesh.radial=1")
    a, b = (analyses.run_analysis(c, progress=SilentProgress()) for c in (flat, deep))
    summary, other = analyses.summarise(a, flat), analyses.summarise(b, deep)
    assert summary["mode_kinds"] == other["mode_kinds"]
    np.testing.assert_allclose(summary["modes_hz"], other["modes_hz"], rtol=0.01)
    np.testing.assert_allclose(a["effective_mass_fraction"], b["effective_mass_fraction"], atol=2e-3)
    np.testing.assert_allclose(a["tip_participation"], b["tip_participation"], atol=5e-3)
    assert summary["mass_total_kg"] == pytest.approx(other["mass_total_kg"], rel=1e-4)
    first = a["mode_shape"].values[0]
    tip = a["node_position"].values[:, 2] > 0.3 - 1e-9
    assert np.abs(first[tip, 0]).min() > 0.9  # along x, the second of the pair along y
    assert np.abs(a["mode_shape"].values[1][tip, 1]).min() > 0.9
    assert np.linalg.norm(first, axis=1).max() == pytest.approx(1.0)
    written = analyses.write_fields(load_dataset(save_dataset(a, tmp_path / "results.nc")), tmp_path)
    assert [path.name for path in written] == ["mode_shapes.vtu"]


def test_harmonics_have_no_mesh_of_the_roll():
    with pytest.raises(InputError, match="three_dimensional"):
        build_mesh(modal())


def test_cases_from_before_keep_their_hash():
    old = {key: value for key, value in modal().resolved()["mesh"].items() if key != "discretisation"}
    assert "discretisation" not in modal(mesh=old).resolved()["mesh"]
