"""Times AUTO-07p on the work of the benchmark `continuation`, beside that benchmark, on the machine at hand.

    AUTO_DIR=/path/to/auto-07p python crates/quell-continuation/benches/auto.py

AUTO (https://github.com/auto-07p/auto-07p) must be built there and gfortran be found. Rust's side is
`cargo bench -p quell-continuation`; both are run in turn, and the least time of each counts. A point is a point of a branch, with
stability and special points sought on both sides; AUTO takes differences for derivatives, as it does for most of its users.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROUNDS = 5

FRAME = """
      SUBROUTINE FUNC(NDIM,U,ICP,PAR,IJAC,F,DFDU,DFDP)
      IMPLICIT NONE
      INTEGER, INTENT(IN) :: NDIM, ICP(*), IJAC
      DOUBLE PRECISION, INTENT(IN) :: U(NDIM), PAR(*)
      DOUBLE PRECISION, INTENT(OUT) :: F(NDIM)
      DOUBLE PRECISION, INTENT(INOUT) :: DFDU(NDIM,NDIM), DFDP(NDIM,*)
{field}
      END SUBROUTINE FUNC

      SUBROUTINE STPNT(NDIM,U,PAR,T)
      IMPLICIT NONE
      INTEGER, INTENT(IN) :: NDIM
      DOUBLE PRECISION, INTENT(INOUT) :: U(NDIM),PAR(*)
      DOUBLE PRECISION, INTENT(IN) :: T
{start}
      END SUBROUTINE STPNT

      SUBROUTINE BCND
      END SUBROUTINE BCND
      SUBROUTINE ICND
      END SUBROUTINE ICND
      SUBROUTINE FOPT
      END SUBROUTINE FOPT
      SUBROUTINE PVLS
      END SUBROUTINE PVLS
"""

LORENZ = FRAME.format(
    field="""
      F(1) = 10*(U(2)-U(1))
      F(2) = PAR(1)*U(1) - U(2) - U(1)*U(3)
      F(3) = U(1)*U(2) - 8d0/3d0*U(3)
""",
    start="""
      PAR(1) = 28
      U(1) = SQRT(72d0)
      U(2) = SQRT(72d0)
      U(3) = 27
""",
)

FEEDBACK = FRAME.format(
    field="""
      F(1) = U(2)
      F(2) = U(3)
      F(3) = -PAR(1)*U(3) - PAR(2)*U(2) - U(1) + U(1)**2
""",
    start="""
      PAR(1) = 1.2d0
      PAR(2) = 1
      U = 0
""",
)

# Coefficients are folded by the compiler, as they are in Rust.
SECTION = FRAME.format(
    field="""
      DOUBLE PRECISION, PARAMETER :: pi = 3.14159265358979323846d0
      DOUBLE PRECISION, PARAMETER :: b=.15d0, a=-.5d0, rho=1.204d0, mw=5.3d0, mt=16.9d0, ia=.1724d0, ca=.5628d0
      DOUBLE PRECISION, PARAMETER :: ch=14.5756d0, ka=54.1162d0, ka2=751.6d0, kh=3529.4d0, xa=.24d0
      DOUBLE PRECISION, PARAMETER :: c0=1, c1=.165d0, c2=.0455d0, c3=.335d0, c4=.3d0, cc=c0-c1-c3
      DOUBLE PRECISION, PARAMETER :: m11=mt+pi*rho*b**2, m12=mw*xa*b-a*pi*rho*b**3
      DOUBLE PRECISION, PARAMETER :: m22=ia+pi*(.125d0+a*a)*rho*b**4, det=m11*m22-m12*m12
      DOUBLE PRECISION v, v2, v3, r1, r2
      v = PAR(1)
      v2 = v*v
      v3 = v2*v
      r1 = -((ch+2*pi*rho*b*cc*v)*U(4) + (1+cc*(1-2*a))*pi*rho*b**2*v*U(5) + 2*pi*rho*b*(c1*c2+c3*c4)*v2*U(6) &
        + kh*U(1) + 2*pi*rho*b*cc*v2*U(2) + 2*pi*rho*c2*c4*(c1+c3)*v3*U(3))
      r2 = -(-2*pi*(a+.5d0)*rho*b**2*cc*v*U(4) + (ca+(.5d0-a)*(1-cc*(1+2*a))*pi*rho*b**3*v)*U(5) &
        - 2*pi*rho*b**2*(a+.5d0)*(c1*c2+c3*c4)*v2*U(6) + (ka-2*pi*(.5d0+a)*rho*cc*b**2*v2)*U(2) &
        - 2*pi*rho*b*(a+.5d0)*c2*c4*(c1+c3)*v3*U(3) + ka2*U(2)**2 + PAR(2)*U(2)**3)
      F(1) = U(4)
      F(2) = U(5)
      F(3) = U(6)
      F(4) = (m22*r1 - m12*r2)/det
      F(5) = (m11*r2 - m12*r1)/det
      F(6) = U(4)/b - (a-.5d0)*U(5) - (c2+c4)/b*v*U(6) + v*U(2)/b - c2*c4/b**2*v2*U(3)
""",
    start="""
      PAR(1) = 16
      PAR(2) = 5006.7d0
      U = 0
""",
)

# The forcing is an oscillator of its own, as AUTO needs it; without force the orbit is known.
FORCED = FRAME.format(
    field="""
      DOUBLE PRECISION, PARAMETER :: eps=.05d0, mu1=.001d0, lam=.95237204434d0, mu2=.13393772652d0, b3=.0833333d0
      DOUBLE PRECISION d, r, s
      d = U(1) - U(2)
      r = 2*mu2*lam*(U(3)-U(4)) + lam**2*d + b3*d**3
      s = U(5)**2 + U(6)**2
      F(1) = U(3)
      F(2) = U(4)
      F(3) = PAR(2)*U(5) - 2*mu1*U(3) - U(1) - U(1)**3 - eps*r
      F(4) = r
      F(5) = U(5) - PAR(1)*U(6) - U(5)*s
      F(6) = U(6) + PAR(1)*U(5) - U(6)*s
""",
    start="""
      PAR(1) = .7d0
      PAR(2) = 0
      PAR(11) = 2*3.14159265358979323846d0/PAR(1)
      U = 0
      U(5) = COS(2*3.14159265358979323846d0*T)
      U(6) = SIN(2*3.14159265358979323846d0*T)
""",
)

EVERY = """
NCOL=4, IAD=3, IPLT=0, NBC=0, NINT=0, NPR=10000, MXBF=0, IID=2, ITMX=9, ITNW=7, NWTN=3, JAC=0, ISP=2
EPSS=1e-7, IADS=1, NPAR=12, THL={11: 0.0}, THU={}
"""

# A curve begins with five points that only make its starting data, and is started again from the last.
#
# name in the Rust benchmark: (source, states, intervals, runs); a run is the kind of point it starts from, and constants.
WORK = {
    "lorenz_cycles_35": (LORENZ, 3, 35, [
        (None, "IPS=1, ICP=[1], ISW=1, ILP=1, NMX=200, DS=-.05, DSMIN=1e-4, DSMAX=.5, UZSTOP={1: [20, 28.1]}"),
        (3, "IPS=2, ICP=[1,11], ISW=1, ILP=1, NMX=100, DS=.05, DSMIN=1e-5, DSMAX=.5, UZSTOP={1: [14.5, 28]}"),
    ]),
    "section_cycles_60": (SECTION, 6, 60, [
        (None, "IPS=1, ICP=[1], ISW=1, ILP=1, NMX=200, DS=.05, DSMIN=1e-4, DSMAX=.5, UZSTOP={1: 19}"),
        (3, "IPS=2, ICP=[1,11], ISW=1, ILP=1, NMX=100, DS=.005, DSMIN=1e-5, DSMAX=.1, UZSTOP={1: [12, 18.5]}"),
    ]),
    "section_fold_curve_60": (SECTION, 6, 60, [
        (None, "IPS=1, ICP=[1], ISW=1, ILP=1, NMX=200, DS=.05, DSMIN=1e-4, DSMAX=.5, UZSTOP={1: 19}"),
        (3, "IPS=2, ICP=[1,11], ISW=1, ILP=1, NMX=100, DS=.005, DSMIN=1e-5, DSMAX=.1, UZSTOP={1: [12, 18.5]}"),
        (5, "IPS=2, ICP=[1,2,11], ISW=2, ILP=0, NMX=60, DS=1, DSMIN=1e-5, DSMAX=60, UZSTOP={1: [10, 17], 2: [2000, 9000]}"),
        (9, "IPS=2, ICP=[1,2,11], ISW=2, ILP=0, NMX=60, DS=1, DSMIN=1e-5, DSMAX=60, UZSTOP={1: [10, 17], 2: [2000, 9000]}"),
    ]),
    "feedback_cycles_60": (FEEDBACK, 3, 60, [
        (None, "IPS=1, ICP=[1], ISW=1, ILP=1, NMX=200, DS=-.01, DSMIN=1e-4, DSMAX=.05, UZSTOP={1: .5}"),
        (3, "IPS=2, ICP=[1,11], ISW=1, ILP=1, NMX=100, DS=.01, DSMIN=1e-5, DSMAX=.05, UZSTOP={1: [.5, 1.2]}"),
    ]),
    "feedback_doubling_curve_60": (FEEDBACK, 3, 60, [
        (None, "IPS=1, ICP=[1], ISW=1, ILP=1, NMX=200, DS=-.01, DSMIN=1e-4, DSMAX=.05, UZSTOP={1: .5}"),
        (3, "IPS=2, ICP=[1,11], ISW=1, ILP=1, NMX=100, DS=.01, DSMIN=1e-5, DSMAX=.05, UZSTOP={1: [.5, 1.2]}"),
        (7, "IPS=2, ICP=[1,2,11], ISW=2, ILP=0, NMX=60, DS=.01, DSMIN=1e-5, DSMAX=.05, UZSTOP={1: [-.2, 1.2], 2: [.4, 2]}"),
        (9, "IPS=2, ICP=[1,2,11], ISW=2, ILP=0, NMX=60, DS=.01, DSMIN=1e-5, DSMAX=.05, UZSTOP={1: [-.2, 1.2], 2: [.4, 2]}"),
    ]),
    "forced_torus_curve_60": (FORCED, 6, 60, [
        (None, "IPS=2, ICP=[2,11], ISW=1, ILP=0, NMX=200, DS=.01, DSMIN=1e-5, DSMAX=.05, UZSTOP={2: .12}"),
        (4, "IPS=2, ICP=[1,11], ISW=1, ILP=0, NMX=400, DS=.01, DSMIN=1e-5, DSMAX=.05, UZSTOP={1: 1.7}"),
        (8, "IPS=2, ICP=[1,2,11,12], EPSL=1e-5, EPSU=1e-5, ISW=2, ILP=0, NMX=60, DS=.01, DSMIN=1e-5, DSMAX=.05, UZSTOP={1: [.7, 2], 2: [.05, .3]}"),
        (9, "IPS=2, ICP=[1,2,11,12], EPSL=1e-5, EPSU=1e-5, ISW=2, ILP=0, NMX=60, DS=.01, DSMIN=1e-5, DSMAX=.05, UZSTOP={1: [.7, 2], 2: [.05, .3]}"),
    ]),
}


def labels(solutions):
    """(kind, label) of every solution of a file: the header of each says how many lines follow."""
    lines = solutions.read_text().splitlines()
    found = []
    at = 0
    while at < len(lines):
        words = lines[at].split()
        found.append((abs(int(words[2])) % 10, int(words[3])))
        at += 1 + int(words[8])
    return found


def points(diagram):
    """The number of points of a branch."""
    return max(
        (abs(int(line.split()[1])) for line in diagram.read_text().splitlines() if line.split()[0] != "0"),
        default=0,
    )


class Auto:
    """A problem compiled with AUTO."""

    def __init__(self, auto, folder, source):
        self.folder = folder
        (folder / "problem.f90").write_text(source)
        flags = ["gfortran", "-O3", "-fopenmp", "-w"]
        objects = [str(path) for path in sorted((auto / "lib").glob("*.o"))]
        subprocess.run(flags + ["-c", "problem.f90"], cwd=folder, check=True)
        subprocess.run(flags + ["problem.o", *objects, "-o", "problem"], cwd=folder, check=True)

    def run(self, constants):
        """Seconds and points of a run that continues with what the last one left in fort.3."""
        (self.folder / "fort.2").write_text(constants)
        for left in ("fort.7", "fort.8", "fort.9"):
            (self.folder / left).unlink(missing_ok=True)
        subprocess.run(
            ["./problem"],
            cwd=self.folder,
            check=True,
            stdout=subprocess.DEVNULL,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
        )
        # What AUTO says itself, without the start of a process.
        times = re.findall(r"Total Time\s+(\S+)", (self.folder / "fort.9").read_text())
        return sum(map(float, times)), points(self.folder / "fort.7")


def automatic(auto, work):
    """Milliseconds a point of AUTO for each piece of work, as a function that runs it once."""
    source, states, intervals, runs = work
    folder = pathlib.Path(tempfile.mkdtemp(prefix="auto-bench-"))
    problem = Auto(auto, folder, source)
    constants = ""
    sharp, dull = "EPSL=1e-9, EPSU=1e-9", "EPSL=1e-7, EPSU=1e-7"
    for number, (kind, own) in enumerate(runs):
        start = 0
        if kind is not None:
            known = [label for (of, label) in labels(folder / "fort.8") if of == kind]
            if not known:
                sys.exit(f"AUTO found no point of its kind {kind}")
            start = known[0]
            shutil.move(folder / "fort.8", folder / "fort.3")
        # With differences for derivatives AUTO does not reach 1e-9 on curves, nor 1e-6 on that of torus points.
        tolerance = "" if "EPSL" in own else dull if "ISW=2" in own else sharp
        constants = f"NDIM={states}, IRS={start}, NTST={intervals}\n{tolerance}\n{EVERY}\n{own}\n"
        if number + 1 < len(runs):
            problem.run(constants)

    def once():
        seconds, count = problem.run(constants)
        return 1e3 * seconds / count, count

    return once


def rust(name, binary):
    """Least milliseconds a point of the benchmark."""
    shown = subprocess.run(
        [binary, "--bench", "--sample-count", "5", "--sample-size", "1", f"{name}$"],
        check=True, capture_output=True, text=True,
    ).stdout
    # The second line of a benchmark holds points a second, the fastest first.
    rate, scale = re.search(r"([\d.]+) (K?)item/s", shown).groups()
    return 1e3 / (float(rate) * (1e3 if scale else 1.0))


def benchmark():
    """The compiled benchmark."""
    told = subprocess.run(
        ["cargo", "bench", "-p", "quell-continuation", "--bench", "continuation", "--no-run"],
        check=True, capture_output=True, text=True,
    ).stderr
    return re.search(r"\((\S*continuation-\w+)\)", told).group(1)


def main():
    auto = os.environ.get("AUTO_DIR")
    if not auto or not (pathlib.Path(auto) / "lib").is_dir():
        sys.exit("AUTO_DIR must name a built AUTO-07p")
    binary = os.path.abspath(benchmark())
    print(f"{'':30} {'AUTO':>9} {'Quell':>9} {'ratio':>7}   ms a point, the least of {ROUNDS} runs in turn")
    for name, work in WORK.items():
        once = automatic(pathlib.Path(auto), work)
        theirs, ours, count = [], [], 0
        for _ in range(ROUNDS):
            milliseconds, count = once()
            theirs.append(milliseconds)
            ours.append(rust(name, binary))
        ratio = min(theirs) / min(ours)
        print(f"{name:30} {min(theirs):9.3f} {min(ours):9.3f} {ratio:7.2f}   (AUTO: {count} points)", flush=True)


if __name__ == "__main__":
    main()
