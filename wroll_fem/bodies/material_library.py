"""Properties of common mandrel and web materials at room temperature, with scatter and source.

The values are typical, not design allowables; for a design, measure the web or use the allowables of the programme.
"""

from __future__ import annotations

from typing import NamedTuple


class KnownMaterial(NamedTuple):
    """Material with isotropic elastic constants.

    Attributes
    ----------
    title : name in full
    E : Young's modulus, Pa
    nu : Poisson's ratio, dimensionless
    rho : density, kg/m^3
    range_E : lowest and highest Young's modulus of its grades and test methods, Pa
    yield_stress : yield stress in tension, Pa; None if it has none
    friction : lowest and highest coefficient of friction against itself, dimensionless; None if not known
    source : where the values were published
    """

    title: str
    E: float
    nu: float
    rho: float
    range_E: tuple[float, float]
    yield_stress: float | None
    friction: tuple[float, float] | None
    source: str


LIBRARY = {
    "kapton": KnownMaterial(
        "polyimide film, Kapton HN, 25 to 125 um", 2.5e9, 0.34, 1420.0, (2.5e9, 3.4e9), 69e6, (0.25, 0.63),
        "DuPont, Kapton Summary of Properties (23 degC; yield point at 3 %; friction film to film 0.48 kinetic, 0.63 "
        "static); the thesis measured a friction of 0.25 (appendix E)",
    ),
    "mylar": KnownMaterial(
        "polyester (PET) film, Mylar 92A", 4.9e9, 0.38, 1390.0, (3.8e9, 5.1e9), 102e6, (0.38, 0.45),
        "DuPont Teijin Films, Mylar Physical-Thermal Properties, H-37232-3 (4.8 along the web, 5.0 GPa across; stress "
        "at 5 % elongation in place of the yield stress)",
    ),
    "polycarbonate": KnownMaterial(
        "polycarbonate tube or sheet, unfilled", 2.35e9, 0.37, 1200.0, (2.0e9, 2.4e9), 65e6, None,
        "data sheets of Lexan and Makrolon (ISO 527); the thesis fits 2.7 GPa to its mandrel with epoxied ends",
    ),
    "aluminium_6061_t6": KnownMaterial(
        "aluminium alloy 6061-T6", 68.3e9, 0.33, 2710.0, (68.0e9, 70.0e9), 241e6, None,
        "MIL-HDBK-5, chapter 3 (E = 9.9e3 ksi, Fty = 35 ksi)",
    ),
    "stainless_steel_304": KnownMaterial(
        "stainless steel AISI 304, annealed", 200e9, 0.27, 7920.0, (190e9, 200e9), 207e6, None,
        "MIL-HDBK-5, chapter 2 (E = 29.0e3 ksi, Fty = 30 ksi)",
    ),
    "titanium_6al_4v": KnownMaterial(
        "titanium alloy Ti-6Al-4V, annealed", 110e9, 0.31, 4430.0, (110e9, 114e9), 827e6, None,
        "MIL-HDBK-5, chapter 5 (E = 16.0e3 ksi, Fty = 120 ksi)",
    ),
    "cfrp_quasi_isotropic": KnownMaterial(
        "quasi-isotropic laminate of IM7/8552 tape", 62.9e9, 0.32, 1570.0, (55e9, 63e9), None, None,
        "classical laminate theory from the lamina E1 = 164, E2 = 12, G12 = 5.2 GPa, nu12 = 0.32 (Hexcel, HexPly "
        "8552); valid in the plane, not for the bending of a thin laminate",
    ),
    "cp1": KnownMaterial(
        "fluorinated polyimide film, LaRC CP1", 2.2e9, 0.34, 1540.0, (2.1e9, 2.9e9), None, None,
        "typical values in the literature on solar sails; they differ between suppliers: measure your film",
    ),
}  # fmt: skip
"""Name in a case file -> material."""
