"""Random vibration of a nonlinear mode by stochastic averaging."""
