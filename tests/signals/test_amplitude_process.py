"""Stationary amplitude of a nonlinear mode: closed forms, energy balance, and errors."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from wroll_fem.errors import InputError
from wroll_fem.signals.averaging.amplitude_process import NonlinearMode, amplitude_density
from wroll_fem.signals.averaging.notching import factor_at_limit


def flat(level):
    """Constant PSD at all frequencies."""
    return lambda frequency: np.full(np.shape(frequency), level)


def random_mode(rng):
    """Backbone whose frequency falls by a random part and whose damping rises and falls, as with friction."""
    a = np.geomspace(1e-7, 1e-3, 120)
    onset = 10.0 ** rng.uniform(-6.0, -4.5)
    share, w0 = rng.uniform(0.05, 0.4), 2.0 * np.pi * rng.uniform(20.0, 200.0)
    w = w0 * np.sqrt(1.0 - share * a / (a + onset))
    zeta = rng.uniform(0.001, 0.02) + rng.uniform(0.0, 0.05) * a * onset / (a + onset) ** 2
    return NonlinearMode.of_oscillator(a, w, zeta, mass=rng.uniform(0.1, 5.0), participation=rng.uniform(0.5, 2.0))


def test_a_linear_oscillator_has_its_exact_rms_and_power():
    """sigma^2 = W Gamma^2 / (8 zeta w^3) and power m W Gamma^2 / 4; the density is exact, so is the quadrature."""
    rng = np.random.default_rng(151)
    for _ in range(5):
        w, zeta = 2.0 * np.pi * 10.0 ** rng.uniform(0, 3), 10.0 ** rng.uniform(-3, -1)
        mass, gamma, level = rng.uniform(0.1, 10.0, 3)
        mode = NonlinearMode.of_oscillator([1e-6, 1e-4], [w, w], [zeta, zeta], mass=mass, participation=gamma)
        law = amplitude_density(mode, flat(level))
        assert law.tip_rms == pytest.approx(gamma * np.sqrt(level / (8.0 * zeta * w**3)), rel=1e-10)
        assert float(law.mean(law.power)) == pytest.approx(mass * level * gamma**2 / 4.0, rel=1e-10)
        assert law.mean_damping == pytest.approx(zeta, rel=1e-10)
        assert law.mean_frequency == pytest.approx(w / (2.0 * np.pi), rel=1e-10)
        # a Rayleigh amplitude exceeds three times the rms of the displacement in exp(-4.5) of the cycles
        assert law.tip_exceeded(np.exp(-4.5)) == pytest.approx(3.0 * law.tip_rms, rel=2e-3)


def potential_mode(potential, slope, amplitudes, damping_rate):
    """Exact backbone of x'' + damping_rate x' + U'(x) = -a_g by quadrature over the quarter period."""
    rows = []
    for a in amplitudes:
        top = potential(a)

        def speed(phi, a=a, top=top):  # x = a sin phi; dt = a cos phi dphi / v
            x = a * np.sin(phi)
            gap = max(2.0 * (top - potential(x)), 1e-300)
            return a * np.cos(phi) / np.sqrt(gap) if np.cos(phi) > 1e-9 else np.sqrt(a / slope(a))

        quarter = quad(speed, 0.0, np.pi / 2, limit=200)[0]
        action = 4.0 * quad(lambda phi, s=speed, a=a: (a * np.cos(phi)) ** 2 / s(phi), 0.0, np.pi / 2)[0] / (2 * np.pi)
        square = quad(lambda phi, s=speed, a=a: (a * np.sin(phi)) ** 2 * s(phi), 0.0, np.pi / 2)[0] / quarter
        rows.append((np.pi / (2.0 * quarter), action, square))
    w, action, square = np.array(rows).T
    # white noise: all harmonics of the velocity take work, mean square of the velocity = w J
    base = np.sqrt(2.0 * action / w)
    return NonlinearMode(w, damping_rate / (2.0 * w), w * action, base, np.sqrt(2.0 * square))


@pytest.mark.parametrize(
    ("potential", "slope"),
    [
        (lambda x: 0.5 * x**2 + 0.25 * x**4, lambda x: x + x**3),
        (lambda x: np.sqrt(1.0 + x**2) - 1.0, lambda x: x / np.sqrt(1.0 + x**2)),
    ],
    ids=["hardening", "softening"],
)
def test_the_action_gives_the_exact_density_of_a_strongly_nonlinear_spring(potential, slope):
    """Caughey's stationary density exp(-2 c U / (pi S)...) of a spring with a dashpot, at strong nonlinearity."""
    rate = 0.02
    mode = potential_mode(potential, slope, np.geomspace(1e-2, 60.0, 120), rate)
    for level in (0.002, 0.04, 0.12):
        law = amplitude_density(mode, flat(level))
        # exact: p(x, v) = C exp(-(U + v^2 / 2) 4 rate / W)
        scale = level / (4.0 * rate)
        reach = brentq(lambda x, s=scale: potential(x) - 40.0 * s, 1e-6, 1e6)
        x = np.linspace(-reach, reach, 40001)
        weight = np.exp(-potential(x) / scale)
        exact = np.sqrt(np.sum(weight * x**2) / np.sum(weight))
        assert law.tip_rms == pytest.approx(exact, rel=2e-3)  # 120 points over four decades
        assert float(law.mean(law.power)) == pytest.approx(level / 4.0, rel=2e-3)


def test_input_power_equals_dissipated_power():
    """No flux of probability: the slope of the density against the diffusion, both from different values."""
    rng = np.random.default_rng(152)
    for _ in range(6):
        mode = random_mode(rng)
        for level in 10.0 ** rng.uniform(-4, 2, 2):
            shaped = lambda f, level=level: level * (f / 50.0) ** 1.5  # noqa: E731
            for psd in (flat(level), shaped):
                law = amplitude_density(mode, psd)
                assert law.input_power == pytest.approx(float(law.mean(law.power)), rel=1e-3)  # h^2 of 480 cells


def test_weights_of_the_backbone_give_the_rms():
    """The rms of a quantity from weights of the points, against the interpolated amplitude at all Gauss points."""
    rng = np.random.default_rng(153)
    mode = random_mode(rng)
    for level in (1e-3, 1.0, 1e3):
        law = amplitude_density(mode, flat(level))
        assert float(law.rms(mode.tip)) == pytest.approx(law.tip_rms, rel=1e-3)
        work = 4.0 * np.pi * mode.damping * mode.energy
        assert law.mean_power(work) == pytest.approx(float(law.mean(law.power)), rel=1e-3)
        assert law.weights.min() >= 0.0


def test_the_level_at_a_limit_inverts_the_response():
    """rms(factor) = limit to 1e-6, from far above and far below, in a mode whose damping rises and falls."""
    mode = random_mode(np.random.default_rng(154))
    rms = lambda factor: amplitude_density(mode, flat(1e-2 * factor)).tip_rms  # noqa: E731
    for target in (1e-7, 1e-5, 1e-3):
        assert rms(factor_at_limit(rms, target)) == pytest.approx(target, rel=1e-6)
    with pytest.raises(InputError, match="must be positive"):
        factor_at_limit(rms, 0.0)
    with pytest.raises(InputError, match="is not reached"):
        factor_at_limit(lambda factor: 1.0, 2.0)


def test_a_backbone_without_a_stationary_response_is_refused():
    """No PSD at the resonance, no damping, energy that does not increase: one line each."""
    a, w = np.array([1e-6, 1e-5, 1e-4]), np.full(3, 600.0)
    good = NonlinearMode.of_oscillator(a, w, [0.01] * 3)
    with pytest.raises(InputError, match="the PSD is zero at the resonance"):
        amplitude_density(good, flat(0.0))
    with pytest.raises(InputError, match="no damping at its largest amplitude"):
        amplitude_density(NonlinearMode.of_oscillator(a, w, [0.01, 0.0, 0.0]), flat(1.0))
    with pytest.raises(InputError, match="internal resonance"):
        NonlinearMode.of_oscillator(a[::-1], w, [0.01] * 3)
    with pytest.raises(InputError, match="must be positive"):
        NonlinearMode.of_oscillator(a, w, [0.01] * 3, participation=0.0)
    with pytest.raises(InputError, match="finite and of equal length"):
        NonlinearMode.of_oscillator(a, [600.0, np.nan, 600.0], [0.01] * 3)


def test_a_mode_that_sticks_without_damping_is_carried_by_its_slip():
    """Damping zero below the onset of slip: the amplitude grows to the slip, and the powers still agree."""
    a = np.geomspace(1e-7, 1e-3, 200)
    zeta = np.where(a < 1e-5, 0.0, 0.05 * (1.0 - 1e-5 / a) * 1e-5 / a)
    law = amplitude_density(NonlinearMode.of_oscillator(a, np.full(200, 900.0), zeta), flat(1e-4))
    assert float(law.mean(law.power)) == pytest.approx(1e-4 / 4.0, rel=1e-3)
    assert law.tip_rms > 0.5e-5
