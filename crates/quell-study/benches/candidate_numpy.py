"""The evaluation of one candidate of studies/engine-mount-linear.toml, in NumPy.

What a careful script does today: the network's impedance on a vector of frequencies, the transfer function of
the mounted mass, the largest magnitude, refined by golden section between its neighbours on the grid. The
network is the four-branch one of `candidate.rs`, track1 + restriction1 + (track2 | restriction2), with the
same number of grid points. Run by hand:

    pip install numpy
    python crates/quell-study/benches/candidate_numpy.py
"""

import time

import numpy as np

ME, KR, CR, AP, C1, C2, I0, R0 = 60.0, 2.25e5, 105.0, 2.5e-3, 3.0e-11, 2.6e-9, 3.8e6, 1.05e8
POINTS = 100
GRID = 2j * np.pi * np.linspace(30.0 / POINTS, 30.0, POINTS)


def track(s, length, area):
    return s * I0 * length / area + R0 * length / area**2


def deflection(s, x):
    pair = 1.0 / (1.0 / track(s, x[3], x[4]) + 1.0 / (x[5] * R0))
    z = track(s, x[0], x[1]) + x[2] * R0 + pair + 1.0 / (C2 * s)
    g = AP * s * z / (1.0 + C1 * s * z)
    return -ME * s**2 / (ME * s**2 + CR * s + KR + AP * g)


def peak(x):
    magnitude = np.abs(deflection(GRID, x))
    at = int(np.argmax(magnitude))
    low, high = GRID[max(at - 1, 0)], GRID[min(at + 1, POINTS - 1)]
    best = magnitude[at]
    for _ in range(8):
        points = low + (high - low) * np.array([0.25, 0.5, 0.75])
        values = np.abs(deflection(points, x))
        at = int(np.argmax(values))
        best = max(best, values[at])
        centre, width = points[at], (high - low) / 4
        low, high = centre - width, centre + width
    return best


def main():
    generator = np.random.default_rng(1)
    candidates = generator.uniform(0.5, 1.5, size=(2000, 6))
    for x in candidates[:100]:
        peak(x)
    start = time.perf_counter()
    for x in candidates:
        peak(x)
    seconds = time.perf_counter() - start
    print(f"{len(candidates) / seconds:.0f} candidate evaluations a second ({1e6 * seconds / len(candidates):.1f} us each)")
    # The optimum M41 of the source, 1.6880 at its printed parameters, shows that it is the same function.
    print(f"check: {peak([0.52, 1.19, 0.44, 1.5, 1.27, 1.90]):.4f} (1.6880)")


if __name__ == "__main__":
    main()
