"""Results of the laboratory evaluation `slip`."""

from __future__ import annotations

from wroll_fem.results.entry import Entry, Field, number, share


def _largest(name: str, label: str) -> dict[str, Entry]:
    """Entries of the largest slip of one kind of pairs."""
    return {
        f"{name}_m": Entry("m", label, "0-peak at the excitation; with a known pixel length", console="{:.3g} m"),
        f"{name}_error_m": Entry("m", f"error of the {label}", "from the noise floor and the pixel length"),
        f"{name}_px": number("px", f"{label}, in pixels", "0-peak at the excitation", "{:.3g} px"),
        f"{name}_is_real": Entry("", f"whether the {label} is real", "at least one noise floor above the noise floor"),
        f"{name}_group": number("", f"group of the {label}"),
        f"{name}_layer": number("", f"layer of the {label}"),
        f"{name}_axis": Entry("", f"axis of the {label}", "x: columns, y: rows of the image"),
    }


ENTRIES: dict[str, Entry] = {
    "targets": number("", "number of targets"),
    "frames": number("", "number of frames"),
    "lost_share": share("share of positions that are lost", "over all targets and frames"),
    "false_regions": number("", "number of regions that look like a target and are none"),
    "motion_frequency_hz": number("Hz", "frequency of the largest motion", "within 1.5 lines of the given frequency"),
    "motion_amplitude_px": number("px", "largest amplitude of a target", "0-peak at the excitation"),
    "noise_floor_px": number("px", "noise floor of a position", "largest 0-peak amplitude in the band, delta"),
    "slip_noise_floor_px": number("px", "noise floor of the slip, in pixels", "sqrt(2) delta", "{:.3g} px"),
    "slip_noise_floor_m": Entry("m", "noise floor of the slip", "sqrt(2) delta times the pixel length"),
    "noise_source": Entry("", "source of the noise floor", "rest, or lines beside the excitation"),
    "pixel_length_m": Entry("m", "length of a pixel", "known over measured diameters of the targets"),
    "pixel_length_error_m": Entry("m", "standard error of the length of a pixel"),
    **_largest("mandrel_slip", "largest slip of a layer to the mandrel"),
    **_largest("layer_slip", "largest slip between layers"),
}
"""Name in summary.json -> entry."""

FIELDS: dict[str, Field] = {
    "target": Field("1", "number of the target"),
    "axis": Field("1", "axis of the image (x: columns, y: rows, downwards)"),
    "rest_time": Field("s", "time at rest"),
    "target_group": Field("1", "group of the target, -1 without table"),
    "target_layer": Field("1", "layer of the target, 0 for the mandrel, -1 without table"),
    "target_position": Field("px", "position of the target"),
    "target_amplitude": Field("px", "amplitude of the target (0-peak)"),
    "target_phase": Field("rad", "phase of the target at the first frame"),
    "target_diameter": Field("px", "outer diameter of the target"),
    "target_seen": Field("1", "share of frames in which the target is seen"),
    "target_spectrum": Field("px", "amplitude of the target at each frequency (0-peak)"),
    "noise_spectrum": Field("px", "amplitude of the noise of a position (0-peak)"),
    "noise_deviation": Field("px", "standard deviation of the noise of a position"),
    "noise_floor": Field("px", "noise floor of a position (0-peak)"),
    "slip_noise_floor": Field("px", "noise floor of the slip (0-peak)"),
    "first_frame": Field("1", "grey values of the first frame"),
    "rest_position": Field("px", "position of the target at rest"),
    "slip_history": Field("px", "slip between two targets"),
    "slip_amplitude_px": Field("px", "slip amplitude in pixels (0-peak)"),
    "slip_amplitude": Field("m", "slip amplitude (0-peak)"),
    "slip_error": Field("m", "error of the slip amplitude"),
    "slip_phase": Field("rad", "phase of the slip at the first frame"),
    "slip_spectrum": Field("px", "slip amplitude at each frequency (0-peak)"),
    "slip_is_real": Field("1", "whether the slip is at least one noise floor above the noise floor"),
    "slip_group": Field("1", "group of the pair"),
    "slip_layer": Field("1", "layer of the pair"),
    "slip_relative_to": Field("1", "layer to which the slip is relative, 0 for the mandrel"),
}
"""Name in results.nc -> unit and label."""
