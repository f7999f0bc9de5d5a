"""Maps of slip and pressure, and vectors of peak slip, on the unrolled surface of an interface."""

from __future__ import annotations

import re

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from wroll_fem.plotting import style
from wroll_fem.results.dataset import field, label
from wroll_fem.results.interface_slip import interface_radius, raster, slipping_area_fraction, surface, wrap_interfaces
from wroll_fem.typing import FloatArray

_STUCK = "#E4E4E4"


def interface_name(interface: int, dataset: xr.Dataset | None = None) -> str:
    """Names of the two bodies at an interface (from the results, if given), for example "mandrel and layer 1"."""
    if dataset is not None and "interface_name" in dataset.variables:
        name = str(dataset["interface_name"].values[interface])
        inner, slash, outer = re.sub(r"_0*(?=\d)", " ", name).partition("/")
        return f"{inner} and {outer}" if slash else f"the surfaces of {inner}"
    return "mandrel and layer 1" if interface == 0 else f"layer {interface} and layer {interface + 1}"


def _unrolled(ax: Axes, dataset: xr.Dataset, z_mm: FloatArray) -> None:
    direction = dataset.attrs.get("excitation_direction", "x")
    faces = {"x": "; 0° and ±180° face the excitation", "y": "; ±90° face the excitation"}.get(direction, "")
    ax.set_xlim(-180.0, 180.0)
    ax.set_xticks(range(-180, 181, 45))
    ax.set_ylim(float(z_mm.min()), float(z_mm.max()))
    ax.set_xlabel(f"Angle around the roll from x (°){faces}")
    ax.set_ylabel(label("z_m", "mm"))
    ax.grid(False)
    for side in ("top", "right"):
        ax.spines[side].set_visible(True)


def in_small_unit(values_m: FloatArray) -> tuple[FloatArray, str]:
    """Convert lengths (m) to micrometres, or to nanometres if all are below 0.1 µm; return values and unit."""
    largest = float(np.nanmax(np.abs(values_m), initial=0.0))
    return (1e6 * values_m, "µm") if largest >= 0.1e-6 or largest == 0.0 else (1e9 * values_m, "nm")


def over_wraps(dataset: xr.Dataset, interface: int) -> str:
    """Text that the slip of an interface is the sum over the wrap interfaces it stands for; empty for one of them."""
    count = wrap_interfaces(dataset, interface)
    return "" if count == 1.0 else f", sum of {count:.4g} wrap interfaces"


def plot_slip_map(
    dataset: xr.Dataset, interface: int = 0, ax: Axes | None = None, quantity: str = "cumulative_slip"
) -> Axes:
    """Plot where and how much an interface slipped, on the unrolled cylinder.

    Parameters
    ----------
    dataset
        Has `theta_rad`, `z_m`, `area`, `slipped` and `quantity` along (`interface`, `point`); half a roll is mirrored.
    interface
        Index of the interface; 0 is the innermost (mandrel and layer 1).
    ax
        Axes to draw in; a new figure if None.
    quantity
        Variable along (`interface`, `point`) that is a length: "cumulative_slip" or "max_slip". The first is hatched
        grey where the interface never slipped. The second includes elastic slip and is shown everywhere.

    Returns
    -------
    Axes
        The axes drawn in.

    Raises
    ------
    InputError
        When the Dataset lacks a field or the interface.

    Notes
    -----
    Values between contact points are interpolated. The outline of the slipped region runs half way between points
    that slipped and points that stuck. The area fraction in the title uses the tributary areas.
    """
    points = surface(dataset, interface, quantity, "slipped")
    fraction = float(slipping_area_fraction(dataset).isel(interface=interface))
    radius = interface_radius(dataset, interface)
    theta, z, values = raster(points, quantity, radius=radius)
    slipped = raster(points, "slipped", radius=radius)[2]
    degrees, z_mm = np.degrees(theta), 1e3 * z
    ax = style.axes(ax, 4.4)
    _unrolled(ax, dataset, z_mm)
    ax.set_facecolor(_STUCK)
    stuck = Patch(facecolor=_STUCK, edgecolor="#B5B5B5", hatch="////", label="never slipped")
    shown, unit = in_small_unit(values)
    if fraction > 0.0 or quantity != "cumulative_slip":
        if quantity == "cumulative_slip":
            shown = np.where(slipped >= 0.5, shown, np.nan)
            ax.patch.set(hatch="////", edgecolor="#B5B5B5")
        top = float(np.nanmax(shown)) or 1.0
        picture = ax.pcolormesh(
            degrees, z_mm, shown, cmap=style.SLIP_MAP, vmin=0.0, vmax=top, shading="nearest", rasterized=True
        )
        if fraction > 0.0 and np.nanmin(slipped) < 0.5:
            ax.contour(degrees, z_mm, slipped, levels=[0.5], colors="black", linewidths=1.1)
        bar = style.figure_of(ax).colorbar(picture, ax=ax, pad=0.02)
        bar.set_label(label(quantity, unit) + over_wraps(dataset, interface))
    else:
        ax.patch.set(hatch="////", edgecolor="#B5B5B5")
    if quantity == "cumulative_slip" and fraction < 1.0:
        ax.legend(handles=[stuck], loc="upper right", fontsize=8, framealpha=0.95)
    style.title(ax, _finding(dataset, interface, quantity, fraction))
    return ax


def plot_pressure_map(dataset: xr.Dataset, interface: int = 0, ax: Axes | None = None) -> Axes:
    """Plot the contact pressure on an interface at the start of the motion, on the unrolled cylinder.

    Parameters
    ----------
    dataset
        Has `theta_rad`, `z_m`, `area` and `pressure` along (`interface`, `point`); half a roll is mirrored.
    interface
        Index of the interface; 0 is the innermost (mandrel and layer 1).
    ax
        Axes to draw in; a new figure if None.

    Raises
    ------
    InputError
        When the Dataset lacks a field or the interface.
    """
    points = surface(dataset, interface, "pressure")
    theta, z, values = raster(points, "pressure", radius=interface_radius(dataset, interface))
    ax = style.axes(ax, 4.4)
    _unrolled(ax, dataset, 1e3 * z)
    picture = ax.pcolormesh(
        np.degrees(theta), 1e3 * z, 1e-3 * values, cmap="viridis", vmin=0.0, shading="nearest", rasterized=True
    )
    style.figure_of(ax).colorbar(picture, ax=ax, pad=0.02).set_label(label("pressure", "kPa"))
    own = dataset[["pressure", "area"]].isel(interface=interface)  # areas of half a roll are those of the whole
    mean = style.engineering(float(own["pressure"].weighted(own["area"].fillna(0.0)).mean()), "Pa")
    low, high = (style.engineering(float(value), "Pa") for value in (own["pressure"].min(), own["pressure"].max()))
    style.title(ax, f"Pressure between {interface_name(interface, dataset)}: mean {mean}, {low} to {high}")
    return ax


def _finding(dataset: xr.Dataset, interface: int, quantity: str, fraction: float) -> str:
    """Title: "41 % of the interface ... slipped; largest accumulated slip 12.3 µm at 0°, 25 mm above the base"."""
    name = interface_name(interface, dataset)
    points = surface(dataset, interface, quantity)
    values = points.values[quantity]
    k = int(np.argmax(values))
    angle, height = abs(np.degrees(points.theta[k])), 1e3 * points.z[k]
    side = f"±{angle:.0f}°" if 0.5 < angle < 179.5 else f"{angle:.0f}°"
    shown, unit = in_small_unit(values)
    most = f"{style.three_digits(shown[k])} {unit} at {side}, {height:.0f} mm above the base"
    most += over_wraps(dataset, interface)
    if quantity == "cumulative_slip":
        if fraction == 0.0:
            return f"No slip between {name}"
        return f"{100 * fraction:.0f} % of the interface between {name} slipped; largest accumulated slip {most}"
    what = field(quantity).long_name
    return f"{what[0].upper()}{what[1:]} between {name}: {most}; {100 * fraction:.0f} % of the area slipped"


def plot_peak_slip_vectors(
    dataset: xr.Dataset, interface: int = 0, ax: Axes | None = None, max_arrows: int = 700
) -> Axes:
    """Plot the largest relative displacement of each point (outer minus inner body) as arrows on the unrolled cylinder.

    Parameters
    ----------
    dataset
        Has `peak_slip_hoop`, `peak_slip_axial` along (`interface`, `point`), `theta_rad`, `z_m`, `area`.
    interface
        Index of the interface; 0 is the innermost.
    ax
        Axes to draw in; a new figure if None.
    max_arrows
        Largest number of arrows, drawn at evenly spaced points; the longest arrow is always drawn.

    Returns
    -------
    Axes
        The axes drawn in.

    Raises
    ------
    InputError
        When the Dataset lacks a field or the interface.
    """
    points = surface(dataset, interface, "peak_slip_hoop", "peak_slip_axial")
    hoop, unit = in_small_unit(points.values["peak_slip_hoop"])
    axial, unit_axial = in_small_unit(points.values["peak_slip_axial"])
    if unit != unit_axial:  # one of the two is tiny: use one unit for both
        hoop, axial, unit = 1e6 * points.values["peak_slip_hoop"], 1e6 * points.values["peak_slip_axial"], "µm"
    size = np.hypot(hoop, axial)
    order = np.lexsort((points.theta, points.z))
    keep = order[:: max(1, int(np.ceil(order.size / max_arrows)))]
    longest = int(np.argmax(size))
    if longest not in keep:
        keep = np.append(keep, longest)
    degrees, z_mm = np.degrees(points.theta), 1e3 * points.z
    seam = keep[degrees[keep] > 180.0 - 1e-3]  # drawn at -180 too
    x = np.concatenate([degrees[keep], degrees[seam] - 360.0])
    drawn = np.concatenate([keep, seam])
    ax = style.axes(ax, 4.4)
    _unrolled(ax, dataset, z_mm)
    ax.set_xlim(-192.0, 192.0)
    top = float(size[longest]) or 1.0
    pad = 0.15 * float(np.ptp(z_mm))
    ax.set_ylim(z_mm.min() - pad, z_mm.max() + pad)
    arrows = ax.quiver(
        x, z_mm[drawn], hoop[drawn], axial[drawn], size[drawn], cmap=colormaps[style.SLIP_ARROWS], clim=(0.0, top),
        angles="uv", scale_units="inches", scale=top / 0.42, width=0.0026, headwidth=3.5, minlength=0.4,
    )  # fmt: skip
    nice = float(f"{0.7 * top:.1g}")
    ax.quiverkey(arrows, 0.86, 0.94, nice, f"{nice:g} {unit}", labelpos="E", color="black", fontproperties={"size": 9})
    bar = style.figure_of(ax).colorbar(arrows, ax=ax, pad=0.02)
    bar.set_label(f"Largest relative displacement ({unit})" + over_wraps(dataset, interface))
    angle = abs(degrees[longest])
    share = "axial" if abs(axial[longest]) >= abs(hoop[longest]) else "hoop"
    style.title(
        ax,
        f"Largest relative displacement between {interface_name(interface, dataset)}: "
        f"{style.three_digits(size[longest])} {unit}, mostly "
        f"{share}, at {'±' if 0.5 < angle < 179.5 else ''}{angle:.0f}°, {z_mm[longest]:.0f} mm above the base",
    )
    return ax
