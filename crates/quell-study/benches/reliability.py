"""Other optimisers on the objectives of reliability.rs, by evaluations until the target is met (20 seeds).

    cargo bench -p quell-study --bench reliability --no-run    # says where the executable is
    python3 reliability.py EXECUTABLE [--most EVALUATIONS] [PROBLEM ...]

Needs numpy, scipy, cma and nlopt. Every method works in the unit cube of scaled coordinates that Quell's own search uses, is
begun anew with more effort (or from another random point) when it ends without the optimum, and gives up at 60,000
evaluations, or as many as said: some methods take hours for problems with constraints, and a smaller number still shows who needs
more. Constraints: SciPy's own rules, pycma's augmented Lagrangian, NLopt's COBYLA takes them as they are.
"""

import subprocess
import sys
import time
import warnings

import numpy as np

warnings.filterwarnings("ignore")
import cma  # noqa: E402
import nlopt  # noqa: E402
from scipy.optimize import NonlinearConstraint, differential_evolution  # noqa: E402

SEEDS = range(1, 21)
most = 60_000
FEASIBLE = 1e-6
# What a failed simulation counts as: far above every value, for methods that want numbers.
FAILED = 1e6


class Met(Exception):
    """The target is met, or the budget is spent."""


class Objective:
    def __init__(self, executable, name):
        self.server = subprocess.Popen([executable, "serve", name], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        target, variables, constraints = self.server.stdout.readline().split()
        self.target, self.variables, self.constraints = float(target), int(variables), int(constraints)

    def begin(self):
        self.evaluations, self.hit, self.last = 0, None, None

    def __call__(self, u):
        u = np.clip(np.asarray(u, float), 0.0, 1.0)
        if self.last is not None and np.array_equal(self.last[0], u):
            return self.last[1]
        if self.hit is not None or self.evaluations >= most:
            raise Met
        self.server.stdin.write(" ".join(f"{x:.17g}" for x in u) + "\n")
        self.server.stdin.flush()
        numbers = np.array([float(word) for word in self.server.stdout.readline().split()])
        self.evaluations += 1
        if np.all(np.isfinite(numbers)) and np.all(numbers[1:] <= FEASIBLE) and numbers[0] <= self.target:
            self.hit = self.evaluations
        scale = max(abs(self.target), 1e-300)
        numbers[0] /= scale
        numbers = np.where(np.isfinite(numbers), numbers, FAILED)
        self.last = (u.copy(), numbers)
        if self.hit is not None:
            raise Met
        return numbers


def evolution(objective, seed):
    n = objective.variables
    for again in range(100):
        kwargs = {}
        if objective.constraints:
            kwargs["constraints"] = NonlinearConstraint(lambda u: objective(u)[1:], -np.inf, FEASIBLE)
        differential_evolution(lambda u: objective(u)[0], [(0, 1)] * n, seed=1000 * again + seed, polish=False,
                               popsize=15 * (1 + again), maxiter=2000, tol=1e-8, **kwargs)


def covariance(objective, seed):
    n = objective.variables
    rng = np.random.default_rng(seed)
    population = 4 + int(3 * np.log(n))
    for again in range(100):
        options = {"bounds": [0, 1], "seed": 1000 * again + seed, "verbose": -9, "popsize": population * 2**again, "tolfun": 1e-9}
        start = rng.uniform(size=n)
        if objective.constraints:
            function = cma.ConstrainedFitnessAL(lambda u: objective(u)[0], lambda u: objective(u)[1:], find_feasible_first=False)
        else:
            function = lambda u: objective(u)[0]  # noqa: E731
        cma.fmin2(function, start, 0.3, options)


def local(objective, seed):
    n = objective.variables
    rng = np.random.default_rng(seed)
    if objective.constraints:
        while True:
            search = nlopt.opt(nlopt.LN_COBYLA, n)
            search.set_min_objective(lambda u, _: float(objective(u)[0]))
            for j in range(objective.constraints):
                search.add_inequality_constraint(lambda u, _, j=j: float(objective(u)[1 + j]), 0.0)
            search.set_lower_bounds(0.0)
            search.set_upper_bounds(1.0)
            search.set_initial_step(0.15)
            search.set_ftol_rel(1e-9)
            search.set_maxeval(4000)
            search.optimize(rng.uniform(size=n))
    nlopt.srand(seed)
    search = nlopt.opt(nlopt.G_MLSL_LDS, n)
    inner = nlopt.opt(nlopt.LN_BOBYQA, n)
    inner.set_ftol_rel(1e-9)
    search.set_local_optimizer(inner)
    search.set_min_objective(lambda u, _: float(objective(u)[0]))
    search.set_lower_bounds(0.0)
    search.set_upper_bounds(1.0)
    search.set_maxeval(most)
    search.optimize(rng.uniform(size=n))


METHODS = {"SciPy differential evolution": evolution, "pycma (restarts)": covariance, "NLopt (MLSL+BOBYQA, COBYLA)": local}


def main():
    global most
    executable, *names = sys.argv[1:]
    if names[:1] == ["--most"]:
        most, names = int(names[1]), names[2:]
    names = names or ["absorber", "passageways", "ride", "touch-down", "two stages"]
    print("problem       method                        hits   median   95 %   seconds: median")
    for name in names:
        objective = Objective(executable, name)
        for title, method in METHODS.items():
            hits = []
            for seed in SEEDS:
                objective.begin()
                begun = time.perf_counter()
                try:
                    method(objective, seed)
                except Met:
                    pass
                except Exception as error:  # a method may give up in its own way
                    if objective.hit is None and not isinstance(error, (nlopt.RoundoffLimited, RuntimeError, ValueError, nlopt.ForcedStop)):
                        raise
                if objective.hit is not None:
                    hits.append((objective.hit, time.perf_counter() - begun))
            hits.sort()
            at = lambda share: hits[k][0] if (k := int(np.ceil(share * len(SEEDS))) - 1) < len(hits) else "-"  # noqa: E731
            seconds = hits[len(hits) // 2][1] if hits else float("nan")
            print(f"{name:12}  {title:28}  {len(hits):2}/20  {at(0.5):>6}  {at(0.95):>6}  {seconds:10.3f}", flush=True)


if __name__ == "__main__":
    main()
