"""Semi-analytical shell elements of a tube: Fourier terms in theta, quadratic line elements along z."""
