"""Closed forms and an independent fine integration of shock responses."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp


def half_sine_spectrum(frequency_times_length: np.ndarray) -> np.ndarray:
    """Maximax of an undamped system under a half-sine of unit amplitude, versus f T (Harris, Shock and Vibration)."""
    x = 2.0 * np.asarray(frequency_times_length)  # natural frequency over that of the sine
    residual = np.abs(2.0 * x * np.cos(0.5 * np.pi * x) / (1.0 - x**2))
    primary = np.zeros_like(x)
    for i, r in enumerate(x):  # stationary where cos(t) = cos(r t): t = 2 pi m / (1 + r), t in half periods of pi
        m = np.arange(1, int((1.0 + r) / 2.0) + 1)
        t = 2.0 * np.pi * m / (1.0 + r)
        t = t[t <= np.pi]
        if t.size:
            primary[i] = np.abs(r / (1.0 - r**2) * (np.sin(r * t) - r * np.sin(t))).max()
    return np.maximum(primary, residual)


def sawtooth_spectrum(frequency_times_length: np.ndarray) -> np.ndarray:
    """Maximax of an undamped system under a terminal-peak sawtooth of unit amplitude, versus f T."""
    x = 2.0 * np.pi * np.asarray(frequency_times_length)
    # during the pulse y = t/T - sin(x t/T)/x; its largest value is at most 1 + 1/x, at the end or at a stationary point
    primary = np.zeros_like(x)
    for i, w in enumerate(x):
        s = np.append(2.0 * np.pi * np.arange(1, int(w / (2.0 * np.pi)) + 1) / w, 1.0)
        primary[i] = np.abs(s - np.sin(w * s) / w).max()
    end, rate = 1.0 - np.sin(x) / x, (1.0 - np.cos(x)) / x  # state at the end; rate divided by x
    return np.maximum(primary, np.hypot(end, rate))


def integrated_spectrum(base, breaks, duration: float, frequency: float, q: float, after: float) -> dict[str, float]:
    """Largest responses of one system by `solve_ivp`; ``base`` (t) has kinks at ``breaks`` alone."""
    w, zeta = 2.0 * np.pi * frequency, 0.5 / q

    def integrate(start, end, state, forced):
        points = np.linspace(start, end, max(10, int(400 * frequency * (end - start))))

        def rate(t, y):
            return [y[1], -2.0 * zeta * w * y[1] - w * w * y[0] - (base(t) if forced else 0.0)]

        found = solve_ivp(rate, (start, end), state, t_eval=points, rtol=1e-9, atol=1e-14, method="DOP853")
        return found.y

    state, parts = [0.0, 0.0], []
    inner = [t for t in breaks if 0.0 < t < duration]
    for start, end in zip([0.0, *inner], [*inner, duration], strict=True):
        parts.append(integrate(start, end, state, forced=True))
        state = list(parts[-1][:, -1])
    motion = {"primary": np.hstack(parts), "residual": integrate(duration, duration + after, state, forced=False)}
    found = {}
    for name, (z, v) in motion.items():
        found[f"{name} absolute_acceleration"] = np.abs(2.0 * zeta * w * v + w * w * z).max()
        found[f"{name} relative_displacement"] = np.abs(z).max()
        found[f"{name} pseudo_velocity"] = w * np.abs(z).max()
    return found
