"""SciPy's RK45 with an event on the struts of benches/transient.rs, for the ratio: python3 transient_scipy.py"""

import time

import numpy as np
from scipy.integrate import solve_ivp

G, W1, W2, KT, V0 = 32.18, 2411.0, 131.0, 18500.0, 8.86
C = np.cos(np.radians(12))
M1, M2 = W1 / G, W2 / G


def default(_t, x):
    ss, v = (x[0] - x[1]) / C, (x[2] - x[3]) / C
    f = C * (339.5 * v * abs(v) + 6264 * 0.05761 * (0.03545 / (0.03545 - 0.05761 * ss)) ** 1.12)
    return [x[2], x[3], (-W2 - f) / M1, (W2 + f - KT * x[1]) / M2]


def parallel(_t, x, c=171.4, b=14.558, ks=13411.0):
    ss, v = (x[0] - x[1]) / C, (x[2] - x[3]) / C
    n = C * (ks * ss + c * v)
    r1, r2 = -W2 - n, W2 + n - KT * x[1]
    d = M1 * M2 + b * (M1 + M2)
    return [x[2], x[3], ((M2 + b) * r1 + b * r2) / d, (b * r1 + (M1 + b) * r2) / d]


def run(f, tolerance):
    """To the first fall of the stroke's rate through zero after it has been positive."""
    armed = [False]

    def event(_t, x):
        v = x[2] - x[3]
        if v > 1e-6:
            armed[0] = True
        return v if armed[0] else 1.0

    event.terminal, event.direction = True, -1
    return solve_ivp(f, (0, 1), [0, 0, V0, V0], method="RK45", rtol=tolerance, atol=tolerance * 1e-2, events=event)


for name, f in (("linear", parallel), ("default", default)):
    for tolerance in (1e-6, 1e-8):
        best, result = np.inf, None
        for _ in range(20):
            begin = time.perf_counter()
            result = run(f, tolerance)
            best = min(best, time.perf_counter() - begin)
        print(f"{name:8} rtol {tolerance:g}: {best * 1e3:8.2f} ms, {result.nfev} evaluations, t_end {result.t[-1]:.7f}")
